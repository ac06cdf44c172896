//! Progress of a computation.
//!
//! Whoever works through parts of a known number says so by [`parts`], and does each in
//! [`Parts::run`]: what says so inside of a part divides the share of that part. So a fit counts as
//! its share of the study that it is of, without knowing of it. Shares are whole numbers that are
//! handed down and only ever added to what is done: progress grows, ends at 1 and does not depend
//! on the order in which threads come. The first to divide a share has all of it; what nobody
//! divides is done when its part is.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{
    Handle, current,
    share::{SHARE, Share, WHOLE},
};

impl Handle {
    /// Share of the work that is done, from 0 to 1, as far as it is reported; never decreases.
    ///
    /// ```
    /// use flankfit_numerics::cancel::{Handle, parts};
    ///
    /// let handle = Handle::new();
    /// let progress = handle.run(|| {
    ///     let halves = parts(2);
    ///     halves.run(1, || ());
    ///     halves.run(1, || parts(4).run(1, || handle.progress()))
    /// });
    /// assert_eq!(progress, Ok(0.5));
    /// assert_eq!(handle.progress(), 1.0);
    /// ```
    pub fn progress(&self) -> f64 {
        self.0.done.done.load(Ordering::Relaxed) as f64 / WHOLE as f64
    }
}

/// Does work that does not count as progress: parts of it take nothing of what is left.
pub fn uncounted<T>(work: impl FnOnce() -> T) -> T {
    let _outer = Share::none();
    work()
}

/// Work of a number of parts, all alike. Whatever is not done when this is dropped counts as done
/// then.
#[derive(Debug)]
pub struct Parts {
    handle: Option<Handle>,
    each: u64,
    left: AtomicU64,
}

/// Says that the work from here on has `count` parts.
pub fn parts(count: usize) -> Parts {
    let share = SHARE.take();
    Parts { handle: current(), each: share / (count as u64).max(1), left: share.into() }
}

impl Parts {
    /// Does work that makes up so many of the parts, on whichever thread.
    pub fn run<T>(&self, count: usize, work: impl FnOnce() -> T) -> T {
        let Some(handle) = &self.handle else { return work() };
        let wanted = self.each.saturating_mul(count as u64);
        let left = |left: u64| Some(left - wanted.min(left));
        let before = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, left).unwrap_or_else(|left| left);
        let outer = Share(SHARE.replace(wanted.min(before)));
        let result = work();
        handle.0.done.add(SHARE.take());
        drop(outer);
        result
    }
}

impl Drop for Parts {
    fn drop(&mut self) {
        if let Some(handle) = &self.handle
            && !std::thread::panicking()
        {
            handle.0.done.add(*self.left.get_mut());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use rayon::prelude::*;

    use super::{super::carry, *};

    #[test]
    fn parts_of_parts_add_up_to_the_whole() {
        let handle = Handle::new();
        let mut seen = vec![handle.progress()];
        handle
            .run(|| {
                let stages = parts(10);
                stages.run(4, || ());
                seen.push(handle.progress());
                stages.run(3, || {
                    let inner = parts(3);
                    (0..3).for_each(|_| inner.run(1, || seen.push(handle.progress())));
                    // the share is given away
                    parts(2).run(1, || ());
                });
                seen.push(handle.progress());
            })
            .unwrap();
        seen.push(handle.progress());
        let expected = [0.0, 0.4, 0.4, 0.5, 0.6, 0.7, 1.0];
        assert!(seen.iter().zip(expected).all(|(seen, expected)| (seen - expected).abs() < 1e-12), "{seen:?}");
        assert_eq!(handle.progress(), 1.0, "exactly");
    }

    #[test]
    fn progress_grows_on_every_thread_and_ends_at_one() {
        let handle = Handle::new();
        std::thread::scope(|scope| {
            let watched = scope.spawn(|| {
                let mut last = 0.0;
                while last < 1.0 {
                    let now = handle.progress();
                    assert!((last..=1.0).contains(&now), "{last} {now}");
                    last = now;
                }
            });
            handle
                .run(|| {
                    let all = parts(1000);
                    let handle = current();
                    (0..1000).into_par_iter().for_each(|_| {
                        carry(handle.as_ref(), || {
                            all.run(1, || {
                                let own = parts(7);
                                (0..7).for_each(|_| own.run(1, || ()));
                            });
                        });
                    });
                })
                .unwrap();
            watched.join().unwrap();
        });
        assert!((0..64).into_par_iter().all(|_| SHARE.get() == 0), "threads of rayon keep nothing of it");
    }

    #[test]
    fn more_or_fewer_parts_than_announced_are_allowed() {
        let handle = Handle::new();
        handle
            .run(|| {
                let two = parts(2);
                (0..5).for_each(|_| two.run(1, || ()));
                assert_eq!(handle.progress(), 1.0);
            })
            .unwrap();
        assert_eq!(handle.progress(), 1.0);
        // without a handle, and of no part, nothing happens
        assert_eq!(parts(0).run(3, || 7), 7);
        let handle = Handle::new();
        handle.run(|| parts(0).run(1, || ())).unwrap();
        assert_eq!(handle.progress(), 1.0);
    }

    #[test]
    fn work_without_parts_leaves_all_progress_to_later_parts() {
        let handle = Handle::new();
        handle.run(|| ()).unwrap();
        assert_eq!(handle.progress(), 0.0);
        handle.run(|| parts(1).run(1, || ())).unwrap();
        assert_eq!(handle.progress(), 1.0);
    }

    #[test]
    fn cancellation_and_panics_restore_the_share() {
        let handle = Handle::new();
        let inner = || {
            let two = parts(2);
            two.run(1, || ());
            two.run(1, || {
                handle.cancel();
                super::super::checkpoint();
            });
        };
        assert!(handle.run(inner).is_err());
        assert_eq!((SHARE.get(), handle.progress()), (0, 0.5));
        let handle = Handle::new();
        let defect = || handle.run(|| parts(3).run(1, || std::panic::resume_unwind(Box::new("a defect"))));
        assert!(catch_unwind(AssertUnwindSafe(defect)).is_err());
        assert_eq!((SHARE.get(), handle.progress()), (0, 0.0));
    }

    #[test]
    fn uncounted_parts_leave_all_progress_to_later_parts() {
        let handle = Handle::new();
        let work = || {
            uncounted(|| parts(2).run(1, || ()));
            assert_eq!(handle.progress(), 0.0);
            parts(2).run(1, || handle.progress())
        };
        assert_eq!((handle.run(work), handle.progress()), (Ok(0.0), 1.0));
    }
}
