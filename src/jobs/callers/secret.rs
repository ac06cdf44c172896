//! API keys as callers send them: `ffk_<16 hex id>_<64 hex secret><8 hex CRC-32>`.
//!
//! The id finds what is kept of the key, the CRC over all before it finds slips of the pen without
//! asking anybody, and the prefix lets scanners of sources and logs find what should not be there.
//! Of the text only the SHA-256 is kept: 256 random bits need no slow digest.

use sha2::{Digest as _, Sha256};
use subtle::ConstantTimeEq as _;

use super::key::KeyId;
use crate::jobs::rows::to_hex;

pub const PREFIX: &str = "ffk_";
/// Digits of the id, of the secret and of the CRC, and where they begin.
const ID: (usize, usize) = (4, 16);
const SECRET: (usize, usize) = (21, 64);
const CRC: (usize, usize) = (85, 8);
/// Length of the whole.
const LENGTH: usize = 93;

/// A new key, whole. It can be shown once and neither printed, compared nor logged by accident:
/// there is no `Debug`, `Display` or `PartialEq`.
pub struct Secret(String);

impl Secret {
    /// A key of 256 bits from the system's generator, with its id.
    pub fn generate() -> Result<(KeyId, Self), getrandom::Error> {
        let (mut id, mut secret) = ([0; 8], [0; 32]);
        getrandom::fill(&mut id)?;
        getrandom::fill(&mut secret)?;
        let id = KeyId::of(u64::from_be_bytes(id));
        let text = format!("{PREFIX}{id}_{}", to_hex(&secret));
        let crc = crc32fast::hash(text.as_bytes());
        Ok((id, Secret(format!("{text}{crc:08x}"))))
    }

    /// The text, for the one answer that shows it.
    pub fn expose(&self) -> &str {
        &self.0
    }

    /// Returns the digest that is stored.
    pub fn sha256(&self) -> [u8; 32] {
        digest(self.0.as_bytes())
    }
}

/// The id in a key that somebody sent, where it has the form of one.
pub fn id_of(presented: &[u8]) -> Option<KeyId> {
    let text = std::str::from_utf8(presented).ok().filter(|text| text.len() == LENGTH && text.is_ascii())?;
    let part = |(from, length): (usize, usize)| &text[from..from + length];
    let lower_hex = |digits: &str| digits.bytes().all(|c| c.is_ascii_digit() || (b'a'..=b'f').contains(&c));
    let crc = crc32fast::hash(&text.as_bytes()[..CRC.0]);
    let well_formed = text.starts_with(PREFIX)
        && text.as_bytes()[SECRET.0 - 1] == b'_'
        && lower_hex(part(SECRET))
        && part(CRC) == format!("{crc:08x}");
    if well_formed { KeyId::named(part(ID)) } else { None }
}

/// Returns the digest of a key that is stored.
pub fn digest(presented: &[u8]) -> [u8; 32] {
    Sha256::digest(presented).into()
}

/// Whether two digests are the same, in a time that does not tell how much of them is. Digests of
/// keys are compared here and nowhere else.
pub fn same(kept: &[u8; 32], presented: &[u8; 32]) -> bool {
    kept.ct_eq(presented).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_read_as_it_was_made_and_in_no_other_way() {
        let (id, key) = Secret::generate().unwrap();
        let text = key.expose();
        assert_eq!((text.len(), id_of(text.as_bytes())), (LENGTH, Some(id)));
        assert!(text.starts_with(&format!("ffk_{id}_")));
        assert_eq!(key.sha256(), digest(text.as_bytes()));
        for at in 0..LENGTH {
            let mut other = text.as_bytes().to_vec();
            other[at] = if other[at] == b'0' { b'1' } else { b'0' };
            assert_eq!(id_of(&other), None, "a slip at {at}");
        }
        for other in [&text[..LENGTH - 1], &format!("{text}0"), &text.to_uppercase(), &"é".repeat(46), ""] {
            assert_eq!(id_of(other.as_bytes()), None, "{}", other.len());
        }
        assert_eq!(id_of(&[0xff; LENGTH]), None);
    }

    #[test]
    fn two_secrets_differ() {
        let (one, other) = (Secret::generate().unwrap(), Secret::generate().unwrap());
        assert!(one.0 != other.0 && one.1.expose()[SECRET.0..] != other.1.expose()[SECRET.0..]);
    }

    #[test]
    fn digests_are_the_same_in_every_byte() {
        let kept = digest(b"key");
        assert!(same(&kept, &digest(b"key")));
        for at in 0..32 {
            let mut other = kept;
            other[at] ^= 1;
            assert!(!same(&kept, &other), "{at}");
        }
    }
}
