//! Errors in input, as data: a list of faults, each a typed field and a reason with its numbers. A
//! room that hands out faults has an enum of fields and one of reasons beside its checks; whoever
//! shows them to a caller has the table from fields to the caller's names.

pub mod common;
pub mod words;

use std::fmt;

pub use common::Common;

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault<F, R> {
    /// The field at fault, with its indices.
    pub field: F,
    /// What is wrong there.
    pub reason: R,
}

/// Every fault found (the first [`Faults::MOST`] are kept, all are counted).
#[derive(Clone, Debug, PartialEq)]
pub struct Faults<F, R> {
    faults: Vec<Fault<F, R>>,
    count: usize,
}

impl<F, R> Default for Faults<F, R> {
    fn default() -> Self {
        Faults { faults: Vec::new(), count: 0 }
    }
}

impl<F, R> Faults<F, R> {
    /// How many faults are kept.
    pub const MOST: usize = 100;

    /// A single fault.
    pub fn one(field: impl Into<F>, reason: impl Into<R>) -> Self {
        let mut faults = Self::default();
        faults.push(field, reason);
        faults
    }

    /// Adds a fault.
    pub fn push(&mut self, field: impl Into<F>, reason: impl Into<R>) {
        self.count += 1;
        if self.faults.len() < Self::MOST {
            self.faults.push(Fault { field: field.into(), reason: reason.into() });
        }
    }

    /// Takes over another list's faults.
    pub fn append<G: Into<F>, S: Into<R>>(&mut self, other: Faults<G, S>) {
        self.count += other.count;
        let room = Self::MOST - self.faults.len();
        let each = other.faults.into_iter().take(room);
        self.faults.extend(each.map(|fault| Fault { field: fault.field.into(), reason: fault.reason.into() }));
    }

    /// The same faults among those of a wider room.
    pub fn widened<G: From<F>, S: From<R>>(self) -> Faults<G, S> {
        let mut faults = Faults::default();
        faults.append(self);
        faults
    }

    /// The same faults of other fields.
    pub fn placed<G>(self, field: impl Fn(F) -> G) -> Faults<G, R> {
        let each = self.faults.into_iter();
        let faults = each.map(|fault| Fault { field: field(fault.field), reason: fault.reason }).collect();
        Faults { faults, count: self.count }
    }

    /// The faults kept.
    pub fn list(&self) -> &[Fault<F, R>] {
        &self.faults
    }

    /// How many there were.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// `Ok(value)` when there are none.
    pub fn into_result<T>(self, value: T) -> Result<T, Self> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }
}

impl<F: fmt::Debug, R: fmt::Display> fmt::Display for Faults<F, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, Fault { field, reason }) in self.faults.iter().enumerate() {
            let between = if k == 0 { "" } else { "; " };
            write!(f, "{between}{field:?}: {reason}")?;
        }
        match self.count - self.faults.len() {
            0 => Ok(()),
            more => write!(f, "; and {more} more"),
        }
    }
}

impl<F: fmt::Debug, R: fmt::Debug + fmt::Display> std::error::Error for Faults<F, R> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_are_kept_and_all_are_counted() {
        let mut faults: Faults<usize, &str> = (0..Faults::<usize, &str>::MOST).fold(Faults::default(), |mut all, k| {
            all.push(k, "wrong");
            all
        });
        faults.append(Faults::<usize, &str>::one(7usize, "more"));
        assert_eq!((faults.list().len(), faults.count()), (100, 101));
        assert!(faults.to_string().starts_with("0: wrong; 1: wrong; "));
        assert!(faults.to_string().ends_with("99: wrong; and 1 more"));
        assert_eq!(faults.placed(|k| k + 1).list()[0], Fault { field: 1, reason: "wrong" });
    }
}
