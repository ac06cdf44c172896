//! Jobs whose nodes, results, texts and names were taken away. The row, its numbers and its times
//! stay, and so does the chain of who changed what.

use jiff::Timestamp;
use uuid::Uuid;

/// That a job was purged: when, why, and the digest of the archive that has what was taken away.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Purge {
    pub at: Timestamp,
    pub reason: String,
    pub archive_sha256: [u8; 32],
}

/// How far a job had come. Whatever is stored of a job moves one of the two on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Digest of the last entry of its chain; none before the first.
    pub head: Option<[u8; 32]>,
    /// Number of its last event, 0 before the first.
    pub last_event: u64,
}

/// A job to be purged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewPurge {
    pub job: Uuid,
    pub purge: Purge,
    /// What the job was archived as: it must not have gone on since. None where its archive is not
    /// the one that was named: then the store says why, purged meanwhile or changed.
    pub seen: Option<Seen>,
}
