//! Schedules reads among tenants and limits their duration.
//!
//! One tenant holds at most half of the readers, so that others never wait for the reads of a
//! single tenant; waiting reads are served in order. A read that takes too long, or that nobody
//! waits for any more, is ended.

use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use tokio::{
    sync::{AcquireError, OwnedSemaphorePermit, Semaphore},
    time::{error::Elapsed, timeout},
};

use crate::jobs::{RepositoryError, Tenant};

/// How long a read may wait for its turn.
const WAIT: Duration = Duration::from_secs(60);
/// How long a read may take.
pub const READ_TIME: Duration = Duration::from_secs(5);

/// The tenant that reads; `None` for the server itself.
type Party = Option<Tenant>;

/// See the module's documentation.
#[derive(Debug)]
pub struct ReadTurns {
    all: Arc<Semaphore>,
    share: usize,
    each: Mutex<HashMap<Party, Arc<Semaphore>>>,
}

/// The right to one of the readers.
#[derive(Debug)]
pub struct ReadTurn {
    _of_all: OwnedSemaphorePermit,
    _of_party: OwnedSemaphorePermit,
}

impl ReadTurns {
    pub fn new(readers: u32) -> Self {
        let readers = usize::try_from(readers).unwrap_or(usize::MAX).clamp(1, Semaphore::MAX_PERMITS);
        ReadTurns { all: Arc::new(Semaphore::new(readers)), share: readers.div_ceil(2), each: Mutex::default() }
    }

    /// Waits for a reader.
    pub async fn take(&self, party: &Party) -> Result<ReadTurn, RepositoryError> {
        let own = self.of(party);
        let taking = async {
            // first the party's own permit, so that a party never has more than its share in the
            // queue for readers
            let _of_party = own.acquire_owned().await?;
            Ok(ReadTurn { _of_all: self.all.clone().acquire_owned().await?, _of_party })
        };
        let waited = |_: Elapsed| RepositoryError::Unavailable("every reader of the store is busy".into());
        timeout(WAIT, taking)
            .await
            .map_err(waited)?
            .map_err(|error: AcquireError| RepositoryError::Failed(error.to_string()))
    }

    fn of(&self, party: &Party) -> Arc<Semaphore> {
        let mut each = self.each.lock().unwrap_or_else(PoisonError::into_inner);
        // a permit holds a reference to its semaphore
        each.retain(|_, own| Arc::strong_count(own) > 1);
        each.entry(party.clone()).or_insert_with(|| Arc::new(Semaphore::new(self.share))).clone()
    }
}

/// Deadline and cancellation of a read.
#[derive(Debug)]
pub struct Watch {
    until: Instant,
    left: AtomicBool,
}

tokio::task_local! {
    /// The current read.
    pub static READING: Arc<Watch>;
}

impl Watch {
    pub fn lasting(time: Duration) -> Arc<Self> {
        Arc::new(Watch { until: Instant::now() + time, left: AtomicBool::new(false) })
    }

    /// Returns whether the read must end.
    pub fn is_over(&self) -> bool {
        self.left.load(Ordering::Relaxed) || Instant::now() >= self.until
    }
}

/// Ends a read when dropped.
pub struct EndsRead(pub Arc<Watch>);

impl Drop for EndsRead {
    fn drop(&mut self) {
        self.0.left.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;

    use super::*;

    #[tokio::test]
    async fn a_tenant_holds_half_of_the_readers_and_no_more() {
        let turns = ReadTurns::new(8);
        let greedy = Some(Tenant::named("greedy").unwrap());
        let mut held = Vec::new();
        for _ in 0..4 {
            held.push(turns.take(&greedy).await.unwrap());
        }
        let mut waiting: Vec<_> = (0..16).map(|_| Box::pin(turns.take(&greedy))).collect();
        for next in &mut waiting {
            assert!(next.as_mut().now_or_never().is_none());
        }
        // other tenants and the server get a reader at once
        for other in [None, Some(Tenant::named("other").unwrap())] {
            drop(turns.take(&other).now_or_never().expect("at once").unwrap());
        }
        drop(held.pop());
        assert!(waiting[0].as_mut().now_or_never().is_some_and(|turn| turn.is_ok()));
        drop((waiting, held));
        turns.take(&None).await.unwrap();
        assert_eq!(turns.each.lock().unwrap().len(), 1, "who has left is forgotten");
    }
}
