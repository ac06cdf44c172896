//! Purges of jobs.

use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    jobs::{
        Purge, RepositoryError,
        audit::{Sha256Digest, purge_digest},
    },
    store::sql::error::damaged,
};

from_row! {
    Purge { at, reason, archive_sha256 }
}

row! {
    /// The purge of a job as the audit finds it: with the time in the job's own row, where every
    /// write looks.
    pub struct FoundJobPurge {
        purged_at: Option<Timestamp>,
        at: Option<Timestamp>,
        reason: Option<String>,
        archive_sha256: Option<[u8; 32]>,
    }
}

impl FoundJobPurge {
    /// Returns its digest; a digest of nothing where the two places differ.
    pub fn digest(self, job: Uuid) -> Option<Sha256Digest> {
        let FoundJobPurge { purged_at, at, reason, archive_sha256 } = self;
        match (purged_at, at, reason, archive_sha256) {
            (None, None, None, None) => None,
            (Some(told), Some(at), Some(reason), Some(archive_sha256)) if told == at => {
                Some(purge_digest(job, &Purge { at, reason, archive_sha256 }))
            }
            _ => Some([0; 32]),
        }
    }
}

/// Returns the refusal of something that was taken away. Where there is no purge, it was lost
/// otherwise.
pub fn refusal(purge: Option<Purge>) -> RepositoryError {
    match purge {
        Some(Purge { at, reason, .. }) => RepositoryError::Purged { at, reason },
        None => RepositoryError::Failed(damaged("a row of a job", "empty, but the job was not purged")),
    }
}

row! {
    /// A purge of one of a tenant's jobs.
    pub struct FoundPurge {
        @purge: Purge,
        job: Uuid,
    }
}

impl FoundPurge {
    /// Returns its name in entries, and its digest.
    pub fn told(self) -> (String, Sha256Digest) {
        (purge_name(self.job), purge_digest(self.job, &self.purge))
    }
}

/// Returns the name of a purge in the entries of a tenant's chain.
pub fn purge_name(job: Uuid) -> String {
    format!("purge.{job}")
}

row! {
    /// A job's purge, where a write looks the job up.
    pub struct JobPurge {
        purged_at: Option<Timestamp>,
        purge_reason: Option<String>,
    }
}

impl JobPurge {
    /// A purged job takes nothing more.
    pub fn refuse(&self) -> Result<(), RepositoryError> {
        match self.purged_at {
            None => Ok(()),
            Some(at) => Err(RepositoryError::Purged { at, reason: self.purge_reason.clone().unwrap_or_default() }),
        }
    }
}
