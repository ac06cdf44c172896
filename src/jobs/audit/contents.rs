//! What an entry says of the rows of its change: the digest of each, by a name.

use super::layout::Sha256Digest;

/// Digests by names, in the order of these.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents(Vec<(String, Sha256Digest)>);

impl Contents {
    /// Of some rows. Names are at most 255 bytes, and no two are the same.
    pub fn of(mut rows: Vec<(String, Sha256Digest)>) -> Self {
        rows.sort_unstable();
        Contents(rows)
    }

    pub fn one(name: &str, digest: Sha256Digest) -> Self {
        Contents(vec![(name.to_owned(), digest)])
    }

    pub fn iter(&self) -> impl Iterator<Item = (&str, &Sha256Digest)> {
        self.0.iter().map(|(name, digest)| (name.as_str(), digest))
    }

    pub fn get(&self, wanted: &str) -> Option<&Sha256Digest> {
        self.iter().find(|(name, _)| *name == wanted).map(|(_, digest)| digest)
    }

    /// As they are stored, and digested: of each one byte for the length of its name, the name, and
    /// the 32 bytes of the digest.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.0.iter().map(|(name, _)| name.len() + 33).sum());
        for (name, digest) in &self.0 {
            bytes.push(name.len() as u8);
            bytes.extend_from_slice(name.as_bytes());
            bytes.extend_from_slice(digest);
        }
        bytes
    }

    /// Those of [`Contents::bytes`]; `None` for other bytes.
    pub fn read(mut bytes: &[u8]) -> Option<Self> {
        let mut rows = Vec::new();
        while let Some((length, rest)) = bytes.split_first() {
            let (name, rest) = rest.split_at_checked(usize::from(*length))?;
            let (digest, rest) = rest.split_first_chunk::<32>()?;
            rows.push((String::from_utf8(name.to_vec()).ok()?, *digest));
            bytes = rest;
        }
        let ascending = rows.windows(2).all(|pair| pair[0].0 < pair[1].0);
        ascending.then_some(Contents(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_come_back_in_the_order_of_their_names() {
        let row = |name: &str, byte| (name.to_owned(), [byte; 32]);
        let contents = Contents::of(vec![row("nodes", 2), row("fit", 1)]);
        assert_eq!(contents.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["fit", "nodes"]);
        assert_eq!(contents.get("nodes"), Some(&[2; 32]));
        let bytes = contents.bytes();
        assert_eq!(bytes.len(), 3 + 5 + 2 * 33);
        assert_eq!(Contents::read(&bytes), Some(contents));
        assert_eq!(Contents::read(&[]), Some(Contents::default()));
        assert!((1..bytes.len()).filter(|cut| *cut != 36).all(|cut| Contents::read(&bytes[..cut]).is_none()));
        let twice = [Contents::one("fit", [1; 32]).bytes(), Contents::one("fit", [1; 32]).bytes()].concat();
        assert_eq!(Contents::read(&twice), None);
    }
}
