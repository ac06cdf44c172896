//! Banded matrices: factorisation with row exchanges, solves with the matrix and with its
//! transpose.
//!
//! Interpolation by splines leads to these: `n` equations, each with a few neighbouring unknowns.
//! Work is O(n · bandwidth²), memory O(n · bandwidth). Over [`super::Dd`] a solve keeps all digits
//! of a double for any spacing that doubles can represent.

use super::cancel;
use super::real::Real;

/// A square matrix that is 0 further than `lower` below and `upper` above the diagonal.
#[derive(Clone, Debug)]
pub struct Banded<T> {
    size: usize,
    lower: usize,
    upper: usize,
    /// Row by row, each with `lower + 1 + upper` entries and `lower` more for what row exchanges
    /// fill in.
    entries: Vec<T>,
}

/// The pivot of a column is 0 to the precision of its entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the equations are singular at column {column}")]
pub struct Singular {
    /// The column, from 0, in which no pivot is left.
    pub column: usize,
}

impl<T: Real> Banded<T> {
    /// All zeros.
    pub fn zeros(size: usize, lower: usize, upper: usize) -> Self {
        let entries = vec![T::zero(); size * (2 * lower + upper + 1)];
        Banded { size, lower, upper, entries }
    }

    /// Rows and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    fn width(&self) -> usize {
        2 * self.lower + self.upper + 1
    }

    /// Index of entry (row, column) in the storage; the column is within the band of the row or its
    /// fill-in.
    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width() + column + self.lower - row
    }

    /// Puts `value` at (row, column), which lies within the band.
    pub fn set(&mut self, row: usize, column: usize, value: T) {
        debug_assert!(column + self.lower >= row && column <= row + self.upper && column < self.size);
        let at = self.at(row, column);
        self.entries[at] = value;
    }

    /// The entry at (row, column); 0 outside of the band.
    pub fn get(&self, row: usize, column: usize) -> T {
        if column + self.lower < row || column > row + self.upper {
            return T::zero();
        }
        self.entries[self.at(row, column)]
    }

    /// The matrix with every entry turned into a number of another type.
    pub fn map<U: Real>(&self, convert: impl Fn(T) -> U) -> Banded<U> {
        let entries = self.entries.iter().map(|x| convert(*x)).collect();
        Banded { size: self.size, lower: self.lower, upper: self.upper, entries }
    }

    /// The columns that a row reaches.
    fn reach(&self, row: usize) -> std::ops::Range<usize> {
        row.saturating_sub(self.lower)..(row + self.upper + 1).min(self.size)
    }

    /// `A x`.
    pub fn multiply(&self, x: &[T]) -> Vec<T> {
        let row = |i| self.reach(i).fold(T::zero(), |sum, j| self.get(i, j).fma(x[j], sum));
        (0..self.size).map(row).collect()
    }

    /// `Aᵀ x`.
    pub fn multiply_transposed(&self, x: &[T]) -> Vec<T> {
        let mut y = vec![T::zero(); self.size];
        for i in 0..self.size {
            for j in self.reach(i) {
                y[j] = self.get(i, j).fma(x[i], y[j]);
            }
        }
        y
    }

    /// `P A = L U` with the largest pivot of each column.
    ///
    /// ```
    /// use flankfit_numerics::Banded;
    ///
    /// // The second difference: −1, 2, −1.
    /// let mut matrix = Banded::zeros(3, 1, 1);
    /// for i in 0..3_usize {
    ///     for j in i.saturating_sub(1)..(i + 2).min(3) {
    ///         matrix.set(i, j, if i == j { 2.0 } else { -1.0_f64 });
    ///     }
    /// }
    /// let mut x = [1.0, 0.0, 1.0];
    /// matrix.factor()?.solve(&mut x);
    /// assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-15));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn factor(mut self) -> Result<BandedLu<T>, Singular> {
        let (n, width) = (self.size, self.width());
        let mut exchanges = Vec::with_capacity(n);
        for k in 0..n {
            let below = (k + self.lower + 1).min(n);
            let mut pivot = k;
            for i in k + 1..below {
                if self.entries[self.at(i, k)].abs() > self.entries[self.at(pivot, k)].abs() {
                    pivot = i;
                }
            }
            exchanges.push(pivot);
            cancel::every(10 * (self.lower + 1) * (self.lower + self.upper + 1), k);
            let right = (k + self.upper + self.lower + 1).min(n);
            if pivot != k {
                for j in k..right {
                    let (one, other) = (self.at(k, j), self.at(pivot, j));
                    self.entries.swap(one, other);
                }
            }
            let head = self.entries[self.at(k, k)];
            if !head.is_finite() || head.is_zero() {
                return Err(Singular { column: k });
            }
            let start = self.at(k, k);
            for i in k + 1..below {
                let first = self.at(i, k);
                let (above, rest) = self.entries.split_at_mut(i * width);
                let (source, target) = (&above[start..start + right - k], &mut rest[first - i * width..]);
                let factor = target[0] / source[0];
                target[0] = factor;
                for (t, s) in target[1..right - k].iter_mut().zip(&source[1..]) {
                    *t = (-factor).fma(*s, *t);
                }
            }
        }
        Ok(BandedLu { lu: self, exchanges })
    }
}

/// The factors of a banded matrix.
#[derive(Clone, Debug)]
pub struct BandedLu<T> {
    /// U with its filled-in diagonals, and below it the multipliers.
    lu: Banded<T>,
    exchanges: Vec<usize>,
}

impl<T: Real> BandedLu<T> {
    fn right(&self, k: usize) -> usize {
        (k + self.lu.upper + self.lu.lower + 1).min(self.lu.size)
    }

    fn below(&self, k: usize) -> usize {
        (k + self.lu.lower + 1).min(self.lu.size)
    }

    fn entry(&self, i: usize, j: usize) -> T {
        self.lu.entries[self.lu.at(i, j)]
    }

    /// Solves `A x = b` in place.
    pub fn solve(&self, b: &mut [T]) {
        let n = self.lu.size;
        for k in 0..n {
            cancel::every(10 * (self.lu.lower + 1), k);
            b.swap(k, self.exchanges[k]);
            for i in k + 1..self.below(k) {
                b[i] = (-self.entry(i, k)).fma(b[k], b[i]);
            }
        }
        for k in (0..n).rev() {
            cancel::every(10 * (self.lu.lower + self.lu.upper + 1), k);
            let rest = (k + 1..self.right(k)).fold(b[k], |rest, j| (-self.entry(k, j)).fma(b[j], rest));
            b[k] = rest / self.entry(k, k);
        }
    }

    /// Solves `Aᵀ x = b` in place.
    pub fn solve_transposed(&self, b: &mut [T]) {
        let n = self.lu.size;
        for k in 0..n {
            cancel::every(10 * (self.lu.lower + self.lu.upper + 1), k);
            b[k] = b[k] / self.entry(k, k);
            for j in k + 1..self.right(k) {
                b[j] = (-self.entry(k, j)).fma(b[k], b[j]);
            }
        }
        for k in (0..n).rev() {
            cancel::every(10 * (self.lu.lower + 1), k);
            b[k] = (k + 1..self.below(k)).fold(b[k], |rest, i| (-self.entry(i, k)).fma(b[i], rest));
            b.swap(k, self.exchanges[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dd;
    use proptest::prelude::*;

    /// Entries of a matrix that needs row exchanges.
    fn matrix<T: Real>(n: usize, lower: usize, upper: usize, seed: u64) -> Banded<T> {
        let mut a = Banded::zeros(n, lower, upper);
        for i in 0..n {
            for j in a.reach(i) {
                let mixed = (seed + 1) * 7919 + (i * i * 104_729 + j * j * j * 1301 + i * j * 499) as u64;
                a.set(i, j, T::of((mixed % 1009) as f64 / 1009.0 - 0.4));
            }
        }
        a
    }

    proptest! {
        #[test]
        fn solves_both_ways(n in 1usize..30, lower in 0usize..5, upper in 0usize..5, seed in 0u64..1000) {
            let a = matrix::<Dd>(n, lower.min(n - 1), upper.min(n - 1), seed);
            let x: Vec<Dd> = (0..n).map(|i| Dd::from(1.0 + i as f64)).collect();
            let (mut b, mut c) = (a.multiply(&x), a.multiply_transposed(&x));
            let Ok(lu) = a.factor() else { return Ok(()) };
            lu.solve(&mut b);
            lu.solve_transposed(&mut c);
            for i in 0..n {
                prop_assert!((b[i] - x[i]).abs().to_f64() < 1e-12 && (c[i] - x[i]).abs().to_f64() < 1e-12);
            }
        }
    }

    #[test]
    fn a_column_of_zeros_is_singular() {
        let mut a = Banded::<f64>::zeros(3, 1, 1);
        a.set(0, 0, 1.0);
        a.set(2, 2, 1.0);
        assert_eq!(a.factor().unwrap_err(), Singular { column: 1 });
    }
}
