//! Time and fresh ids, the only two things a job takes from the world around it.

use std::sync::Mutex;

use jiff::Timestamp;
use uuid::{ContextV7, Uuid};

/// Source of the current time.
pub trait Clock: Send + Sync + 'static {
    /// The present moment, in whole microseconds: what is stored is what was answered.
    fn now(&self) -> Timestamp;
}

/// Source of fresh ids.
pub trait Ids: Send + Sync + 'static {
    /// A UUIDv7 greater than every one given before, as far as the clock allows.
    fn fresh(&self, now: Timestamp) -> Uuid;
}

/// The machine's clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    #[expect(clippy::disallowed_methods, reason = "the one place where the ambient clock is read")]
    fn now(&self) -> Timestamp {
        let now = Timestamp::now();
        Timestamp::from_microsecond(now.as_microsecond()).unwrap_or(now)
    }
}

/// UUIDv7 with a counter, so that ids of one millisecond still ascend and a list in id order is a
/// list in order of creation.
pub struct OrderedIds {
    context: Mutex<ContextV7>,
}

impl OrderedIds {
    pub fn new() -> Self {
        OrderedIds { context: Mutex::new(ContextV7::new()) }
    }
}

impl Default for OrderedIds {
    fn default() -> Self {
        Self::new()
    }
}

impl Ids for OrderedIds {
    #[expect(clippy::disallowed_methods, reason = "the one place where ids are made")]
    fn fresh(&self, now: Timestamp) -> Uuid {
        let seconds = u64::try_from(now.as_second()).unwrap_or(0);
        let nanoseconds = u32::try_from(now.subsec_nanosecond()).unwrap_or(0);
        Uuid::new_v7(uuid::Timestamp::from_unix(&self.context, seconds, nanoseconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_ascend_within_one_moment() {
        let ids = OrderedIds::new();
        let now = SystemClock.now();
        let given: Vec<Uuid> = (0..10_000).map(|_| ids.fresh(now)).collect();
        assert!(given.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(given.iter().all(|id| id.get_version_num() == 7));
    }
}
