//! The triangular factor of a tall matrix and the right-hand side carried along, by Householder
//! reflections.
//!
//! The first block of rows is triangularised in place. Later rows are folded into the factor block
//! by block: one reflection per column sends the column of the block to nothing and the diagonal of
//! `R` to the joint length. So the work stays in the cache however many rows there are. `Q` is
//! never formed. Each column of `R` is as accurate as the column of the matrix it came from,
//! whatever the sizes of the other columns.

use nalgebra::{DMatrix, DVector};

use super::cancel;
use super::columns::{axpy, dot};
use super::dd::exponent_of;
use super::lanes::Laned;
use super::lanes::{LANES, Lanes, lanes_for};

/// Rows folded in at a time.
const BLOCK: usize = 128;

/// Columns between two checkpoints: small matrices have few.
const STRETCH: usize = 8;

/// The triangular factor, the transformed right-hand side and the squared length of what the
/// columns cannot reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Qr<T: Laned> {
    /// `n x n`, upper triangular, diagonal not negative; zero rows below if there were fewer than
    /// `n` rows.
    pub r: DMatrix<T>,
    /// The first `n` entries of `Qᵀy`; zeros where `r` has zero rows.
    pub qty: DVector<T>,
    /// The squared norm of the rest of `Qᵀy`: the residual sum of squares of the least-squares fit.
    pub rss: T,
}

/// Triangularises `a` and applies the same reflections to `y`, which has as many entries as `a` has
/// rows.
///
/// ```
/// use flankfit_numerics::qr_with_rhs;
/// use nalgebra::{DMatrix, DVector};
///
/// // One column (3, 4): R is its length 5, and of y = (0, 5) the part 4 lies along it; a part of
/// // length 3 is left over.
/// let column = DMatrix::from_column_slice(2, 1, &[3.0, 4.0]);
/// let qr = qr_with_rhs(column, DVector::from_vec(vec![0.0, 5.0_f64]));
/// assert!((qr.r[(0, 0)] - 5.0).abs() < 1e-14 && (qr.qty[0] - 4.0).abs() < 1e-14);
/// assert!((qr.rss - 9.0).abs() < 1e-13);
/// ```
pub fn qr_with_rhs<T: Laned>(a: DMatrix<T>, y: DVector<T>) -> Qr<T> {
    let (rows, n) = a.shape();
    let block = BLOCK.max(2 * n);
    let mut fold = Fold::new(n);
    for start in (0..rows).step_by(block) {
        let end = (start + block).min(rows);
        fold.load(end - start, |j| &a.as_slice()[j * rows + start..j * rows + end], &y.as_slice()[start..end]);
        if start == 0 {
            fold.triangularise(end);
        } else {
            fold.fold();
        }
    }
    fold.finish()
}

/// A factor under construction: `[R | Qᵀy]` by columns, and the block of rows being folded in.
struct Fold<T: Laned> {
    n: usize,
    /// Column `j` holds its `n` entries of `R`; the last column holds `Qᵀy`.
    head: Vec<T>,
    /// The block, by columns of `stride` lanes; the last column holds `y`.
    tail: Vec<T::Lanes>,
    stride: usize,
    rss: T,
}

impl<T: Laned> Fold<T> {
    fn new(n: usize) -> Self {
        Fold { n, head: vec![T::zero(); n * (n + 1)], tail: Vec::new(), stride: 0, rss: T::zero() }
    }

    fn load<'a>(&mut self, rows: usize, column: impl Fn(usize) -> &'a [T], y: &'a [T]) {
        self.stride = lanes_for(rows);
        self.tail.clear();
        self.tail.reserve((self.n + 1) * self.stride);
        for j in 0..=self.n {
            let source = if j < self.n { column(j) } else { y };
            for numbers in source.chunks(LANES) {
                let mut lanes = T::Lanes::ZERO;
                for (k, &x) in numbers.iter().enumerate() {
                    lanes.set(k, x);
                }
                self.tail.push(lanes);
            }
        }
    }

    /// The first block, of `rows` rows, by itself.
    fn triangularise(&mut self, rows: usize) {
        let (n, stride) = (self.n, self.stride);
        let top_rows = n.min(rows);
        let mut v = Vec::with_capacity(stride);
        for k in 0..top_rows {
            cancel::every(STRETCH, k);
            let (from, lane) = (k / LANES, k % LANES);
            let (done, rest) = self.tail.split_at_mut((k + 1) * stride);
            let column = &mut done[k * stride..];
            v.clear();
            v.extend_from_slice(&column[from..]);
            let head = v[0].get(lane);
            for above in 0..=lane {
                v[0].set(above, T::zero());
            }
            let Some(reflection) = Reflection::of(head, &mut v) else { continue };
            v[0].set(lane, reflection.top);
            column[from].set(lane, reflection.diagonal);
            for x in rest.chunks_exact_mut(stride) {
                let w = dot::<T>(&v, &x[from..]) * reflection.factor;
                axpy(-w, &v, &mut x[from..]);
            }
        }
        for j in 0..=n {
            for i in 0..top_rows.min(j + 1) {
                self.head[j * n + i] = self.tail[j * stride + i / LANES].get(i % LANES);
            }
        }
        let y = &mut self.tail[n * stride..];
        for i in 0..top_rows {
            y[i / LANES].set(i % LANES, T::zero());
        }
        self.rss = dot(y, y);
    }

    /// A later block, under the factor so far.
    fn fold(&mut self) {
        let (n, stride) = (self.n, self.stride);
        for k in 0..n {
            cancel::every(STRETCH, k);
            let (done, rest) = self.tail.split_at_mut((k + 1) * stride);
            let v = &mut done[k * stride..];
            let Some(reflection) = Reflection::of(self.head[k * n + k], v) else { continue };
            self.head[k * n + k] = reflection.diagonal;
            for (j, x) in rest.chunks_exact_mut(stride).enumerate() {
                let top = &mut self.head[(k + 1 + j) * n + k];
                let w = reflection.top.fma(*top, dot(v, x)) * reflection.factor;
                *top = (-w).fma(reflection.top, *top);
                axpy(-w, v, x);
            }
        }
        let y = &self.tail[n * stride..];
        self.rss += dot(y, y);
    }

    fn finish(self) -> Qr<T> {
        let n = self.n;
        let mut r = DMatrix::<T>::zeros(n, n);
        let mut qty = DVector::<T>::zeros(n);
        for i in 0..n {
            let flip = self.head[i * n + i] < T::zero();
            let signed = |x: T| if flip { -x } else { x };
            for j in i..n {
                r[(i, j)] = signed(self.head[j * n + i]);
            }
            qty[i] = signed(self.head[n * n + i]);
        }
        Qr { r, qty, rss: self.rss }
    }
}

/// The reflection `I - factor v vᵀ` that turns a column into `diagonal` on top of zeros; `v` is
/// `top` on top of the block column.
struct Reflection<T> {
    top: T,
    factor: T,
    diagonal: T,
}

impl<T: Laned> Reflection<T> {
    /// None for a zero column. Scales `tail` (and with it `v`, whose length does not matter) by a
    /// power of two where its squares would leave the range of a double.
    fn of(head: T, tail: &mut [T::Lanes]) -> Option<Self> {
        const RANGE: std::ops::Range<f64> = 1e-120..1e120;
        let mut head = head;
        let mut exponent = 0;
        let mut square = head.fma(head, dot(tail, tail));
        if !RANGE.contains(&square.to_f64()) {
            let mut largest = head.to_f64().abs();
            for lanes in tail.iter() {
                for k in 0..LANES {
                    largest = largest.max(lanes.get(k).to_f64().abs());
                }
            }
            if square.is_zero() && largest == 0.0 {
                return None;
            }
            if largest > 0.0 && largest.is_finite() {
                exponent = -exponent_of(largest);
            }
            for lanes in tail.iter_mut() {
                for k in 0..LANES {
                    lanes.set(k, lanes.get(k).ldexp(exponent));
                }
            }
            head = head.ldexp(exponent);
            square = head.fma(head, dot(tail, tail));
        }
        let norm = square.sqrt();
        // The sign that adds moduli: no cancellation.
        let (top, diagonal) = if head < T::zero() { (head - norm, norm) } else { (head + norm, -norm) };
        let factor = T::one() / (norm * (norm + head.abs()));
        Some(Reflection { top, factor, diagonal: diagonal.ldexp(-exponent) })
    }
}

#[cfg(test)]
#[path = "qr_tests.rs"]
mod tests;
