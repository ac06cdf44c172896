//! Symmetric banded matrices: products, `L Lᵀ`, solves, and the band of the inverse.
//!
//! n rows of half-bandwidth w cost O(n w²) to factor, O(n w) to solve and O(n w²) for the entries
//! of the inverse within the band (Takahashi's recursion), which is all that traces and variances
//! need. Rows are stored end to end, so that the inner loops are dot products of neighbouring
//! numbers.

use super::{cancel, real::Real, with_fma};

/// A symmetric matrix that is 0 further than `width` from the diagonal; its lower half, row by row.
#[derive(Clone, Debug)]
pub struct SymmetricBand<T> {
    size: usize,
    width: usize,
    entries: Vec<T>,
}

/// Sums running side by side in a dot product.
const CHAINS: usize = 8;

with_fma! {
    /// The scalar product.
    fn dot<T: Real>(x: &[T], y: &[T]) -> T {
        let mut sums = [T::of(0.0); CHAINS];
        let (whole_x, whole_y) = (x.chunks_exact(CHAINS), y.chunks_exact(CHAINS));
        let rest = whole_x.remainder().iter().zip(whole_y.remainder());
        let rest = rest.fold(T::of(0.0), |sum, (&x, &y)| x.mul_add(y, sum));
        for (x, y) in whole_x.zip(whole_y) {
            for k in 0..CHAINS {
                sums[k] = x[k].mul_add(y[k], sums[k]);
            }
        }
        sums.into_iter().fold(rest, |total, sum| total + sum)
    }

    /// `y += factor · x`.
    fn add_multiple<T: Real>(factor: T, x: &[T], y: &mut [T]) {
        for (to, &x) in y.iter_mut().zip(x) {
            *to = factor.mul_add(x, *to);
        }
    }

    /// `y += x · factor`, which rounds otherwise in double-double.
    fn add_entries<T: Real>(x: &[T], factor: T, y: &mut [T]) {
        for (to, &x) in y.iter_mut().zip(x) {
            *to = x.mul_add(factor, *to);
        }
    }
}

impl<T: Real> SymmetricBand<T> {
    /// All zeros.
    pub fn zeros(size: usize, width: usize) -> Self {
        let width = width.min(size.saturating_sub(1));
        SymmetricBand { size, width, entries: vec![T::of(0.0); size * (width + 1)] }
    }

    /// Rows and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of diagonals above the main one that may differ from 0.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Row `i` from its first column to the diagonal, and that first column.
    fn row(&self, i: usize) -> (usize, &[T]) {
        let first = i.saturating_sub(self.width);
        let end = (i + 1) * (self.width + 1);
        (first, &self.entries[end - (i + 1 - first)..end])
    }

    fn at(&self, i: usize, j: usize) -> usize {
        i * (self.width + 1) + j + self.width - i
    }

    /// The entry at (i, j), in either half; 0 outside of the band.
    pub fn get(&self, i: usize, j: usize) -> T {
        let (i, j) = if i < j { (j, i) } else { (i, j) };
        if i - j > self.width { T::of(0.0) } else { self.entries[self.at(i, j)] }
    }

    /// Adds to the entries at (i, j) and (j, i), which are stored once; `j ≤ i ≤ j + width`.
    pub fn add(&mut self, i: usize, j: usize, value: T) {
        let at = self.at(i, j);
        self.entries[at] += value;
    }

    /// `A x`.
    pub fn multiply(&self, x: &[T]) -> Vec<T> {
        let mut y = vec![T::of(0.0); self.size];
        for i in 0..self.size {
            cancel::every(5 * (self.width + 1), i);
            let (first, row) = self.row(i);
            let (before, diagonal) = row.split_at(i - first);
            y[i] += dot(before, &x[first..i]) + diagonal[0] * x[i];
            add_entries(before, x[i], &mut y[first..i]);
        }
        y
    }

    /// `xᵀ A y`.
    pub fn form(&self, x: &[T], y: &[T]) -> T {
        dot(x, &self.multiply(y))
    }

    /// `trace(A B)` of two matrices of the same size and width.
    pub fn trace_of_product(&self, other: &Self) -> T {
        let mut sum = T::of(0.0);
        for i in 0..self.size {
            cancel::every(5 * (self.width + 1), i);
            let ((first, a), (_, b)) = (self.row(i), other.row(i));
            let inner = i - first;
            sum += dot(&a[..inner], &b[..inner]).mul_f64(2.0) + a[inner] * b[inner];
        }
        sum
    }

    /// `D A D` for the diagonal matrix D of `scale`.
    pub fn scaled(mut self, scale: &[f64]) -> Self {
        for i in 0..self.size {
            for j in i.saturating_sub(self.width)..=i {
                let at = self.at(i, j);
                self.entries[at] = self.entries[at].mul_f64(scale[i]).mul_f64(scale[j]);
            }
        }
        self
    }

    /// `A + factor B`, B being of the same size and width.
    pub fn plus(&self, factor: T, other: &SymmetricBand<f64>) -> Self {
        let entries = self.entries.iter().zip(&other.entries).map(|(&a, &b)| factor.mul_f64(b) + a).collect();
        SymmetricBand { entries, ..*self }
    }

    /// The same numbers, rounded to doubles.
    pub fn to_f64(&self) -> SymmetricBand<f64> {
        SymmetricBand { size: self.size, width: self.width, entries: self.entries.iter().map(|x| x.to_f64()).collect() }
    }

    /// Factors `A = L Lᵀ`. A column whose pivot is at most `floor` times its diagonal entry is
    /// dependent on those before it within rounding: it is left out (as if its row and column were
    /// those of the identity) and its index is reported.
    pub fn cholesky(mut self, floor: f64) -> Cholesky<T> {
        let mut undetermined = Vec::new();
        let mut skipped = vec![false; self.size];
        let mut least = f64::INFINITY;
        let stride = self.width + 1;
        for i in 0..self.size {
            cancel::every(2 * (self.width + 1) * (self.width + 1), i);
            let first = i.saturating_sub(self.width);
            let (above, rest) = self.entries.split_at_mut(i * stride);
            // row i, aligned so that its last entry is the diagonal
            let row = &mut rest[stride - (i + 1 - first)..stride];
            for j in first..i {
                if skipped[j] {
                    row[j - first] = T::of(0.0);
                    continue;
                }
                let start = j * stride + first + self.width - j;
                let other = &above[start..(j + 1) * stride];
                let inner = j - first;
                let left = row[inner] - dot(&row[..inner], &other[..inner]);
                row[inner] = left / other[inner];
            }
            let diagonal = row[i - first];
            let pivot = diagonal - dot(&row[..i - first], &row[..i - first]);
            let share = pivot.to_f64() / diagonal.to_f64();
            if share > floor {
                least = least.min(share);
                row[i - first] = pivot.sqrt();
            } else {
                // NaN, from a diagonal of 0, comes here too
                skipped[i] = true;
                undetermined.push(i);
                row.fill(T::of(0.0));
                row[i - first] = T::of(1.0);
            }
        }
        Cholesky { l: self, undetermined, least_pivot: least }
    }
}

/// `A = L Lᵀ`.
#[derive(Clone, Debug)]
pub struct Cholesky<T> {
    l: SymmetricBand<T>,
    /// Columns that were left out.
    pub undetermined: Vec<usize>,
    /// The least pivot, as a share of its diagonal entry: 1 − R² of that column on those before it.
    pub least_pivot: f64,
}

impl<T: Real> Cholesky<T> {
    /// Solves `A x = b` in place.
    pub fn solve(&self, b: &mut [T]) {
        for i in 0..self.l.size {
            cancel::every(5 * (self.l.width + 1), i);
            let (first, row) = self.l.row(i);
            let inner = i - first;
            b[i] = (b[i] - dot(&row[..inner], &b[first..i])) / row[inner];
        }
        for i in (0..self.l.size).rev() {
            cancel::every(5 * (self.l.width + 1), i);
            let (first, row) = self.l.row(i);
            let (before, diagonal) = row.split_at(i - first);
            let x = b[i] / diagonal[0];
            b[i] = x;
            add_multiple(-x, before, &mut b[first..i]);
        }
    }

    /// The entries of `A⁻¹` within the band.
    pub fn inverse_band(&self) -> SymmetricBand<T> {
        let (n, w) = (self.l.size, self.l.width);
        let mut inverse = SymmetricBand::zeros(n, w);
        if w == 0 {
            for i in 0..n {
                let d = self.l.get(i, i);
                inverse.add(i, i, T::of(1.0) / (d * d));
            }
            return inverse;
        }
        // the square of the inverse that the next row needs: index i is stored at i mod w
        let mut window = vec![T::of(0.0); w * w];
        let mut row = vec![T::of(0.0); w];
        for i in (0..n).rev() {
            cancel::every(2 * (w + 1) * (w + 1), i);
            let last = (i + w).min(n - 1);
            let diagonal = self.l.get(i, i);
            row.fill(T::of(0.0));
            let mut own = T::of(1.0) / (diagonal * diagonal);
            for k in i + 1..=last {
                let factor = -(self.l.get(k, i) / diagonal);
                if !factor.is_zero() {
                    let slot = (k % w) * w;
                    add_multiple(factor, &window[slot..slot + w], &mut row);
                }
            }
            for k in i + 1..=last {
                own -= self.l.get(k, i) / diagonal * row[k % w];
                inverse.add(k, i, row[k % w]);
            }
            inverse.add(i, i, own);
            // index i takes the place of index i + w
            row[i % w] = own;
            window[(i % w) * w..(i % w + 1) * w].copy_from_slice(&row);
            for k in 0..w {
                window[k * w + i % w] = row[k];
            }
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dd;
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    fn example(n: usize, w: usize, numbers: &[f64]) -> (SymmetricBand<f64>, DMatrix<f64>) {
        let mut band = SymmetricBand::zeros(n, w);
        for i in 0..n {
            for j in i.saturating_sub(w)..=i {
                let off = 0.9 * numbers[(7 * i + j) % numbers.len()];
                band.add(i, j, if i == j { 2.0 * w as f64 + 1.0 + off } else { off });
            }
        }
        let dense = DMatrix::from_fn(n, n, |i, j| band.get(i, j));
        (band, dense)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn factor_solve_and_inverse_agree_with_dense_ones(
            n in 1usize..30, w in 0usize..12, numbers in prop::collection::vec(-1.0..1.0f64, 50)
        ) {
            let (band, dense) = example(n, w, &numbers);
            let inverse = dense.clone().try_inverse().unwrap();
            let factor = band.clone().cholesky(0.0);
            prop_assert!(factor.undetermined.is_empty());
            let x: Vec<f64> = (0..n).map(|i| numbers[i % 50]).collect();
            let mut b = band.multiply(&x);
            let product = &dense * nalgebra::DVector::from_column_slice(&x);
            prop_assert!(b.iter().zip(product.iter()).all(|(a, b)| (a - b).abs() < 1e-12));
            factor.solve(&mut b);
            prop_assert!(b.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-12));
            let selected = factor.inverse_band();
            for i in 0..n {
                for j in i.saturating_sub(band.width())..=i {
                    prop_assert!((selected.get(i, j) - inverse[(i, j)]).abs() < 1e-13);
                }
            }
            let identity = band.trace_of_product(&selected);
            prop_assert!((identity - n as f64).abs() < 1e-11);
        }
    }

    #[test]
    fn dependent_columns_are_named_and_left_out() {
        let mut band = SymmetricBand::<Dd>::zeros(4, 2);
        for (i, j, x) in [(0, 0, 1.0), (1, 0, 1.0), (1, 1, 1.0), (2, 2, 3.0), (3, 2, 1.0)] {
            band.add(i, j, Dd::from(x));
        }
        let factor = band.cholesky(1e-25);
        assert_eq!(factor.undetermined, [1, 3]);
        let mut b = [2.0, 5.0, 6.0, 7.0].map(Dd::from);
        factor.solve(&mut b);
        assert_eq!((b[0].to_f64(), b[2].to_f64()), (2.0, 2.0));
    }
}
