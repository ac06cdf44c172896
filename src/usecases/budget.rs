//! A budget of bytes: bodies as sent and unpacked, what is made of them, and responses not sent
//! yet.
//!
//! Whoever holds such bytes has a [`Permit`] for them, taken before the bytes are there and given
//! back when it is dropped. Nobody waits for one: what does not fit is refused at once (503, or 413
//! for what would never fit), so that overload costs no memory.

use std::{
    ops::Deref,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use bytes::Bytes;

use crate::{
    api::problem::{Problem, ProblemCode},
    telemetry,
};

/// Whoever holds no more than this may also take of what is kept for such.
const SMALL: usize = 64 << 10;
/// The part of the budget that is kept for small ones, so that a few large bodies do not shut
/// everybody out.
const RESERVED_FOR_SMALL: usize = 16;

/// Why something was refused, as a label.
const REASON: &str = "body_memory";

/// See the module's documentation. Clones share it.
#[derive(Clone, Debug)]
pub struct Budget(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    total: usize,
    held: AtomicUsize,
}

/// Bytes of a budget, held until this is dropped.
#[derive(Debug)]
pub struct Permit {
    budget: Budget,
    bytes: usize,
}

impl Budget {
    pub fn new(total: usize) -> Self {
        Budget(Arc::new(Shared { total, held: AtomicUsize::new(0) }))
    }

    /// Bytes that are held now.
    pub fn held(&self) -> usize {
        self.0.held.load(Ordering::Relaxed)
    }

    /// A permit for nothing yet.
    pub fn permit(&self) -> Permit {
        Permit { budget: self.clone(), bytes: 0 }
    }

    /// A permit for so many bytes.
    pub fn take(&self, bytes: usize) -> Result<Permit, Problem> {
        let mut permit = self.permit();
        permit.grow(bytes)?;
        Ok(permit)
    }

    /// Most that somebody may hold who wants this much.
    fn limit_for(&self, wanted: usize) -> usize {
        let total = self.0.total;
        if wanted <= SMALL { total } else { total - total / RESERVED_FOR_SMALL }
    }
}

impl Permit {
    /// Takes more, or leaves it at what there is.
    pub fn grow(&mut self, more: usize) -> Result<(), Problem> {
        self.check_total(more)?;
        let wanted = self.bytes.saturating_add(more);
        let room = self.budget.limit_for(wanted);
        let fits = |held: usize| held.checked_add(more).filter(|sum| *sum <= room);
        if self.budget.0.held.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits).is_err() {
            return Err(busy());
        }
        self.bytes = wanted;
        Ok(())
    }

    /// Takes more for a request that holds something else too; refuses for good what would never
    /// fit together with that.
    pub fn grow_with(&mut self, other: &Permit, more: usize) -> Result<(), Problem> {
        self.check_total(more.saturating_add(other.bytes))?;
        self.grow(more)
    }

    /// Refuses at once what does not fit, without taking any.
    pub fn check(&self, more: usize) -> Result<(), Problem> {
        self.check_total(more)?;
        let room = self.budget.limit_for(self.bytes.saturating_add(more));
        if self.budget.held().saturating_add(more) > room { Err(busy()) } else { Ok(()) }
    }

    /// Refuses what would never fit, even if nobody else held anything.
    pub fn check_total(&self, more: usize) -> Result<(), Problem> {
        let wanted = self.bytes.saturating_add(more);
        let room = self.budget.limit_for(wanted);
        if wanted > room { Err(never(room)) } else { Ok(()) }
    }

    /// Takes more even above the limit, for what is there already and must not be lost.
    pub fn force(&mut self, more: usize) {
        self.budget.0.held.fetch_add(more, Ordering::Relaxed);
        self.bytes += more;
    }

    /// Gives back all but so many.
    pub fn shrink_to(&mut self, bytes: usize) {
        let back = self.bytes.saturating_sub(bytes);
        self.budget.0.held.fetch_sub(back, Ordering::Relaxed);
        self.bytes -= back;
    }

    /// Number of bytes held.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Bytes that give the permit back when their last part is dropped.
    pub fn guard(self, bytes: Bytes) -> Bytes {
        Bytes::from_owner(Guarded { bytes, _permit: self })
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        self.shrink_to(0);
    }
}

/// Something with the permit for the memory it takes.
#[derive(Debug)]
pub struct WithPermit<T> {
    value: T,
    permit: Permit,
}

impl<T> WithPermit<T> {
    pub fn new(value: T, permit: Permit) -> Self {
        WithPermit { value, permit }
    }

    pub fn permit(&self) -> &Permit {
        &self.permit
    }

    pub fn into_parts(self) -> (T, Permit) {
        (self.value, self.permit)
    }
}

impl<T> Deref for WithPermit<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

struct Guarded {
    bytes: Bytes,
    _permit: Permit,
}

impl AsRef<[u8]> for Guarded {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

fn never(room: usize) -> Problem {
    Problem::new(
        ProblemCode::BodyTooLarge,
        format!("This needs more memory than a request may use ({room} bytes with the data made from its body)."),
    )
}

fn busy() -> Problem {
    telemetry::record_shed(REASON);
    Problem::new(ProblemCode::Overloaded, "Other requests use all memory for bodies; try again in a moment.")
        .retry_after(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reservations_never_exceed_the_budget_and_are_returned() {
        let budget = Budget::new(32 << 20);
        let most = budget.limit_for(usize::MAX);
        assert_eq!(most, 30 << 20);
        let refusal = |outcome: Result<Permit, Problem>| outcome.map(|permit| permit.bytes()).unwrap_err().status;
        assert_eq!(refusal(budget.take(most + 1)), 413, "never");
        let mut first = budget.take(most - 10).unwrap();
        assert_eq!(first.grow(11).unwrap_err().status, 413, "never");
        assert_eq!(refusal(budget.take(SMALL + 1)), 503);
        assert_eq!(budget.permit().check(SMALL + 1).unwrap_err().status, 503);
        assert_eq!(first.bytes(), most - 10, "a refusal takes nothing");
        let small = budget.take(SMALL).unwrap();
        assert_eq!(budget.held(), most - 10 + SMALL);
        first.shrink_to(100);
        assert_eq!(budget.held(), 100 + SMALL);
        drop((first, small));
        assert_eq!(budget.held(), 0);
        let mut forced = budget.take(most).unwrap();
        forced.force(4 << 20);
        assert_eq!(budget.held(), 34 << 20);
        assert_eq!(refusal(budget.take(1)), 503);
        drop(forced);
        assert_eq!(budget.held(), 0);
    }

    #[test]
    fn guarded_bytes_hold_their_permit_to_the_last_slice() {
        let budget = Budget::new(1 << 20);
        let bytes = budget.take(1000).unwrap().guard(Bytes::from(vec![7; 1000]));
        let part = bytes.slice(10..20);
        drop(bytes);
        assert_eq!((budget.held(), &part[..2]), (1000, &[7, 7][..]));
        drop(part);
        assert_eq!(budget.held(), 0);
    }

    #[test]
    fn threads_do_not_overdraw() {
        let budget = Budget::new(1 << 20);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..2000 {
                        let permit = budget.take(300 << 10);
                        assert!(budget.held() <= 1 << 20);
                        drop(permit);
                    }
                });
            }
        });
        assert_eq!(budget.held(), 0);
    }
}
