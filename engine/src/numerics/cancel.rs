//! Cancellation: long loops ask now and then whether their result is still wanted.
//!
//! Whoever starts a computation runs it under a [`Handle`] ([`Handle::run`]); loops anywhere below
//! call [`checkpoint`]. Once the handle is cancelled or past its deadline, the next checkpoint
//! unwinds the stack up to `run`, which answers [`Cancelled`]. Destructors run on the way, so
//! memory, locks and places are given back as at any return.
//!
//! Unwinding, and not a `Result` through every signature: mathematics would become half error
//! handling for an error that it can neither cause nor mend, and a loop in a callback of a library
//! could not pass it on at all. Salsa cancels queries of rust-analyzer in the same way. The payload
//! is a private type raised by `resume_unwind`, so no panic hook is called, nothing is logged, and
//! any other panic passes through `run` untouched. A checkpoint decides about going on only:
//! results are the same bits with and without a handle.
//!
//! A checkpoint is a read of a thread-local and of a flag (and of the clock if there is a
//! deadline), a few nanoseconds. It belongs into every loop whose length a request decides, where a
//! turn costs a microsecond or more, such that at most 5 ms pass between two; kernels over vectors
//! have none. Loops over cheap turns ask once in a stretch of them ([`every`], [`Asking`]).
//!
//! The handle is installed for the thread. Work that goes to other threads (rayon) takes it along:
//! [`current`] before, [`carry`] inside.

use std::{
    cell::RefCell,
    cmp::Ordering,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc,
        atomic::{self, AtomicBool},
    },
    time::Instant,
};

/// Says to a computation that its result is not wanted any more. Clones are the same handle.
#[derive(Clone, Debug, Default)]
pub struct Handle(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    cancelled: AtomicBool,
    deadline: Option<Instant>,
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

/// What unwinds, up to the `run` of this handle.
struct Unwinding(Handle);

thread_local! {
    static CURRENT: RefCell<Option<Handle>> = const { RefCell::new(None) };
}

impl Handle {
    /// A handle that nobody has cancelled.
    pub fn new() -> Self {
        Handle::default()
    }

    /// A handle that is also cancelled once `deadline` has passed.
    pub fn with_deadline(deadline: Instant) -> Self {
        Handle(Arc::new(Shared { cancelled: AtomicBool::new(false), deadline: Some(deadline) }))
    }

    /// From now on the work is not wanted. It ends at its next checkpoint.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, atomic::Ordering::Relaxed);
    }

    /// Whether the work is not wanted any more, or its deadline has passed.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(atomic::Ordering::Relaxed)
            || self.0.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Does `work` under this handle. Work that was done before a checkpoint saw the cancellation
    /// has its result.
    ///
    /// ```
    /// use flankfit_engine::numerics::cancel::{Handle, checkpoint};
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
        match catch_unwind(AssertUnwindSafe(|| carry(Some(self), inside))) {
            Ok(result) => Ok(result),
            Err(payload) => match payload.downcast_ref::<Unwinding>() {
                Some(Unwinding(handle)) if Arc::ptr_eq(&handle.0, &self.0) => Err(Cancelled),
                _ => resume_unwind(payload),
            },
        }
    }
}

/// Puts the outer handle back, also when the stack unwinds.
struct Restore(Option<Handle>);

impl Drop for Restore {
    fn drop(&mut self) {
        CURRENT.replace(self.0.take());
    }
}

/// The handle under which this thread works.
pub fn current() -> Option<Handle> {
    CURRENT.with_borrow(Clone::clone)
}

/// Does `work` under a handle that was [`current`] on another thread, or under none where there was
/// none: a thread of rayon that waits may do the work of another computation meanwhile.
pub fn carry<T>(handle: Option<&Handle>, work: impl FnOnce() -> T) -> T {
    let _restore = Restore(CURRENT.replace(handle.cloned()));
    work()
}

/// Ends the computation here if it is not wanted any more.
#[inline]
pub fn checkpoint() {
    CURRENT.with_borrow(|handle| ask(handle.as_ref()));
}

/// Work between two checkpoints of a loop, in the unit of [`every`]: a tenth of a millisecond.
const STRETCH: usize = 100_000;

/// A checkpoint now and then in a loop whose turns cost about `cost` nanoseconds each (or
/// multiplications; an estimate that is wrong by a factor of ten does no harm). `turn` counts from
/// 0. A loop that is over soon has none.
#[inline]
pub fn every(cost: usize, turn: usize) {
    if (turn + 1).is_multiple_of(STRETCH / cost.max(1) + 1) {
        checkpoint();
    }
}

/// A comparison for sorting that passes a checkpoint now and then. (What a cancelled sort leaves is
/// a permutation, and goes away.)
pub fn comparing<T>(mut compare: impl FnMut(&T, &T) -> Ordering) -> impl FnMut(&T, &T) -> Ordering {
    let mut left = STRETCH / 10;
    move |a, b| {
        left -= 1;
        if left == 0 {
            checkpoint();
            left = STRETCH / 10;
        }
        compare(a, b)
    }
}

/// Iterators that pass a checkpoint now and then.
pub trait Asking: Iterator + Sized {
    /// The same items, with checkpoints as [`every`] has them.
    fn asking(self, cost: usize) -> Checked<Self> {
        let stretch = STRETCH / cost.max(1) + 1;
        Checked { items: self, stretch, left: stretch }
    }
}

impl<I: Iterator> Asking for I {}

/// See [`Asking::asking`].
#[derive(Clone, Debug)]
pub struct Checked<I> {
    items: I,
    stretch: usize,
    left: usize,
}

impl<I: Iterator> Iterator for Checked<I> {
    type Item = I::Item;

    #[inline]
    fn next(&mut self) -> Option<I::Item> {
        self.left -= 1;
        if self.left == 0 {
            checkpoint();
            self.left = self.stretch;
        }
        self.items.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.items.size_hint()
    }
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
mod tests {
    use std::{sync::mpsc, time::Duration};

    use rayon::prelude::*;

    use super::*;

    fn spin() -> ! {
        loop {
            checkpoint();
            std::hint::spin_loop();
        }
    }

    #[test]
    fn without_a_handle_nothing_happens_and_with_one_the_result_comes_through() {
        checkpoint();
        assert!(current().is_none());
        let handle = Handle::new();
        let result = handle.run(|| {
            checkpoint();
            every(STRETCH, 0);
            assert!(current().is_some());
            42
        });
        assert_eq!(result, Ok(42));
        assert!(current().is_none() && !handle.is_cancelled());
    }

    #[test]
    fn a_cancelled_handle_ends_the_work_from_another_thread_and_destructors_run() {
        struct Bell(mpsc::Sender<()>);
        impl Drop for Bell {
            fn drop(&mut self) {
                // computing in a destructor is no second unwinding
                checkpoint();
                self.0.send(()).unwrap();
            }
        }
        let handle = Handle::new();
        let (begun, seen) = mpsc::channel();
        let (gone, dropped) = mpsc::channel();
        let working = std::thread::spawn({
            let handle = handle.clone();
            move || {
                let result = handle.run(|| {
                    let _bell = Bell(gone);
                    begun.send(()).unwrap();
                    spin()
                });
                (result, current().is_none())
            }
        });
        seen.recv().unwrap();
        assert!(!working.is_finished());
        handle.cancel();
        assert_eq!(working.join().unwrap(), (Err::<(), _>(Cancelled), true));
        dropped.recv().unwrap();
        assert_eq!(handle.run(|| 1), Err(Cancelled), "what is cancelled does not begin");
    }

    #[test]
    fn handles_nest_and_each_ends_its_own_work() {
        let (outer, inner) = (Handle::new(), Handle::new());
        let result = outer.run(|| {
            inner.cancel();
            let given_up = inner.run(|| spin());
            checkpoint();
            given_up
        });
        assert_eq!(result, Ok(Err::<(), _>(Cancelled)));
        let (outer, inner) = (Handle::new(), Handle::new());
        let result = outer.run(|| {
            let done = inner.run(|| {
                outer.cancel();
                checkpoint();
                1
            });
            assert_eq!(done, Ok(1), "the inner work is still wanted");
            checkpoint();
        });
        assert_eq!(result, Err(Cancelled));
    }

    #[test]
    fn loops_ask_once_in_a_stretch_of_turns() {
        let handle = Handle::new();
        handle.cancel();
        let turns = |cost: usize, most: usize| {
            let turn = std::cell::Cell::new(0);
            let by_number = catch_unwind(AssertUnwindSafe(|| {
                carry(Some(&handle), || (0..most).for_each(|i| (turn.set(i), every(cost, i)).1))
            }));
            let seen = std::cell::Cell::new(0);
            let by_item = catch_unwind(AssertUnwindSafe(|| {
                carry(Some(&handle), || (0..most).asking(cost).for_each(|i| seen.set(i + 1)))
            }));
            assert_eq!(by_number.is_err(), by_item.is_err());
            by_number.is_err().then(|| (turn.get(), seen.get()))
        };
        assert_eq!(turns(STRETCH / 4, 3), None);
        assert_eq!(turns(STRETCH / 4, 5), Some((4, 4)));
        assert_eq!(turns(0, 2 * STRETCH), Some((STRETCH, STRETCH)));
        assert_eq!(turns(usize::MAX, 1), Some((0, 0)));
        assert_eq!((0..7).asking(1).size_hint(), (7, Some(7)));
        let mut numbers: Vec<usize> = (0..100_000).map(|i| i * 7919 % 100_003).collect();
        let sort = || carry(Some(&handle), || numbers.sort_by(comparing(usize::cmp)));
        assert!(catch_unwind(AssertUnwindSafe(sort)).is_err());
    }

    #[test]
    fn a_deadline_cancels() {
        assert_eq!(Handle::with_deadline(Instant::now()).run(|| 1), Err(Cancelled));
        let soon = Handle::with_deadline(Instant::now() + Duration::from_millis(2));
        assert_eq!(soon.run(|| spin()), Err::<(), _>(Cancelled));
        let late = Handle::with_deadline(Instant::now() + Duration::from_secs(3600));
        assert_eq!(late.run(checkpoint), Ok(()));
    }

    #[test]
    fn other_panics_pass_through() {
        let handle = Handle::new();
        let payload =
            catch_unwind(AssertUnwindSafe(|| handle.run(|| resume_unwind(Box::new("a defect"))))).unwrap_err();
        assert_eq!(payload.downcast_ref(), Some(&"a defect"));
        assert!(current().is_none());
    }

    #[test]
    fn threads_of_rayon_take_the_handle_along() {
        let handle = Handle::new();
        let (begun, seen) = mpsc::sync_channel(1 << 10);
        let working = std::thread::spawn({
            let handle = handle.clone();
            move || {
                handle.run(|| {
                    let handle = current();
                    (0..64).into_par_iter().for_each(|_| {
                        carry(handle.as_ref(), || {
                            let _full = begun.try_send(());
                            spin()
                        })
                    });
                })
            }
        });
        seen.recv().unwrap();
        handle.cancel();
        assert_eq!(working.join().unwrap(), Err(Cancelled));
        // the pool's threads keep nothing of it
        assert!((0..64).into_par_iter().all(|_| current().is_none()));
    }

    #[test]
    fn work_without_a_handle_is_not_cancelled_by_the_one_below_it_on_the_stack() {
        let handle = Handle::new();
        let result = handle.run(|| {
            handle.cancel();
            carry(None, || {
                checkpoint();
                7
            })
        });
        assert_eq!(result, Ok(7));
    }
}
