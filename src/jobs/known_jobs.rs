//! Jobs lately read, each of its own tenant: what a fit needs of its job.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use super::{callers::Owned, job::Job};

/// Changes so far, to be remembered before a job is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Changes(u64);

#[derive(Default)]
pub struct KnownJobs(Mutex<Known>);

#[derive(Default)]
struct Known {
    jobs: HashMap<Owned, Arc<Job>>,
    changes: u64,
}

impl KnownJobs {
    const MOST: usize = 1024;
    /// Bytes of text of a job that is kept: all of them together are 16 MiB.
    const LONGEST: usize = 16 << 10;

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the job, or the changes so far.
    pub fn get(&self, job: &Owned) -> Result<Arc<Job>, Changes> {
        let known = self.lock();
        known.jobs.get(job).cloned().ok_or(Changes(known.changes))
    }

    /// Keeps a job that was read after so many changes, unless there was another one since then.
    pub fn keep(&self, job: Owned, read: Arc<Job>, Changes(before): Changes) {
        let mut known = self.lock();
        if known.changes != before || read.text_length() > Self::LONGEST {
            return;
        }
        if known.jobs.len() >= Self::MOST {
            known.jobs.clear();
        }
        known.jobs.insert(job, read);
    }

    /// Forgets a job that has changed.
    pub fn forget(&self, job: &Owned) {
        let mut known = self.lock();
        known.changes += 1;
        known.jobs.remove(job);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use jiff::Timestamp;
    use uuid::Uuid;

    use super::*;
    use crate::jobs::{JobStatus, Tenant};

    fn job(id: Uuid, name: String) -> (Owned, Arc<Job>) {
        let at = Timestamp::UNIX_EPOCH;
        let job = Job {
            id,
            name,
            part_number: None,
            serial_number: None,
            machine: None,
            gear: None,
            requirements: None,
            tags: BTreeMap::new(),
            status: JobStatus::New,
            version: 1,
            created_at: at,
            updated_at: at,
            purged_at: None,
        };
        (Owned { tenant: Tenant::default(), id }, Arc::new(job))
    }

    #[test]
    fn a_job_that_was_read_before_a_change_is_not_kept() {
        let known = KnownJobs::default();
        let (owned, read) = job(Uuid::from_u128(1), "a".to_owned());
        let before = known.get(&owned).unwrap_err();
        known.forget(&owned);
        known.keep(owned.clone(), read.clone(), before);
        let now = known.get(&owned).unwrap_err();
        known.keep(owned.clone(), read.clone(), now);
        assert_eq!(known.get(&owned), Ok(read));
        known.forget(&owned);
        assert!(known.get(&owned).is_err());
    }

    #[test]
    fn no_more_and_no_longer_jobs_are_kept_than_memory_is_for() {
        let known = KnownJobs::default();
        for k in 0..=KnownJobs::MOST {
            let (owned, read) = job(Uuid::from_u128(k as u128), "a".repeat(KnownJobs::LONGEST));
            let now = known.get(&owned).unwrap_err();
            known.keep(owned, read, now);
        }
        assert_eq!(known.lock().jobs.len(), 1);
        let (owned, read) = job(Uuid::from_u128(1), "a".repeat(KnownJobs::LONGEST + 1));
        let now = known.get(&owned).unwrap_err();
        known.keep(owned.clone(), read, now);
        assert_eq!(known.get(&owned), Err(now));
    }
}
