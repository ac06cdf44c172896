//! The singular value decomposition in double-double, started from the one in double.
//!
//! Sweeps in double-double are dear, so all but the last one or two are done in double: the right
//! singular vectors of the rounded matrix, made orthogonal to double-double precision, turn the
//! matrix into one whose columns are nearly orthogonal.

use nalgebra::DMatrix;

use super::cancel;
use super::columns::{axpy, dot};
use super::dd::Dd;
use super::jacobi::{Columns, Svd, scale_exponent, svd, write};
use super::lanes::{Ddx4, LANES, Lanes, lanes_for};

/// Decomposes `a` to double-double precision. None if an entry is not finite or the iteration does
/// not end.
pub fn svd_dd(a: &DMatrix<Dd>) -> Option<Svd<Dd>> {
    let exponent = scale_exponent(a)?;
    let (rows, n) = a.shape();
    // The rounded matrix is scaled too, so that no entry that counts is lost to the range of a
    // double.
    let start = match svd(a.map(|x| x.ldexp(exponent).hi)) {
        Some(double) => orthonormal(&double.v),
        None => identity(n),
    };
    let a_lanes = lanes_of(a, |x| x.ldexp(exponent));
    let (top, side) = (lanes_for(rows), lanes_for(n));
    let length = |x: &[Ddx4]| dot::<Dd>(x, x).hi.sqrt();
    let lengths: Vec<f64> = (0..n).map(|k| length(&a_lanes[k * top..(k + 1) * top])).collect();
    let mut columns = Columns::new(rows, n);
    for j in 0..n {
        cancel::every(20 * n * rows, j);
        // Longest first: where the sweeps want it, and the double singular values ascend.
        let v = &start[(n - 1 - j) * side..(n - j) * side];
        let (above, below) = columns.column_mut(j).split_at_mut(top);
        below.copy_from_slice(v);
        let mut length = 0.0;
        for k in 0..n {
            let weight = v[k / LANES].get(k % LANES);
            axpy(weight, &a_lanes[k * top..(k + 1) * top], above);
            length += weight.hi.abs() * lengths[k];
        }
        columns.made_from(j, length);
    }
    columns.orthogonalise()?;
    Some(columns.finish(exponent))
}

/// Makes a matrix orthogonal that is so to double precision: `V (3/2 I - VᵀV / 2)` and the next
/// term of that series.
fn orthonormal(v: &DMatrix<f64>) -> Vec<Ddx4> {
    let n = v.ncols();
    let side = lanes_for(n);
    let v = lanes_of(v, Dd::from);
    let mut result = v.clone();
    let mut defect = DMatrix::<f64>::zeros(n, n);
    let mut defect_dd = DMatrix::<Dd>::zeros(n, n);
    for i in 0..n {
        cancel::every(10 * n * n, i);
        for j in 0..=i {
            let mut inner: Dd = dot(&v[i * side..(i + 1) * side], &v[j * side..(j + 1) * side]);
            if i == j {
                inner -= 1.0;
            }
            defect_dd[(i, j)] = inner;
            defect_dd[(j, i)] = inner;
            defect[(i, j)] = inner.hi;
            defect[(j, i)] = inner.hi;
        }
    }
    let second = square(&defect, 0.375);
    for j in 0..n {
        cancel::every(20 * n * n, j);
        for k in 0..n {
            let factor = defect_dd[(k, j)] * -0.5 + second[(k, j)];
            axpy(factor, &v[k * side..(k + 1) * side], &mut result[j * side..(j + 1) * side]);
        }
    }
    result
}

/// A square matrix times itself, times `factor`, some columns at a time: a large product takes long
/// enough to be asked in between.
fn square(matrix: &DMatrix<f64>, factor: f64) -> DMatrix<f64> {
    /// Multiplications between two checkpoints: about a millisecond.
    const STRETCH: usize = 4_000_000;
    /// Fewer columns would be multiplied one by one.
    const LEAST: usize = 8;
    let n = matrix.ncols();
    let width = (STRETCH / (n * n).max(1)).max(LEAST);
    let mut result = DMatrix::zeros(n, n);
    for first in (0..n).step_by(width) {
        cancel::checkpoint();
        let width = width.min(n - first);
        result.columns_mut(first, width).gemm(factor, matrix, &matrix.columns(first, width), 0.0);
    }
    result
}

fn identity(n: usize) -> Vec<Ddx4> {
    lanes_of(&DMatrix::<Dd>::identity(n, n), |x| x)
}

/// The columns of a matrix as lanes, each column padded to whole lanes.
fn lanes_of<T: nalgebra::Scalar + Copy>(matrix: &DMatrix<T>, map: impl Fn(T) -> Dd) -> Vec<Ddx4> {
    let stride = lanes_for(matrix.nrows());
    let mut lanes = vec![Ddx4::ZERO; stride * matrix.ncols()];
    for (j, column) in matrix.column_iter().enumerate() {
        write::<Dd>(&mut lanes[j * stride..(j + 1) * stride], column.iter().map(|&x| map(x)));
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel::{Cancelled, Handle};

    #[test]
    fn a_product_in_parts_is_the_product() {
        for n in [0, 1, 7, 9, 700] {
            let matrix = DMatrix::from_fn(n, n, |i, j| ((3 * i + 7 * j) as f64).sin());
            let difference = (square(&matrix, 0.375) - &matrix * &matrix * 0.375).amax();
            assert!(difference < 1e-11, "{n}: {difference:e}");
        }
    }

    #[test]
    fn a_large_product_can_be_given_up() {
        // 490,000 entries: eight columns of the product between two checkpoints
        let matrix = DMatrix::from_element(700, 700, 0.5);
        let within = |checkpoints| Handle::with_checkpoints(checkpoints).run(|| square(&matrix, 1.0)[(0, 0)]);
        assert_eq!(within(40), Err(Cancelled));
        assert_eq!(within(90), Ok(175.0));
    }
}
