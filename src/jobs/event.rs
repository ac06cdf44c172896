//! Events of jobs.

use std::{
    collections::HashMap,
    hash::Hash,
    sync::{Mutex, MutexGuard, PoisonError},
};

use jiff::{SignedDuration, Timestamp};
use tokio::sync::watch;
use uuid::Uuid;

use crate::jobs::*;

/// One thing that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct JobEvent {
    /// 1, 2, 3 … within the job, in the order in which things were stored; 0 where the job itself
    /// was made or deleted.
    pub number: u64,
    pub created_at: Timestamp,
    pub kind: EventKind,
}

/// Kind of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// An iteration was added, with its first fit.
    Iteration {
        number: u32,
        id: Uuid,
        fit_id: Uuid,
    },
    /// A fit was added, or chosen from now on.
    Fit {
        number: u32,
        fit_id: Uuid,
        chosen: bool,
        reason: Option<String>,
    },
    Decision {
        number: u32,
        decision: Decision,
        reason: Option<String>,
    },
    Stream {
        id: Uuid,
        state: StreamEvent,
        sequence: u64,
        node_count: u64,
        iteration: Option<u32>,
    },
    /// A record was kept with an iteration.
    Record {
        number: u32,
        id: Uuid,
        kind: RecordKind,
    },
    /// The job itself.
    Job {
        state: JobChange,
    },
    /// The job was purged: what it held is in its archive alone.
    Purged {
        reason: String,
    },
}

/// Change of a job itself. `created` and `deleted` are sent only to listeners to all jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = JobEventState)]
pub enum JobChange {
    Created,
    /// Its name, gear, requirements or other data of its own were changed.
    Changed,
    Deleted,
}

/// A place in the order of all that happens to the jobs of a tenant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EventPlace {
    /// Number of the transaction; of a store with one writer the number of the event.
    pub change: u64,
    pub number: u64,
}

/// Time for which all jobs' events are listed in their common order. (Those of a job stay.)
pub const EVENTS_TOLD: SignedDuration = SignedDuration::from_hours(7 * 24);

/// An event of some job, at its place among those of all.
#[derive(Clone, Debug, PartialEq)]
pub struct ToldEvent {
    pub place: EventPlace,
    pub job: Uuid,
    pub event: JobEvent,
}

/// Change of the stream's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = StreamEventName)]
pub enum StreamEvent {
    Open,
    Block,
    Finished,
    Deleted,
}

names! {
    JobChange { Created "created", Changed "changed", Deleted "deleted" }
    StreamEvent { Open "open", Block "block", Finished "finished", Deleted "deleted" }
}

/// Wakes the listeners of a job, or of all jobs of a tenant. It carries a count of wakes: a woken
/// listener reads the stored events after the last one seen, so no event is sent twice, and a
/// missed wake costs time, not events.
#[derive(Debug, Default)]
pub struct JobNotifier {
    jobs: Wakers<Owned>,
    tenants: Wakers<Tenant>,
}

/// Wakers of listeners by what they listen to.
#[derive(Debug)]
struct Wakers<K>(Mutex<HashMap<K, watch::Sender<u64>>>);

impl<K> Default for Wakers<K> {
    fn default() -> Self {
        Wakers(Mutex::default())
    }
}

impl<K: Eq + Hash> Wakers<K> {
    fn lock(&self) -> MutexGuard<'_, HashMap<K, watch::Sender<u64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn subscribe(&self, key: K) -> watch::Receiver<u64> {
        let mut wakers = self.lock();
        wakers.retain(|_, waker| waker.receiver_count() > 0);
        wakers.entry(key).or_insert_with(|| watch::channel(0).0).subscribe()
    }

    /// Wakes the listeners of one key, or all.
    fn wake(&self, key: Option<&K>) {
        let (wakers, wake) = (self.lock(), |waker: &watch::Sender<u64>| waker.send_modify(|wakes| *wakes += 1));
        match key {
            Some(key) => wakers.get(key).into_iter().for_each(wake),
            None => wakers.values().for_each(wake),
        }
    }
}

impl JobNotifier {
    /// Subscribes to the events of the job from now on.
    pub fn subscribe(&self, job: Owned) -> watch::Receiver<u64> {
        self.jobs.subscribe(job)
    }

    /// Subscribes to the events of all jobs of the tenant from now on.
    pub fn subscribe_all(&self, tenant: Tenant) -> watch::Receiver<u64> {
        self.tenants.subscribe(tenant)
    }

    /// Wakes after something happened to the job.
    pub fn notify(&self, job: &Owned) {
        self.jobs.wake(Some(job));
        self.tenants.wake(Some(&job.tenant));
    }

    /// Wakes after something may have happened to any job.
    pub fn notify_all(&self) {
        self.jobs.wake(None);
        self.tenants.wake(None);
    }

    /// Returns the jobs that somebody listens to.
    pub fn listened(&self) -> Vec<Owned> {
        let jobs = self.jobs.lock();
        jobs.iter().filter(|(_, waker)| waker.receiver_count() > 0).map(|(job, _)| job.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::callers::Tenant;

    #[tokio::test]
    async fn only_listeners_of_the_job_are_woken_and_the_gone_are_forgotten() {
        let notifier = JobNotifier::default();
        let job = |tenant| Owned { tenant: Tenant::named(tenant).unwrap(), id: Uuid::from_u128(1) };
        let (one, two) = (job("one"), job("two"));
        let (mut first, mut second) = (notifier.subscribe(one.clone()), notifier.subscribe(two.clone()));
        notifier.notify(&one);
        assert!(first.has_changed().unwrap() && !second.has_changed().unwrap());
        first.borrow_and_update();
        drop(first);
        let again = notifier.subscribe(two.clone());
        assert_eq!(notifier.jobs.lock().len(), 1);
        assert_eq!(notifier.listened(), std::slice::from_ref(&two));
        notifier.notify(&two);
        assert!(again.has_changed().unwrap());
        second.changed().await.unwrap();
        notifier.notify_all();
        second.changed().await.unwrap();
        drop((second, again));
        assert_eq!(notifier.listened(), []);
        let mut all = notifier.subscribe_all(two.tenant.clone());
        let other = notifier.subscribe_all(one.tenant.clone());
        notifier.notify(&two);
        assert!(all.has_changed().unwrap() && !other.has_changed().unwrap());
        all.borrow_and_update();
        notifier.notify_all();
        assert!(all.has_changed().unwrap() && other.has_changed().unwrap());
    }
}
