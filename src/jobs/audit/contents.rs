//! The digests of the rows of a change, by the names of the rows.

use std::{iter, sync::Arc};

use super::layout::Sha256Digest;

/// Digests by names, in the order of the names, as they are stored and digested: for each one byte
/// for the length of its name, the name, and the 32 bytes of the digest. A copy is the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents(Arc<[u8]>);

impl Contents {
    /// Contents of some rows. Names are at most 255 bytes; of two that are the same the last one
    /// counts.
    pub fn of<N: AsRef<str>>(rows: Vec<(N, Sha256Digest)>) -> Self {
        let mut rows: Vec<_> = rows.into_iter().rev().collect();
        rows.sort_by(|(one, _), (other, _)| one.as_ref().cmp(other.as_ref()));
        rows.dedup_by(|(one, _), (other, _)| one.as_ref() == other.as_ref());
        let mut bytes = Vec::with_capacity(rows.iter().map(|(name, _)| name.as_ref().len() + 33).sum());
        for (name, digest) in &rows {
            bytes.push(name.as_ref().len() as u8);
            bytes.extend_from_slice(name.as_ref().as_bytes());
            bytes.extend_from_slice(digest);
        }
        Contents(bytes.into())
    }

    pub fn iter(&self) -> impl Iterator<Item = (&str, &Sha256Digest)> {
        let mut rest = self.bytes();
        iter::from_fn(move || {
            let (name, digest, behind) = first(rest)?;
            rest = behind;
            Some((name, digest))
        })
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

/// Returns name and digest of the first row, and the bytes after it.
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
    fn contents_come_back_in_the_order_of_their_names() {
        let row = |name: &str, byte| (name.to_owned(), [byte; 32]);
        let contents = Contents::of(vec![row("nodes", 2), row("fit", 1)]);
        assert_eq!(contents.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["fit", "nodes"]);
        let bytes = contents.bytes().to_vec();
        assert_eq!(bytes.len(), 3 + 5 + 2 * 33);
        assert_eq!(Contents::read(&bytes), Some(contents));
        assert_eq!(Contents::read(&[]), Some(Contents::default()));
        assert!((1..bytes.len()).filter(|cut| *cut != 36).all(|cut| Contents::read(&bytes[..cut]).is_none()));
        let twice = [&bytes[..37], &bytes[..37]].concat();
        assert_eq!(Contents::read(&twice), None);
    }
}
