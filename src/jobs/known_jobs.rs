//! Jobs lately seen to exist.

use std::{
    collections::HashSet,
    sync::{Mutex, PoisonError},
};

use uuid::Uuid;

#[derive(Default)]
pub struct KnownJobs {
    ids: Mutex<HashSet<Uuid>>,
}

impl KnownJobs {
    const MOST: usize = 4096;

    pub fn contains(&self, id: Uuid) -> bool {
        self.ids.lock().unwrap_or_else(PoisonError::into_inner).contains(&id)
    }

    pub fn add(&self, id: Uuid) {
        let mut ids = self.ids.lock().unwrap_or_else(PoisonError::into_inner);
        if ids.len() >= Self::MOST {
            ids.clear();
        }
        ids.insert(id);
    }

    pub fn remove(&self, id: Uuid) {
        self.ids.lock().unwrap_or_else(PoisonError::into_inner).remove(&id);
    }
}
