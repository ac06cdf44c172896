//! Keys and tenants as they were read lately, which are used for a while without reading again.
//!
//! It holds for two seconds, or until a change of keys is announced; while the store does not
//! answer, for five minutes.

use std::{
    collections::HashMap,
    hash::Hash,
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use tokio::{sync::watch, time::timeout};

use crate::jobs::outcome::RepositoryError;

/// How long what the store said is not asked about again.
const FRESH: Duration = Duration::from_secs(2);
/// How long it holds while the store does not answer.
const HELD: Duration = Duration::from_secs(300);
/// How long the store may take to answer, where something is known already.
const PATIENCE: Duration = Duration::from_secs(1);
/// While somebody asks, and when the store did not answer, the others do not ask for so long.
const PAUSE: Duration = Duration::from_secs(1);
/// Entries in memory. There are fewer keys, or as many keys at a time are not fast.
const MOST: usize = 1 << 16;

struct Entry<V> {
    known: Option<V>,
    /// When the store said so.
    said: Instant,
    /// Which changes of keys it had seen by then.
    seen: u64,
    /// When it was last asked in vain, or is being asked.
    asked: Option<Instant>,
}

/// See the module's documentation.
pub(super) struct Lately<K, V> {
    /// Told of every change of keys and tenants.
    changes: watch::Receiver<u64>,
    entries: Mutex<HashMap<K, Entry<V>>>,
    /// See [`FRESH`] and [`HELD`].
    pub(super) fresh: Duration,
    pub(super) held: Duration,
}

impl<K: Clone + Eq + Hash, V: Clone> Lately<K, V> {
    pub fn new(changes: watch::Receiver<u64>) -> Self {
        Lately { changes, entries: Mutex::default(), fresh: FRESH, held: HELD }
    }

    fn entries(&self) -> MutexGuard<'_, HashMap<K, Entry<V>>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the value from the store, by `ask`, or as it was lately. A missing one is kept only
    /// where it `recurs`.
    pub async fn find<F>(&self, what: K, recurs: bool, ask: impl FnOnce() -> F) -> Result<Option<V>, RepositoryError>
    where
        F: Future<Output = Result<Option<V>, RepositoryError>>,
    {
        let changes = *self.changes.borrow();
        let mut held = None;
        if let Some(entry) = self.entries().get_mut(&what) {
            let age = entry.said.elapsed();
            let current = entry.seen == changes && age < self.fresh;
            let waiting = entry.asked.is_some_and(|asked| asked.elapsed() < PAUSE) && age < self.held;
            if current || (waiting && entry.seen == changes) {
                return Ok(entry.known.clone());
            }
            entry.asked = Some(Instant::now());
            held = Some(entry.known.clone()).filter(|_| age < self.held);
        }
        let late = |_| Err(RepositoryError::Unavailable("the store does not say who calls".into()));
        let said = match held {
            Some(_) => timeout(PATIENCE, ask()).await.unwrap_or_else(late),
            None => ask().await,
        };
        match (said, held) {
            (Ok(known), _) => {
                self.learn(what, known.clone(), changes, recurs);
                Ok(known)
            }
            (Err(_away), Some(held)) => Ok(held),
            (Err(away), None) => Err(away),
        }
    }

    fn learn(&self, what: K, known: Option<V>, seen: u64, recurs: bool) {
        let mut entries = self.entries();
        if known.is_none() && !recurs {
            entries.remove(&what);
            return;
        }
        if entries.len() >= MOST {
            entries.clear();
        }
        entries.insert(what, Entry { known, said: Instant::now(), seen, asked: None });
    }
}
