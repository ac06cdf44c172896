//! Matrices times vectors, four columns at a time, and times matrices, in steps that can be
//! cancelled.

use nalgebra::DMatrix;

use super::{cancel, with_fma};

with_fma! {
    /// `A x`.
    pub fn times(a: &DMatrix<f64>, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let rows = a.nrows();
        let mut columns = a.as_slice().chunks_exact((4 * rows).max(1));
        let (x4, x_rest) = x.as_chunks::<4>();
        for (four, x) in columns.by_ref().zip(x4) {
            let (first, second) = four.split_at(2 * rows);
            let ((c0, c1), (c2, c3)) = (first.split_at(rows), second.split_at(rows));
            for ((((out, a), b), c), d) in out.iter_mut().zip(c0).zip(c1).zip(c2).zip(c3) {
                *out = d.mul_add(x[3], c.mul_add(x[2], b.mul_add(x[1], a.mul_add(x[0], *out))));
            }
        }
        for (column, x) in columns.remainder().chunks_exact(rows.max(1)).zip(x_rest) {
            out.iter_mut().zip(column).for_each(|(out, a)| *out = a.mul_add(*x, *out));
        }
    }

    /// `Aᵀ x`.
    pub fn transposed_times(a: &DMatrix<f64>, x: &[f64], out: &mut [f64]) {
        let rows = a.nrows();
        let (x4, x_rest) = x.as_chunks::<4>();
        for (column, out) in a.as_slice().chunks_exact(rows.max(1)).zip(out) {
            let (c4, c_rest) = column.as_chunks::<4>();
            let (c8, c_odd) = c4.as_chunks::<2>();
            let (x8, x_odd) = x4.as_chunks::<2>();
            let (mut even, mut odd) = ([0.0f64; 4], [0.0f64; 4]);
            for (c, x) in c8.iter().zip(x8) {
                for k in 0..4 {
                    even[k] = c[0][k].mul_add(x[0][k], even[k]);
                    odd[k] = c[1][k].mul_add(x[1][k], odd[k]);
                }
            }
            for (c, x) in c_odd.iter().zip(x_odd) {
                for k in 0..4 {
                    even[k] = c[k].mul_add(x[k], even[k]);
                }
            }
            let rest = c_rest.iter().zip(x_rest).fold(0.0f64, |sum, (c, x)| c.mul_add(*x, sum));
            *out = ((even[0] + odd[0]) + (even[1] + odd[1])) + ((even[2] + odd[2]) + (even[3] + odd[3])) + rest;
        }
    }

    /// `Σ xᵢyᵢ`.
    pub fn dot(x: &[f64], y: &[f64]) -> f64 {
        let ((x4, x_rest), (y4, y_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
        let mut sums = [0.0f64; 4];
        for (x, y) in x4.iter().zip(y4) {
            for k in 0..4 {
                sums[k] = x[k].mul_add(y[k], sums[k]);
            }
        }
        let rest = x_rest.iter().zip(y_rest).fold(0.0f64, |sum, (x, y)| x.mul_add(*y, sum));
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }

    /// `y += factor x`.
    pub fn add(factor: f64, x: &[f64], y: &mut [f64]) {
        x.iter().zip(y).for_each(|(x, y)| *y = x.mul_add(factor, *y));
    }
}

/// `A B`; a large product in parts, between which it can be given up.
pub fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    /// Multiplications between two checkpoints: a millisecond or two.
    const STRETCH: usize = 16_000_000;
    let width = (STRETCH / a.len().max(1)).max(8);
    if b.ncols() <= width {
        return a * b;
    }
    let mut result = DMatrix::zeros(a.nrows(), b.ncols());
    for first in (0..b.ncols()).step_by(width) {
        cancel::checkpoint();
        let width = width.min(b.ncols() - first);
        result.columns_mut(first, width).gemm(1.0, a, &b.columns(first, width), 0.0);
    }
    result
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    #[test]
    fn a_large_product_in_parts_is_the_product() {
        let a = DMatrix::from_fn(500, 450, |i, j| ((3 * i + 7 * j) as f64).sin());
        let b = DMatrix::from_fn(450, 200, |i, j| ((5 * i + 2 * j) as f64).cos());
        assert!((product(&a, &b) - &a * &b).amax() < 1e-11);
    }

    #[test]
    fn products_are_those_of_the_definition() {
        for (rows, columns) in [(0, 0), (1, 1), (3, 5), (8, 4), (17, 11), (30, 30)] {
            let a = DMatrix::from_fn(rows, columns, |i, j| ((3 * i + 7 * j) as f64).sin());
            let x = DVector::from_fn(columns, |i, _| (i as f64).cos());
            let y = DVector::from_fn(rows, |i, _| (2.0 * i as f64).cos());
            let (mut ax, mut aty) = (vec![f64::NAN; rows], vec![f64::NAN; columns]);
            times(&a, x.as_slice(), &mut ax);
            transposed_times(&a, y.as_slice(), &mut aty);
            assert!((DVector::from_vec(ax.clone()) - &a * x).amax() < 1e-13 || rows == 0);
            assert!((DVector::from_vec(aty) - a.tr_mul(&y)).amax() < 1e-13 || rows == 0);
            assert!((dot(&ax, y.as_slice()) - DVector::from_vec(ax.clone()).dot(&y)).abs() < 1e-13);
            let mut sum = ax.clone();
            add(2.0, y.as_slice(), &mut sum);
            assert!(sum.iter().zip(&ax).zip(y.iter()).all(|((s, a), y)| (s - a - 2.0 * y).abs() < 1e-14));
        }
    }
}
