//! The tasks that this process does at present.

use std::{
    collections::HashMap,
    sync::{Mutex, MutexGuard, PoisonError},
};

use uuid::Uuid;

use crate::{jobs::Lease, pool::Handle};

/// See the module's documentation.
#[derive(Debug, Default)]
pub struct Running(Mutex<HashMap<Uuid, (Lease, Handle)>>);

/// A task that is being done; it is no more when this is dropped.
#[derive(Debug)]
pub struct Doing<'a> {
    running: &'a Running,
    lease: Lease,
}

impl Drop for Doing<'_> {
    fn drop(&mut self) {
        self.running.end(self.lease);
    }
}

impl Running {
    fn lock(&self) -> MutexGuard<'_, HashMap<Uuid, (Lease, Handle)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on the lease is renewed.
    pub fn begin(&self, lease: Lease, handle: Handle) -> Doing<'_> {
        self.lock().insert(lease.task, (lease, handle));
        Doing { running: self, lease }
    }

    /// Unless another has taken its place.
    fn end(&self, lease: Lease) {
        let mut all = self.lock();
        if all.get(&lease.task).is_some_and(|(own, _)| *own == lease) {
            all.remove(&lease.task);
        }
    }

    /// How far a task is that is done here.
    pub fn progress(&self, task: Uuid) -> Option<f64> {
        self.lock().get(&task).map(|(_, handle)| handle.progress())
    }

    /// Every lease, with how far its task is.
    pub fn leases(&self) -> Vec<(Lease, f64)> {
        self.lock().values().map(|(lease, handle)| (*lease, handle.progress())).collect()
    }

    /// Cancels those of the leases that do not hold.
    pub fn cancel_lost(&self, asked: &[(Lease, f64)], held: &[Lease]) {
        let all = self.lock();
        for (lease, _) in asked.iter().filter(|(lease, _)| !held.contains(lease)) {
            if let Some((own, handle)) = all.get(&lease.task)
                && own == lease
            {
                handle.cancel();
            }
        }
    }
}
