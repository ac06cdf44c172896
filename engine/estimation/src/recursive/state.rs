//! State of a recursive estimate as plain numbers, for storage.

use flankfit_numerics::Dd;

/// The numbers of an estimate in a fixed order, and the names of its columns.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Everything that is summed, in an order that only the engine knows.
    pub numbers: Vec<f64>,
    /// Names of a matrix's columns, where its nodes have any.
    pub names: Option<Vec<String>>,
}

/// Reads numbers in the order in which they were written.
pub(super) struct Numbers<'a> {
    rest: &'a [f64],
}

impl<'a> Numbers<'a> {
    pub(super) fn new(numbers: &'a [f64]) -> Self {
        Numbers { rest: numbers }
    }

    pub(super) fn take(&mut self, count: usize) -> Option<Vec<f64>> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken.to_vec())
    }

    pub(super) fn array<const N: usize>(&mut self) -> Option<[f64; N]> {
        self.take(N)?.try_into().ok()
    }

    /// Double-doubles.
    pub(super) fn wide(&mut self, count: usize) -> Option<Vec<Dd>> {
        let pairs = self.take(count.checked_mul(2)?)?;
        Some(pairs.as_chunks::<2>().0.iter().map(|&[hi, lo]| Dd { hi, lo }).collect())
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.rest.is_empty()
    }
}
