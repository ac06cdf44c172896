//! Seals as they are kept in files: a JSON object a line.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::audit::{SealBody, hex};
use crate::{
    api::json::writer::text_of,
    jobs::{
        Tenant,
        audit::{Seal, SealedHead, Signed, WholeSeal},
    },
};

/// A seal with its heads.
#[derive(Debug, Serialize, Deserialize)]
pub struct SealLine {
    #[serde(flatten)]
    seal: SealBody,
    /// The heads, in the order of their chains.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    chains: Vec<HeadLine>,
}

/// The last entry of a chain.
#[derive(Debug, Serialize, Deserialize)]
struct HeadLine {
    chain: Uuid,
    number: u64,
    sha256: String,
}

/// The line of a seal, with its end.
pub fn line(WholeSeal { seal, heads }: &WholeSeal) -> String {
    let chains =
        heads.iter().map(|head| HeadLine { chain: head.chain, number: head.number, sha256: hex(&head.sha256) });
    let line = SealLine { seal: seal.into(), chains: chains.collect() };
    text_of(&line) + "\n"
}

/// The seal of a line; of an item of the interface, too, which has no heads.
pub fn read(line: &str) -> Result<WholeSeal, String> {
    let SealLine { seal, chains } = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let heads = chains
        .iter()
        .map(|head| Some(SealedHead { chain: head.chain, number: head.number, sha256: bytes(&head.sha256)? }));
    let signed = match (&seal.signature, &seal.public_key) {
        (None, None) => Some(None),
        (Some(signature), Some(key)) => {
            bytes(signature).zip(bytes(key)).map(|(signature, public_key)| Some(Signed { public_key, signature }))
        }
        _ => None,
    };
    let read = || {
        let heads: Option<Vec<_>> = heads.collect();
        let seal = Seal {
            tenant: Tenant::kept(&seal.tenant)?,
            number: seal.number,
            at: seal.at.parse().ok()?,
            heads: seal.heads,
            root: bytes(&seal.root)?,
            previous: bytes(&seal.previous)?,
            sha256: bytes(&seal.sha256)?,
            signed: signed?,
        };
        Some(WholeSeal { seal, heads: heads? })
    };
    read().ok_or_else(|| "a digest, the time or the tenant is none".to_owned())
}

/// The bytes of hexadecimal digits.
fn bytes<const N: usize>(digits: &str) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    let is_hex = digits.len() == 2 * N && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    for (byte, pair) in bytes.iter_mut().zip(digits.as_bytes().chunks(2)).take(if is_hex { N } else { 0 }) {
        *byte = u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok()?;
    }
    is_hex.then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back() {
        let heads = vec![SealedHead { chain: Uuid::from_u128(7), number: 3, sha256: [9; 32] }];
        let made = WholeSeal::next(Tenant::root(), None, heads, "2026-11-23T09:21:33.5Z".parse().unwrap(), None);
        let text = line(&made);
        assert!(text.ends_with("]}\n") && text.lines().count() == 1, "{text}");
        assert_eq!(read(&text), Ok(made.clone()));
        let without = serde_json::json!(SealBody::from(&made.seal)).to_string();
        assert_eq!(read(&without), Ok(WholeSeal { heads: Vec::new(), ..made }));
        for (wrong, why) in [("", "EOF"), ("{}", "missing field"), (&text.replace("0909", "09g9"), "a digest")] {
            assert!(read(wrong).is_err_and(|error| error.contains(why)), "{wrong}");
        }
    }
}
