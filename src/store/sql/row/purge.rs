//! Purges of jobs.

use uuid::Uuid;

use crate::{
    jobs::{
        Purge, RepositoryError,
        audit::{Sha256Digest, purge_digest},
    },
    store::sql::{
        columns::{Digest, Moment},
        error::damaged,
    },
};

row! {
    /// The purge of a job as the audit finds it: with the time that stands in the job's own row,
    /// where every write looks.
    pub struct FoundJobPurge {
        purged_at: Option<Moment>,
        at: Option<Moment>,
        reason: Option<String>,
        archive_sha256: Option<Digest>,
    }
}

impl FoundJobPurge {
    /// Its digest; one of nothing where the two places do not say the same.
    pub fn digest(self, job: Uuid) -> Option<Sha256Digest> {
        let FoundJobPurge { purged_at, at, reason, archive_sha256 } = self;
        match (purged_at, at, reason, archive_sha256) {
            (None, None, None, None) => None,
            (Some(told), Some(at), Some(reason), Some(archive_sha256)) if told.0 == at.0 => {
                Some(purge_digest(job, &PurgeRow { at, reason, archive_sha256 }.into()))
            }
            _ => Some([0; 32]),
        }
    }
}

row! {
    pub struct PurgeRow {
        at: Moment,
        reason: String,
        archive_sha256: Digest,
    }
}

impl From<PurgeRow> for Purge {
    fn from(PurgeRow { at, reason, archive_sha256 }: PurgeRow) -> Self {
        Purge { at: at.0, reason, archive_sha256: archive_sha256.0 }
    }
}

impl PurgeRow {
    /// What is told of what is no longer there. Where there is no purge, it was lost otherwise.
    pub fn refusal(row: Option<Self>) -> RepositoryError {
        match row {
            Some(PurgeRow { at, reason, .. }) => RepositoryError::Purged { at: at.0, reason },
            None => RepositoryError::Failed(damaged("a row of a job", "empty, but the job was not purged")),
        }
    }
}

row! {
    /// A purge of one of a tenant's jobs.
    pub struct FoundPurge {
        @purge: PurgeRow,
        job: Uuid,
    }
}

impl FoundPurge {
    /// Its name in entries, and its digest.
    pub fn told(self) -> (String, Sha256Digest) {
        (purge_name(self.job), purge_digest(self.job, &self.purge.into()))
    }
}

/// What entries of a tenant's chain call a purge.
pub fn purge_name(job: Uuid) -> String {
    format!("purge.{job}")
}

row! {
    /// A job's purge, where a write looks the job up.
    pub struct JobPurge {
        purged_at: Option<Moment>,
        purge_reason: Option<String>,
    }
}

impl JobPurge {
    /// A purged job takes nothing more.
    pub fn refuse(&self) -> Result<(), RepositoryError> {
        match self.purged_at {
            None => Ok(()),
            Some(Moment(at)) => {
                let reason = self.purge_reason.clone().unwrap_or_default();
                Err(RepositoryError::Purged { at, reason })
            }
        }
    }
}
