//! Shares of the work of a handle: what is done of it, and what a thread may divide.

use std::{
    cell::Cell,
    sync::atomic::{AtomicU64, Ordering},
};

/// The whole work, in the unit of shares.
pub(super) const WHOLE: u64 = 1 << 52;

/// Progress of the work of a handle.
#[derive(Debug)]
pub(super) struct Done {
    /// Completed share of the whole.
    pub(super) done: AtomicU64,
    /// Share of the whole that is not divided yet.
    undivided: AtomicU64,
}

impl Default for Done {
    fn default() -> Self {
        Done { done: 0.into(), undivided: WHOLE.into() }
    }
}

thread_local! {
    /// Share of the whole work that the parts of this thread divide among themselves.
    pub(super) static SHARE: Cell<u64> = const { Cell::new(0) };
}

/// The share of the outer work; puts it back, also when the stack unwinds.
pub(super) struct Share(pub(super) u64);

impl Share {
    /// Share that cannot be divided.
    pub(super) fn none() -> Self {
        Share(SHARE.replace(0))
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        SHARE.set(self.0);
    }
}

impl Done {
    /// Does work that may divide what nobody has divided before it.
    pub(super) fn reported<T>(&self, work: impl FnOnce() -> T) -> T {
        SHARE.set(self.undivided.swap(0, Ordering::Relaxed));
        let result = work();
        self.undivided.fetch_add(SHARE.take(), Ordering::Relaxed);
        result
    }

    pub(super) fn add(&self, share: u64) {
        self.done.fetch_add(share, Ordering::Relaxed);
    }
}
