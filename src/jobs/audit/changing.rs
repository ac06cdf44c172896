//! Rows that are changed where they are: of a job, a key and a tenant. An entry has the digest of
//! the row as it left it, so only the last of them tells of what is found.

use super::{
    digests::{job_digest, key_digest, plant_digest},
    entry::{Action, Entry},
    layout::Sha256Digest,
};
use crate::jobs::{
    callers::{NewKey, Plant},
    job::Job,
};

/// Such a row as it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Versioned {
    pub digest: Sha256Digest,
    /// One more with each change.
    pub version: u64,
}

impl Versioned {
    /// One that does not read is none that an entry tells of.
    pub const UNREADABLE: Self = Versioned { digest: [0; 32], version: 0 };

    pub fn job(job: &Job) -> Self {
        Versioned { digest: job_digest(job), version: job.version }
    }

    pub fn key(new: &NewKey) -> Self {
        Versioned { digest: key_digest(new), version: new.key.version }
    }

    pub fn plant(plant: &Plant) -> Self {
        Versioned { digest: plant_digest(plant), version: plant.version }
    }
}

/// With which actions such a row begins, at version 1.
const BEGINNINGS: [Action; 4] = [Action::CreateJob, Action::CreateKey, Action::RotateKey, Action::CreateTenant];

/// Such a row as the last entry tells of it that does.
#[derive(Clone, Copy)]
pub struct LastTold {
    digest: Sha256Digest,
    by: u64,
    /// None of a row that is older than its chain: it was changed nobody knows how often.
    version: Option<u64>,
}

impl LastTold {
    /// What is known once another entry has told of the row.
    pub fn told(before: Option<&Self>, digest: Sha256Digest, entry: &Entry) -> Self {
        let begins = || BEGINNINGS.iter().any(|action| *entry.action == *action.name());
        let version = match before {
            // a key that would have ended earlier anyway was told of when it was replaced, as long
            // as it did not say by which
            Some(before) if before.digest == digest => before.version,
            Some(before) => before.version.map(|version| version + 1),
            None => begins().then_some(1),
        };
        LastTold { digest, by: entry.number, version }
    }

    /// The entry that tells of it.
    pub fn by(&self) -> u64 {
        self.by
    }

    /// The number at fault, where the row is not as it was told. If it was changed more often than
    /// entries tell, it is that behind the last entry.
    pub fn fault(&self, found: Option<&Versioned>, next: u64) -> Option<u64> {
        match found {
            Some(found) if found.digest == self.digest => None,
            Some(found) if self.version.is_some_and(|version| version < found.version) => Some(next),
            _ => Some(self.by),
        }
    }
}
