//! A triangular factor that takes one row at a time, by Givens rotations.
//!
//! Folding a row into `[R | Qᵀy]` costs O(n²) and keeps nothing of the row: what the columns cannot
//! reach of `y` goes to the residual sum of squares. Entries of the row that are exactly 0 cost
//! nothing, so rows of B-splines are cheap, and a direction that no row has touched stays exactly
//! 0. Rotations are orthogonal: after any number of rows `R` is the factor of all of them to
//! rounding, however they were handed over.

use nalgebra::DMatrix;

use super::{dd::exponent_of, real::Real};

/// `R` (upper, by rows, end to end), `Qᵀy` and the squared length of the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle<T: Real> {
    n: usize,
    /// Row `k` holds its entries from the diagonal on.
    rows: Vec<T>,
    qty: Vec<T>,
    rss: T,
}

impl<T: Real> Triangle<T> {
    /// The factor of no rows at all.
    pub fn new(n: usize) -> Self {
        Triangle { n, rows: vec![T::zero(); n * (n + 1) / 2], qty: vec![T::zero(); n], rss: T::zero() }
    }

    /// A factor from its parts; `None` when their lengths do not belong together.
    pub fn from_parts(n: usize, rows: Vec<T>, qty: Vec<T>, rss: T) -> Option<Self> {
        (rows.len() == n * (n + 1) / 2 && qty.len() == n).then_some(Triangle { n, rows, qty, rss })
    }

    /// The entries of `R` by rows, each from its diagonal on.
    pub fn rows(&self) -> &[T] {
        &self.rows
    }

    /// `Qᵀy`, one entry for each column.
    pub fn qty(&self) -> &[T] {
        &self.qty
    }

    /// Squared length of what the columns cannot reach of `y`.
    pub fn rss(&self) -> T {
        self.rss
    }

    /// `R` as a matrix.
    pub fn r(&self) -> DMatrix<T> {
        let mut r = DMatrix::<T>::zeros(self.n, self.n);
        let mut at = 0;
        for k in 0..self.n {
            for j in k..self.n {
                r[(k, j)] = self.rows[at];
                at += 1;
            }
        }
        r
    }

    /// Replaces `R` by the upper triangle of `r`, for a change of basis.
    pub fn set_r(&mut self, r: &DMatrix<T>) {
        let mut at = 0;
        for k in 0..self.n {
            for j in k..self.n {
                self.rows[at] = r[(k, j)];
                at += 1;
            }
        }
    }

    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.rss.is_finite() && self.rows.iter().chain(&self.qty).all(|x| x.is_finite())
    }

    /// Multiplies the rows seen so far (and what was seen of `y`) by `factor`, whose square is
    /// `squared`.
    pub fn scale(&mut self, factor: T, squared: T) {
        self.rows.iter_mut().chain(&mut self.qty).for_each(|x| *x *= factor);
        self.rss *= squared;
    }

    /// Folds in the row `x` (n entries, used up) with the height `y`.
    ///
    /// ```
    /// use flankfit_numerics::Triangle;
    ///
    /// // A mean, one observation after the other: of 1, 2 and 6 it is 3, and the squares left over
    /// // are 4 + 1 + 9.
    /// let mut triangle = Triangle::<f64>::new(1);
    /// for y in [1.0, 2.0, 6.0] {
    ///     triangle.fold(&mut [1.0], y);
    /// }
    /// let mean = triangle.qty()[0] / triangle.rows()[0];
    /// assert!((mean - 3.0).abs() < 1e-14 && (triangle.rss() - 14.0).abs() < 1e-13);
    /// ```
    pub fn fold(&mut self, x: &mut [T], mut y: T) {
        let n = self.n;
        let mut start = 0;
        for k in 0..n {
            let width = n - k;
            if !x[k].is_zero() {
                let row = &mut self.rows[start..start + width];
                let (c, s, length) = rotation(row[0], x[k]);
                row[0] = length;
                for (above, below) in row[1..].iter_mut().zip(&mut x[k + 1..]) {
                    let (a, b) = (*above, *below);
                    *above = c.fma(a, s * b);
                    *below = c.fma(b, -(s * a));
                }
                let a = self.qty[k];
                self.qty[k] = c.fma(a, s * y);
                y = c.fma(y, -(s * a));
            }
            start += width;
        }
        self.rss = y.fma(y, self.rss);
    }
}

/// `c`, `s` and `√(a² + b²)` of the rotation that turns `(a, b)` into `(√(a² + b²), 0)`; `b` is not
/// 0.
fn rotation<T: Real>(a: T, b: T) -> (T, T, T) {
    const RANGE: std::ops::Range<f64> = 1e-120..1e120;
    let one = T::one();
    if a.is_zero() {
        // exact: an untouched direction takes the row over
        return if b < T::zero() { (T::zero(), -one, -b) } else { (T::zero(), one, b) };
    }
    let largest = a.to_f64().abs().max(b.to_f64().abs());
    let exponent = if RANGE.contains(&largest) || !largest.is_finite() { 0 } else { -exponent_of(largest) };
    let (p, q) = if exponent == 0 { (a, b) } else { (a.ldexp(exponent), b.ldexp(exponent)) };
    let length = p.fma(p, q * q).sqrt();
    (p / length, q / length, length.ldexp(-exponent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dd, qr_with_rhs};
    use nalgebra::DVector;
    use proptest::prelude::*;

    fn folded<T: Real>(n: usize, a: &DMatrix<T>, y: &DVector<T>) -> Triangle<T> {
        let mut triangle = Triangle::new(n);
        for i in 0..a.nrows() {
            let mut row: Vec<T> = a.row(i).iter().copied().collect();
            triangle.fold(&mut row, y[i]);
        }
        triangle
    }

    #[test]
    fn directions_that_no_row_touches_stay_exactly_zero() {
        let mut triangle = Triangle::<Dd>::new(3);
        triangle.fold(&mut [Dd::from(2.0), Dd::ZERO, Dd::from(1.0)], Dd::from(4.0));
        triangle.fold(&mut [Dd::from(1.0), Dd::ZERO, Dd::from(5.0)], Dd::from(1.0));
        assert_eq!(triangle.r()[(1, 1)], Dd::ZERO);
        assert!(triangle.r()[(2, 2)] > Dd::ZERO);
        assert!(triangle.rss().to_f64() < 1e-30);
    }

    #[test]
    fn extreme_sizes_neither_overflow_nor_vanish() {
        for size in [1e-200, 1e200] {
            let mut triangle = Triangle::<f64>::new(1);
            for x in [3.0, 4.0] {
                triangle.fold(&mut [x * size], 0.0);
            }
            assert!((triangle.r()[(0, 0)] / size - 5.0).abs() < 1e-15);
        }
    }

    proptest! {
        #[test]
        fn rows_one_by_one_give_the_factor_of_all(
            (n, m) in (1usize..6, 6usize..30),
            entries in prop::collection::vec(-1.0..1.0f64, 30 * 7),
            fading in 0.5..1.0f64,
        ) {
            let a = DMatrix::from_fn(m, n, |i, j| Dd::from(entries[i * 7 + j]) + if i == j { 2.0 } else { 0.0 });
            let y = DVector::from_fn(m, |i, _| Dd::from(entries[i * 7 + 6]));
            let whole = qr_with_rhs(a.clone(), y.clone());
            let triangle = folded(n, &a, &y);
            let off = |x: Dd, y: Dd| (x - y).abs().to_f64();
            prop_assert!(triangle.r().iter().zip(whole.r.iter()).all(|(x, y)| off(*x, *y) < 1e-28));
            prop_assert!(triangle.qty().iter().zip(whole.qty.iter()).all(|(x, y)| off(*x, *y) < 1e-28));
            prop_assert!(off(triangle.rss(), whole.rss) < 1e-28);

            let factor = Dd::from(fading).sqrt();
            let mut faded = Triangle::new(n);
            let mut weighted = (a.clone(), y.clone());
            for i in 0..m {
                faded.scale(factor, Dd::from(fading));
                let mut row: Vec<Dd> = a.row(i).iter().copied().collect();
                faded.fold(&mut row, y[i]);
                let root = Dd::from(fading).powi((m - 1 - i) as i32).sqrt();
                weighted.0.row_mut(i).iter_mut().for_each(|x| *x *= root);
                weighted.1[i] *= root;
            }
            let whole = qr_with_rhs(weighted.0, weighted.1);
            prop_assert!(faded.r().iter().zip(whole.r.iter()).all(|(x, y)| off(*x, *y) < 1e-28));
            prop_assert!(off(faded.rss(), whole.rss) < 1e-28);
        }
    }
}
