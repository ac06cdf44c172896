//! Checkpoints once in a stretch of cheap turns, for loops, sorts and iterators.

use std::cmp::Ordering;

use super::checkpoint;

/// Work between two checkpoints of a loop, in the unit of [`every`]: a tenth of a millisecond.
pub(super) const STRETCH: usize = 100_000;

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
