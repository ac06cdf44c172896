//! Singular values and vectors by one-sided Jacobi rotations.
//!
//! Pairs of columns are rotated until all are orthogonal to working precision, relative to their
//! own lengths. That is what keeps the digits of small singular values: for `A = B D` with any
//! diagonal `D` every singular value is accurate to the condition of `B`, not of `A`. Columns are
//! taken longest first (de Rijk), which saves sweeps.
//!
//! The matrix is scaled by a power of two to the top of the range of a double, so that columns
//! shorter than the longest by up to 280 decimal orders still have squares; what is shorter counts
//! as zero. A column that rotations have shortened to the square of the roundoff is a dependent one
//! and becomes zero.

use nalgebra::DMatrix;

use super::cancel;
use super::columns::{dot, rotate, shear};
use super::dd::{exponent_of, pow2};
use super::dispatch::fma;
use super::lanes::Laned;
use super::lanes::{LANES, Lanes, lanes_for};

/// Sweeps over all pairs after which the iteration counts as failed; 5 to 10 are usual.
const SWEEP_LIMIT: usize = 60;
/// Binary exponent to which the largest entry is scaled; it leaves a margin for the squares of
/// columns of a million entries.
const TOP_EXPONENT: i32 = 490;
/// Squared lengths below this have lost digits to underflow.
const SMALLEST_SQUARE: f64 = 1e-270;
/// Entries that differ by less than this count as equal where the sign of a vector is chosen:
/// rounding must not choose it.
const SIGN_TIE: f64 = 1e-9;

/// The singular value decomposition `A V = U Σ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Svd<T: Laned> {
    /// The singular values, ascending.
    pub sigma: Vec<T>,
    /// `A V`: column `i` is `σᵢ uᵢ`.
    pub us: DMatrix<T>,
    /// The right singular vectors, `n x n`; of each the entry of largest modulus, the first of
    /// those equal to nine digits, is positive.
    pub v: DMatrix<T>,
}

/// Decomposes `a`. None if an entry is not finite or the sweep limit is reached.
///
/// ```
/// use flankfit_numerics::svd;
/// use nalgebra::DMatrix;
///
/// // Columns (3, 4) and (0, 1e-12): the small singular value is right to nearly all its digits,
/// // since both together multiply to the determinant, 3e-12.
/// let a = DMatrix::from_column_slice(2, 2, &[3.0_f64, 4.0, 0.0, 1e-12]);
/// let sigma = svd(a).unwrap().sigma;
/// assert!((sigma[0] * sigma[1] / 3e-12 - 1.0).abs() < 1e-14);
/// ```
pub fn svd<T: Laned>(a: DMatrix<T>) -> Option<Svd<T>> {
    let exponent = scale_exponent(&a)?;
    let (rows, n) = a.shape();
    let mut columns = Columns::new(rows, n);
    for j in 0..n {
        let column = columns.column_mut(j);
        write(&mut column[..lanes_for(rows)], a.column(j).iter().map(|x| x.ldexp(exponent)));
        column[lanes_for(rows) + j / LANES].set(j % LANES, T::one());
    }
    columns.orthogonalise()?;
    Some(columns.finish(exponent))
}

/// The exponent by which to scale, 0 for the zero matrix; None if an entry is not finite.
pub(super) fn scale_exponent<T: Laned>(a: &DMatrix<T>) -> Option<i32> {
    let mut largest = 0.0f64;
    let mut finite = true;
    for x in a.iter() {
        finite &= x.is_finite();
        largest = largest.max(x.to_f64().abs());
    }
    if !finite {
        None
    } else if largest == 0.0 {
        Some(0)
    } else {
        Some(TOP_EXPONENT - exponent_of(largest))
    }
}

/// Fills lanes from the first number on.
pub(super) fn write<T: Laned>(lanes: &mut [T::Lanes], numbers: impl Iterator<Item = T>) {
    for (i, x) in numbers.enumerate() {
        lanes[i / LANES].set(i % LANES, x);
    }
}

/// The columns being rotated: each holds its `rows` entries of `A V`, then its `n` entries of `V`.
pub(super) struct Columns<T: Laned> {
    rows: usize,
    n: usize,
    /// Lanes of one column that belong to `A V`.
    top: usize,
    /// Lanes of one column.
    stride: usize,
    lanes: Vec<T::Lanes>,
    /// Length and origin of each column.
    facts: Vec<Facts<T>>,
}

#[derive(Clone, Copy)]
struct Facts<T> {
    /// Squared length.
    square: T,
    /// Length, as a double.
    length: f64,
    /// The squared length of what the column was made from: its root times the roundoff is what its
    /// entries may be wrong by.
    origin: f64,
}

impl<T: Laned> Facts<T> {
    #[inline(always)]
    fn measure(&mut self, square: T) {
        self.square = square;
        self.length = square.to_f64().max(0.0).sqrt();
    }
}

impl<T: Laned> Columns<T> {
    pub(super) fn new(rows: usize, n: usize) -> Self {
        let top = lanes_for(rows);
        let stride = top + lanes_for(n);
        let facts = vec![Facts { square: T::zero(), length: 0.0, origin: 0.0 }; n];
        Columns { rows, n, top, stride, lanes: vec![T::Lanes::ZERO; n * stride], facts }
    }

    /// Column `j`: the lanes of `A V`, then those of `V`.
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [T::Lanes] {
        &mut self.lanes[j * self.stride..(j + 1) * self.stride]
    }

    /// Records that column `j` was made from vectors of this length, if that is more than its own.
    pub(super) fn made_from(&mut self, j: usize, length: f64) {
        self.facts[j].origin = length * length;
    }

    #[inline(always)]
    fn pair_mut(&mut self, p: usize, q: usize) -> (&mut [T::Lanes], &mut [T::Lanes]) {
        let (left, right) = self.lanes.split_at_mut(q * self.stride);
        (&mut left[p * self.stride..(p + 1) * self.stride], &mut right[..self.stride])
    }

    /// Rotates until every pair is orthogonal.
    pub(super) fn orthogonalise(&mut self) -> Option<()> {
        let tolerance = T::EPSILON * (self.rows as f64).sqrt().max(2.0) * 2.0;
        for j in 0..self.n {
            self.measure(j);
            self.facts[j].origin = self.facts[j].origin.max(self.facts[j].square.to_f64());
        }
        for _ in 0..SWEEP_LIMIT {
            cancel::checkpoint();
            let worst = self.sweep(tolerance);
            // Rotations leave of every cosine at most about the product of two such numbers, times
            // the pairs that mix.
            if worst.cosine * worst.turn * self.n as f64 <= tolerance {
                for j in 0..self.n {
                    self.measure(j);
                }
                return Some(());
            }
            for j in 0..self.n {
                self.measure(j);
            }
        }
        None
    }

    /// Measures column `j` anew; a column that is nothing but rounding becomes zero.
    #[inline(always)]
    fn measure(&mut self, j: usize) {
        let column = &mut self.lanes[j * self.stride..j * self.stride + self.top];
        let mut square: T = dot(column, column);
        let facts = &mut self.facts[j];
        let negligible = 64.0 * T::EPSILON.powi(4) * facts.origin;
        if square.to_f64() < SMALLEST_SQUARE.max(negligible) {
            column.fill(T::Lanes::ZERO);
            square = T::zero();
        }
        facts.measure(square);
    }

    /// Visits every pair once and returns the largest cosine and the largest rotation.
    fn sweep(&mut self, tolerance: f64) -> Worst {
        let mut worst = Worst { cosine: 0.0, turn: 0.0 };
        for p in 0..self.n.saturating_sub(1) {
            cancel::every(200 * self.n, p);
            self.longest_to(p);
            for q in p + 1..self.n {
                let (x, y) = (self.facts[p], self.facts[q]);
                if y.length == 0.0 || x.length == 0.0 {
                    continue;
                }
                let top = self.top;
                let (column_x, column_y) = self.pair_mut(p, q);
                let inner: T = dot(&column_x[..top], &column_y[..top]);
                let lengths = x.length * y.length;
                if inner.to_f64().abs() <= tolerance * lengths {
                    continue;
                }
                let t = tangent((x.square - y.square).to_f64(), inner.to_f64());
                if t.abs() < 0.1 * T::EPSILON.sqrt() {
                    // The common factor is 1 to working precision.
                    shear::<T>(t, column_x, column_y);
                } else {
                    let t = T::of(t);
                    rotate::<T>(t.to_f64(), T::one() / t.fma(t, T::one()).sqrt(), column_x, column_y);
                }
                worst.cosine = worst.cosine.max(inner.to_f64().abs() / lengths);
                let ratio = if x.length > y.length { x.length / y.length } else { y.length / x.length };
                worst.turn = worst.turn.max(t.abs() * ratio);
                let cos_squared = 1.0 / fma(t, t, 1.0);
                self.facts[p].origin = cos_squared * (x.origin + t * t * y.origin);
                self.facts[q].origin = cos_squared * (y.origin + t * t * x.origin);
                self.update(p, x.square + inner.mul_f64(t), x.square);
                self.update(q, y.square - inner.mul_f64(t), y.square);
            }
        }
        worst
    }

    /// Takes over a squared length that follows from the rotation, unless it cancelled.
    #[inline(always)]
    fn update(&mut self, j: usize, square: T, before: T) {
        if square < before.mul_f64(0.25) {
            self.measure(j);
        } else {
            self.facts[j].measure(square);
        }
    }

    /// Swaps the longest of the columns from `p` on into place `p`.
    #[inline(always)]
    fn longest_to(&mut self, p: usize) {
        let mut longest = p;
        for j in p + 1..self.n {
            if self.facts[j].length > self.facts[longest].length {
                longest = j;
            }
        }
        if longest != p {
            self.facts.swap(p, longest);
            let (x, y) = self.pair_mut(p, longest);
            x.swap_with_slice(y);
        }
    }

    /// Singular values ascending, signs canonical, scale undone.
    pub(super) fn finish(self, exponent: i32) -> Svd<T> {
        let (rows, n, top) = (self.rows, self.n, self.top);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| {
            self.facts[i].square.partial_cmp(&self.facts[j].square).unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut us = Vec::with_capacity(rows * n);
        let mut v = Vec::with_capacity(n * n);
        let mut sigma = Vec::with_capacity(n);
        for &j in &order {
            let column = &self.lanes[j * self.stride..(j + 1) * self.stride];
            let read = |lanes: &[T::Lanes], i: usize| lanes[i / LANES].get(i % LANES);
            let (above, below) = column.split_at(top);
            // The roundings of many cosines add up to a length of `v` off by some units; `A V`
            // carries the same factor.
            let unit = T::one() / dot::<T>(below, below).sqrt();
            let largest = (0..n).map(|i| read(below, i).to_f64().abs()).fold(0.0, f64::max);
            let first = (0..n).map(|i| read(below, i).to_f64()).find(|x| x.abs() >= largest * (1.0 - SIGN_TIE));
            let factor = if first.is_some_and(|x| x < 0.0) { -unit } else { unit };
            v.extend((0..n).map(|i| read(below, i) * factor));
            us.extend((0..rows).map(|i| (read(above, i) * factor).ldexp(-exponent)));
            sigma.push((self.facts[j].square.sqrt() * unit).ldexp(-exponent));
        }
        Svd { sigma, us: DMatrix::from_vec(rows, n, us), v: DMatrix::from_vec(n, n, v) }
    }
}

struct Worst {
    cosine: f64,
    turn: f64,
}

/// The tangent of the smaller of the two angles that make a pair orthogonal; `difference` is the
/// squared length of the first column less that of the second, `inner` their scalar product.
#[inline(always)]
fn tangent(difference: f64, inner: f64) -> f64 {
    let zeta = difference * 0.5 / inner;
    if zeta.abs() > pow2(60) {
        0.5 / zeta
    } else {
        let t = 1.0 / (zeta.abs() + fma(zeta, zeta, 1.0).sqrt());
        if zeta < 0.0 { -t } else { t }
    }
}

#[cfg(test)]
#[path = "jacobi_tests.rs"]
mod tests;
