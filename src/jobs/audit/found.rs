//! Rows as they are found in a store, by their places.

use std::collections::BTreeMap;

use uuid::Uuid;

use super::{
    changing::Versioned,
    layout::{Fields, Sha256Digest},
};

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

/// A stream, as far as it stays the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FoundStream {
    pub digest: Sha256Digest,
    /// Whether its blocks are still there.
    pub open: bool,
}

/// Digests of the rows of a job, or of a tenant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// The job's own; none of one that was deleted.
    pub job: Option<Versioned>,
    /// Whether there are entries of this job in the chain of another tenant.
    pub told_elsewhere: bool,
    /// Whether the job is listed by a status, a number of iterations or a time of its last change
    /// that its other rows contradict.
    pub listed_otherwise: bool,
    /// Those of one kind and one iteration in the order in which they were stored.
    rows: BTreeMap<(u64, Kind), Vec<Sha256Digest>>,
    pub streams: BTreeMap<Uuid, FoundStream>,
    pub blocks: BTreeMap<(Uuid, u64), Sha256Digest>,
    /// That of its purge; none of a job that was not purged.
    pub purge: Option<Sha256Digest>,
    /// Of a tenant: its own, and those of its keys and of the purges of its jobs by the names that
    /// entries give them.
    pub tenant: Option<Versioned>,
    pub keys: BTreeMap<String, Versioned>,
    pub purges: BTreeMap<String, Sha256Digest>,
}

impl Found {
    /// A job without anything that belongs to it.
    pub fn of_job(job: Versioned) -> Self {
        Found { job: Some(job), ..Found::default() }
    }

    /// The next row of a kind of an iteration.
    pub fn add(&mut self, number: u64, kind: Kind, digest: Sha256Digest) {
        self.rows.entry((number, kind)).or_default().push(digest);
    }

    /// The rows of a kind of an iteration.
    pub fn rows(&self, number: u64, kind: Kind) -> &[Sha256Digest] {
        self.rows.get(&(number, kind)).map_or(&[], Vec::as_slice)
    }

    /// Every row, by iterations and kinds.
    pub fn iter(&self) -> impl Iterator<Item = (u64, Kind, &[Sha256Digest])> {
        self.rows.iter().map(|(&(number, kind), rows)| (number, kind, rows.as_slice()))
    }

    /// One digest of all that is of iterations.
    pub fn digest(&self) -> Sha256Digest {
        let mut fields = Fields::default();
        for (number, kind, rows) in self.iter() {
            fields = fields.number(number).number(kind as u64).bytes(rows.as_flattened());
        }
        fields.digest()
    }

    /// One digest of all that is of streams.
    pub fn streams_digest(&self) -> Sha256Digest {
        let streams = self.streams.iter().fold(Fields::default(), |fields, (id, stream)| {
            fields.text(&id.to_string()).bytes(&stream.digest).text(if stream.open { "open" } else { "finished" })
        });
        let blocks = self.blocks.iter();
        blocks
            .fold(streams, |fields, ((stream, sequence), digest)| {
                fields.text(&stream.to_string()).number(*sequence).bytes(digest)
            })
            .digest()
    }
}
