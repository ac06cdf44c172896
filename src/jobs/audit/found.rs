//! Rows as they are found in a store, by their places.

use std::collections::BTreeMap;

use super::layout::{Fields, Sha256Digest};

/// The tables whose rows entries have digests of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Iteration,
    Nodes,
    Fit,
    Choice,
    Decision,
    Record,
}

/// Digests of the rows of a job: those of one kind and one iteration in the order in which they
/// were stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found(BTreeMap<(u64, Kind), Vec<Sha256Digest>>);

impl Found {
    /// The next row of a kind of an iteration.
    pub fn add(&mut self, number: u64, kind: Kind, digest: Sha256Digest) {
        self.0.entry((number, kind)).or_default().push(digest);
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rows of a kind of an iteration.
    pub fn rows(&self, number: u64, kind: Kind) -> &[Sha256Digest] {
        self.0.get(&(number, kind)).map_or(&[], Vec::as_slice)
    }

    /// Every row, by iterations and kinds.
    pub fn iter(&self) -> impl Iterator<Item = (u64, Kind, &[Sha256Digest])> {
        self.0.iter().map(|(&(number, kind), rows)| (number, kind, rows.as_slice()))
    }

    /// One digest of them all.
    pub fn digest(&self) -> Sha256Digest {
        let mut fields = Fields::default();
        for (number, kind, rows) in self.iter() {
            fields = fields.number(number).number(kind as u64).bytes(rows.as_flattened());
        }
        fields.digest()
    }
}
