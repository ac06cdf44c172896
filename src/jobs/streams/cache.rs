//! Estimates of open streams, kept in memory between blocks.
//!
//! What is here can be made again from the store, so it may be dropped at any time: the number of
//! estimates and their size are bounded. A stream's slot is also the lock that puts the blocks that
//! come to this process in order.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use flankfit_engine::estimation::Recursive;
use tokio::sync::{OwnedMutexGuard, watch};

use super::stream::Stream;
use crate::jobs::callers::Owned;

/// A stream with its estimate after the last block.
#[derive(Clone)]
pub struct CachedStream {
    pub stream: Stream,
    /// Digest of the last block.
    pub last_sha256: Option<[u8; 32]>,
    pub estimate: Recursive,
    /// Nodes since the estimate was stored last.
    pub unsaved: u64,
}

/// One stream at a time.
pub type Slot = OwnedMutexGuard<Option<CachedStream>>;

/// See the module's documentation.
pub struct StreamCache {
    slots: Mutex<HashMap<Owned, Entry>>,
    ended: watch::Sender<()>,
}

struct Entry {
    slot: Arc<tokio::sync::Mutex<Option<CachedStream>>>,
    used: u64,
    bytes: usize,
}

impl StreamCache {
    /// Streams kept.
    const MOST: usize = 256;
    /// Bytes of estimates kept, roughly.
    const MOST_BYTES: usize = 128 << 20;

    /// Whether the stream has a slot: then it was asked for, and found, by its tenant.
    pub fn knows(&self, stream: &Owned) -> bool {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner).contains_key(stream)
    }

    /// The stream's slot, once no other holder has it. Empty when the stream is not in memory.
    pub async fn slot(&self, stream: Owned) -> Slot {
        let slot = {
            let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
            let used = slots.values().map(|entry| entry.used).max().map_or(0, |last| last + 1);
            let entry = slots.entry(stream).or_insert_with(|| Entry { slot: Arc::default(), used, bytes: 0 });
            entry.used = used;
            let slot = entry.slot.clone();
            shrink(&mut slots);
            slot
        };
        slot.lock_owned().await
    }

    /// Notes how large a stream's estimate has become, and lets others go where there are too many.
    pub fn set_size(&self, stream: &Owned, live: Option<&CachedStream>) {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(entry) = slots.get_mut(stream) {
            let n = live.and_then(|live| live.estimate.size()).unwrap_or(0);
            entry.bytes = live.map_or(0, |live| live.stream.spec.len()) + 8 * n * (n + 64);
        }
        shrink(&mut slots);
    }

    /// Says that some stream was finished or deleted.
    pub fn announce_end(&self) {
        self.ended.send_replace(());
    }

    /// Hears of ends from now on.
    pub fn ends(&self) -> watch::Receiver<()> {
        self.ended.subscribe()
    }
}

impl Default for StreamCache {
    fn default() -> Self {
        StreamCache { slots: Mutex::default(), ended: watch::channel(()).0 }
    }
}

/// Drops the streams not used for longest, of those without a holder.
fn shrink(slots: &mut HashMap<Owned, Entry>) {
    let over = |slots: &HashMap<Owned, Entry>| {
        slots.len() > StreamCache::MOST
            || slots.values().map(|entry| entry.bytes).sum::<usize>() > StreamCache::MOST_BYTES
    };
    while over(slots) {
        let idle = slots.iter().filter(|(_, entry)| Arc::strong_count(&entry.slot) == 1);
        let Some(oldest) = idle.min_by_key(|(_, entry)| entry.used).map(|(stream, _)| stream.clone()) else { return };
        slots.remove(&oldest);
    }
}

#[cfg(test)]
mod tests {
    use uuid::Uuid;

    use super::*;
    use crate::jobs::callers::Tenant;

    #[tokio::test]
    async fn idle_streams_go_first_and_held_ones_stay() {
        let live = StreamCache::default();
        let stream = |id| Owned { tenant: Tenant::default(), id: Uuid::from_u128(id) };
        let held = live.slot(stream(0)).await;
        for id in 1..=2 * StreamCache::MOST as u128 {
            drop(live.slot(stream(id)).await);
        }
        let slots = live.slots.lock().unwrap();
        assert!(slots.len() <= StreamCache::MOST + 1);
        assert!(slots.contains_key(&stream(0)) && !slots.contains_key(&stream(1)));
        drop(held);
    }
}
