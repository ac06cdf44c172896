//! Cancellation: long loops ask now and then whether their result is still wanted.
//!
//! Whoever starts a computation runs it under a [`Handle`] ([`Handle::run`]); loops anywhere below
//! call [`checkpoint`]. Once the handle is cancelled, the next checkpoint unwinds the stack up to
//! `run`, which returns [`Cancelled`]. Destructors run on the way, so memory, locks and places are
//! given back as at any return.
//!
//! Unwinding, and not a `Result` through every signature: mathematics would become half error
//! handling for an error that it neither causes nor corrects, and a loop in a callback of a library
//! could not pass it on at all. Salsa cancels queries of rust-analyzer in the same way. The payload
//! is a private type raised by `resume_unwind`, so no panic hook is called, nothing is logged, and
//! any other panic passes through `run` untouched. A checkpoint decides about going on only:
//! results are the same bits with and without a handle.
//!
//! A checkpoint is a read of a thread-local and of a flag, a few nanoseconds. It belongs into every
//! loop whose length a request decides, where a turn costs a microsecond or more, such that at most
//! 5 ms pass between two; kernels over vectors have none. Loops over cheap turns ask once in a
//! stretch of them ([`every`], [`Asking`]).
//!
//! The handle is installed for the thread. Work that goes to other threads (rayon) takes it along:
//! [`current`] before, [`carry`] inside.
//!
//! The handle that cancels also reports the progress of the work ([`Handle::progress`]), where the
//! work declares of how many [`parts`] it consists.

mod loops;
mod parts;
mod share;

use std::{
    cell::RefCell,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc,
        atomic::{self, AtomicBool},
    },
};

pub use loops::{Asking, Checked, comparing, every};
pub use parts::{Parts, parts, uncounted};

use share::{Done, Share};

/// Says to a computation that its result is not wanted any more. Clones are the same handle.
#[derive(Clone, Debug, Default)]
pub struct Handle(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    cancelled: AtomicBool,
    done: Done,
    /// Remaining checks before a cancellation, for tests that count checkpoints.
    #[cfg(test)]
    left: Option<atomic::AtomicUsize>,
}

/// The work was given up at a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

impl std::fmt::Display for Cancelled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the computation was cancelled")
    }
}

impl std::error::Error for Cancelled {}

/// Payload of the panic that unwinds up to the `run` of this handle.
struct Unwinding(Handle);

thread_local! {
    static CURRENT: RefCell<Option<Handle>> = const { RefCell::new(None) };
}

impl Handle {
    /// A handle that is not cancelled.
    pub fn new() -> Self {
        Handle::default()
    }

    /// A handle that lets the work pass so many checkpoints and is cancelled at the next one.
    #[cfg(test)]
    pub(crate) fn with_checkpoints(count: usize) -> Self {
        Handle(Arc::new(Shared { left: Some(count.into()), ..Shared::default() }))
    }

    /// From now on the work is not wanted. It ends at its next checkpoint.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, atomic::Ordering::Relaxed);
    }

    /// True once the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        #[cfg(test)]
        if let Some(left) = &self.0.left
            && left.fetch_update(atomic::Ordering::Relaxed, atomic::Ordering::Relaxed, |n| n.checked_sub(1)).is_err()
        {
            return true;
        }
        self.0.cancelled.load(atomic::Ordering::Relaxed)
    }

    /// Does `work` under this handle. Work that was done before a checkpoint saw the cancellation
    /// has its result.
    ///
    /// ```
    /// use flankfit_numerics::cancel::{Handle, checkpoint};
    ///
    /// let handle = Handle::new();
    /// assert_eq!(handle.run(|| 2 + 2).ok(), Some(4));
    /// // Any thread may cancel; the work ends at its next checkpoint.
    /// handle.cancel();
    /// assert!(handle.run(|| loop { checkpoint() }).is_err());
    /// ```
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> Result<T, Cancelled> {
        let inside = || {
            checkpoint();
            work()
        };
        // What the work has borrowed is not looked at after an unwinding: it goes on, or only the
        // marker is left of it.
        match catch_unwind(AssertUnwindSafe(|| carry(Some(self), || self.0.done.reported(inside)))) {
            Ok(result) => Ok(result),
            Err(payload) => match payload.downcast_ref::<Unwinding>() {
                Some(Unwinding(handle)) if Arc::ptr_eq(&handle.0, &self.0) => Err(Cancelled),
                _ => resume_unwind(payload),
            },
        }
    }
}

/// Puts the outer handle and its share back, also when the stack unwinds.
struct Restore {
    handle: Option<Handle>,
    _share: Share,
}

impl Drop for Restore {
    fn drop(&mut self) {
        CURRENT.replace(self.handle.take());
    }
}

/// The handle under which this thread works.
pub fn current() -> Option<Handle> {
    CURRENT.with_borrow(Clone::clone)
}

/// Does `work` under a handle that was [`current`] on another thread, or under none where there was
/// none: a thread of rayon that waits may do the work of another computation meanwhile.
pub fn carry<T>(handle: Option<&Handle>, work: impl FnOnce() -> T) -> T {
    let _restore = Restore { handle: CURRENT.replace(handle.cloned()), _share: Share::none() };
    work()
}

/// Ends the computation here if it is not wanted any more.
#[inline]
pub fn checkpoint() {
    CURRENT.with_borrow(|handle| ask(handle.as_ref()));
}

/// A checkpoint of a handle that is not this thread's: for turns of a parallel loop that are too
/// short to be carried.
#[inline]
pub fn ask(handle: Option<&Handle>) {
    if let Some(handle) = handle
        && handle.is_cancelled()
    {
        unwind(handle);
    }
}

#[cold]
fn unwind(handle: &Handle) {
    // A destructor that computes while the stack unwinds already must not unwind once more.
    if !std::thread::panicking() {
        resume_unwind(Box::new(Unwinding(handle.clone())));
    }
}

#[cfg(test)]
mod tests;
