//! What an entry says of the rows of its change: the digest of each, by a name.

use std::{iter, sync::Arc};

use super::layout::{Fields, Sha256Digest};

/// The name of the salt among the digests: it stands before all others, where SQL takes it away.
pub const SALT: &str = "_salt";

/// Digests by names, in the order of these, as they are stored and digested: of each one byte for
/// the length of its name, the name, and the 32 bytes of the digest. A copy is the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents(Arc<[u8]>);

impl Contents {
    /// Contents of some rows. Names are at most 255 bytes, and no two are the same.
    pub fn of<N: AsRef<str>>(mut rows: Vec<(N, Sha256Digest)>) -> Self {
        rows.sort_unstable_by(|(one, _), (other, _)| one.as_ref().cmp(other.as_ref()));
        let mut bytes = Vec::with_capacity(rows.iter().map(|(name, _)| name.as_ref().len() + 33).sum());
        for (name, digest) in &rows {
            bytes.push(name.as_ref().len() as u8);
            bytes.extend_from_slice(name.as_ref().as_bytes());
            bytes.extend_from_slice(digest);
        }
        Contents(bytes.into())
    }

    pub fn one(name: &str, digest: Sha256Digest) -> Self {
        Contents::of(vec![(name, digest)])
    }

    /// With a salt for the rows in which people may stand, so that nobody finds out by trying who
    /// stood in those that were purged: it goes with what it hides.
    pub fn salted(&self, salt: &Sha256Digest) -> Self {
        let rows = self.iter().map(|(name, digest)| match is_of_iteration(name) {
            true => (name, with_salt(Some(salt), digest)),
            false => (name, *digest),
        });
        Contents::of(rows.chain([(SALT, *salt)]).collect())
    }

    /// A salt of the system's generator.
    pub fn salt() -> Result<Sha256Digest, getrandom::Error> {
        let mut salt = [0; 32];
        getrandom::fill(&mut salt)?;
        Ok(salt)
    }

    pub fn iter(&self) -> impl Iterator<Item = (&str, &Sha256Digest)> {
        let mut rest = self.bytes();
        iter::from_fn(move || {
            let (name, digest, behind) = first(rest)?;
            rest = behind;
            Some((name, digest))
        })
    }

    pub fn get(&self, wanted: &str) -> Option<&Sha256Digest> {
        self.iter().find(|(name, _)| *name == wanted).map(|(_, digest)| digest)
    }

    /// As they are stored, and digested.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Those of [`Contents::bytes`]; `None` for other bytes.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (mut rest, mut last) = (bytes, None);
        while !rest.is_empty() {
            let (name, _, behind) = first(rest)?;
            if last.is_some_and(|last| last >= name) {
                return None;
            }
            (rest, last) = (behind, Some(name));
        }
        Some(Contents(bytes.into()))
    }
}

/// What stands in the contents for a row; before there were salts, its digest.
pub fn with_salt(salt: Option<&Sha256Digest>, digest: &Sha256Digest) -> Sha256Digest {
    salt.map_or(*digest, |salt| Fields::default().bytes(salt).bytes(digest).digest())
}

/// Whether it is a row of an iteration, which may have names and reasons.
fn is_of_iteration(name: &str) -> bool {
    matches!(name, "iteration" | "nodes" | "fit" | "choice" | "decision" | "record") || name.starts_with("record.")
}

/// Name and digest of the first row, and what stands behind it.
fn first(bytes: &[u8]) -> Option<(&str, &Sha256Digest, &[u8])> {
    let (length, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(usize::from(*length))?;
    let (digest, behind) = rest.split_first_chunk::<32>()?;
    Some((str::from_utf8(name).ok()?, digest, behind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_salt_stands_first_and_hides_rows_of_iterations() {
        let rows =
            ["archive", "choice", "decision", "fit", "iteration", "job", "nodes", "record", "record.01", "stream"];
        let plain = Contents::of(rows.iter().map(|name| (*name, [name.len() as u8; 32])).collect());
        let salted = plain.salted(&[7; 32]);
        assert_eq!(salted.bytes()[..38], [b"\x05_salt".as_slice(), &[7; 32]].concat());
        let same: Vec<&str> =
            plain.iter().filter(|(name, digest)| salted.get(name) == Some(*digest)).map(|(name, _)| name).collect();
        assert_eq!(same, ["archive", "job", "stream"]);
        assert_eq!(salted.get("fit"), Some(&with_salt(Some(&[7; 32]), &[3; 32])));
        // without it, as SQL takes it away, the others stay as they are
        let rest = Contents::read(&salted.bytes()[38..]).unwrap();
        assert!(rest.iter().eq(salted.iter().skip(1)) && rest.get(SALT).is_none());
        assert_ne!(Contents::salt().unwrap(), Contents::salt().unwrap());
    }

    #[test]
    fn contents_come_back_in_the_order_of_their_names() {
        let row = |name: &str, byte| (name.to_owned(), [byte; 32]);
        let contents = Contents::of(vec![row("nodes", 2), row("fit", 1)]);
        assert_eq!(contents.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["fit", "nodes"]);
        assert_eq!(contents.get("nodes"), Some(&[2; 32]));
        let bytes = contents.bytes().to_vec();
        assert_eq!(bytes.len(), 3 + 5 + 2 * 33);
        assert_eq!(Contents::read(&bytes), Some(contents));
        assert_eq!(Contents::read(&[]), Some(Contents::default()));
        assert!((1..bytes.len()).filter(|cut| *cut != 36).all(|cut| Contents::read(&bytes[..cut]).is_none()));
        let twice = [Contents::one("fit", [1; 32]).bytes(), Contents::one("fit", [1; 32]).bytes()].concat();
        assert_eq!(Contents::read(&twice), None);
    }
}
