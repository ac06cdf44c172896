//! Jobs lately seen to exist, each by its own tenant.

use std::{
    collections::HashSet,
    sync::{Mutex, PoisonError},
};

use super::callers::Owned;

#[derive(Default)]
pub struct KnownJobs {
    jobs: Mutex<HashSet<Owned>>,
}

impl KnownJobs {
    const MOST: usize = 4096;

    pub fn contains(&self, job: &Owned) -> bool {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner).contains(job)
    }

    pub fn add(&self, job: Owned) {
        let mut jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        if jobs.len() >= Self::MOST {
            jobs.clear();
        }
        jobs.insert(job);
    }

    pub fn remove(&self, job: &Owned) {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner).remove(job);
    }
}
