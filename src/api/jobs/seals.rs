//! Seals as they are kept in files: a JSON object a line.

use super::audit::SealBody;
use crate::{
    api::json::writer::text_of,
    jobs::{
        Tenant,
        audit::{Link, Seal, Signed},
        rows::of_hex,
    },
};

/// Returns the line of a seal, with its end.
pub fn line(seal: &Seal) -> String {
    text_of(&SealBody::from(seal)) + "\n"
}

/// Returns the seal of a line, or of an item of the interface.
pub fn read(line: &str) -> Result<Seal, String> {
    let body: SealBody = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let read = || {
        let signed = match (&body.signature, &body.public_key) {
            (None, None) => None,
            (Some(signature), Some(key)) => Some(Signed { public_key: bytes(key)?, signature: bytes(signature)? }),
            _ => return None,
        };
        Some(Seal {
            tenant: Tenant::kept(&body.tenant)?,
            number: body.number,
            at: body.at.parse().ok()?,
            last: Link { number: body.last_entry, sha256: bytes(&body.last_sha256)? },
            previous: bytes(&body.previous)?,
            sha256: bytes(&body.sha256)?,
            signed,
        })
    };
    read().ok_or_else(|| "a digest, the time or the tenant is invalid".to_owned())
}

/// Returns the bytes of hexadecimal digits.
fn bytes<const N: usize>(digits: &str) -> Option<[u8; N]> {
    of_hex(digits)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back() {
        let last = Link { number: 3, sha256: [9; 32] };
        let made = Seal::next(&Tenant::root(), None, last, "2026-11-23T09:21:33.5Z".parse().unwrap(), None);
        let text = line(&made);
        assert!(text.ends_with("}\n") && text.lines().count() == 1, "{text}");
        assert_eq!(read(&text), Ok(made));
        for (wrong, why) in [("", "EOF"), ("{}", "missing field"), (&text.replace("0909", "09g9"), "a digest")] {
            assert!(read(wrong).is_err_and(|error| error.contains(why)), "{wrong}");
        }
    }
}
