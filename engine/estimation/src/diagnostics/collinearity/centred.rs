//! Centred columns: variance inflation and Pearson correlation.

use nalgebra::DMatrix;

use crate::{design::Design, factor::Factor};
use flankfit_numerics::{
    Dd,
    cancel::{self, Asking},
    triangular, with_fma,
};

/// Pearson correlations of centred columns; a column that does not vary has none with any other
/// (0).
pub(super) fn correlations(centred: &DMatrix<f64>, deviation: &[f64], varies: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    let n = deviation.len();
    let rows = centred.nrows();
    let columns: Vec<&[f64]> = centred.as_slice().chunks_exact(rows).collect();
    let mut out = vec![vec![0.0; n]; n];
    for i in 0..n {
        cancel::every(n * n, i);
        out[i][i] = 1.0;
        for j in 0..i {
            if varies(i) && varies(j) {
                let value = (dot(columns[i], columns[j]) / (deviation[i] * deviation[j])).clamp(-1.0, 1.0);
                (out[i][j], out[j][i]) = (value, value);
            }
        }
    }
    out
}

/// A scalar product, four sums side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a4, a_rest), (b4, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    dot4(a4, b4) + rest
}

with_fma! {
    /// The sums of fours.
    fn dot4(x: &[[f64; 4]], y: &[[f64; 4]]) -> f64 {
        let mut sums = [0.0; 4];
        for (a, b) in x.iter().zip(y) {
            for k in 0..4 {
                sums[k] = a[k].mul_add(b[k], sums[k]);
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

/// Lengths of the columns.
pub(super) fn lengths(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.as_slice().chunks_exact(matrix.nrows()).map(|column| dot(column, column).sqrt()).collect()
}

/// Centred columns in Q's coordinates.
pub(super) struct Centred {
    pub matrix: DMatrix<f64>,
    /// If the constant lies outside the span of the columns: its coefficients on them, and its
    /// remainder.
    pub beyond: Option<(Vec<f64>, f64)>,
}

/// Centres the columns; where `lengths` are all that is wanted and nothing cancels, in doubles.
pub(super) fn centred(design: &Design, factor: &Factor, caller: &DMatrix<Dd>, weight: f64, lengths: bool) -> Centred {
    let n = caller.ncols();
    let dot = |a: &dyn Fn(usize) -> Dd, b: usize| (0..n).fold(Dd::ZERO, |sum, k| sum + a(k) * caller[(k, b)]);
    if design.constant == Some(0) && (1..n).all(|k| caller[(k, 0)] == Dd::ZERO) {
        // Q's first direction is the constant itself: centring drops the first row
        let mut matrix = caller.map(|x| x.to_f64());
        matrix.row_mut(0).fill(0.0);
        return Centred { matrix, beyond: None };
    }
    let constant: Vec<Dd> = match (design.constant, &factor.ones) {
        (Some(index), _) => (0..n).map(|k| caller[(k, index)]).collect(),
        (None, Some(ones)) => {
            let mut direction: Vec<Dd> = ones.iter().map(|&x| Dd::from(x)).collect();
            if factor.working.is_some() {
                triangular::solve_upper_transposed(&factor.r, &mut direction);
            } else {
                direction.fill(Dd::ZERO);
            }
            direction
        }
        // a full grid of B-splines: their sum is 1 everywhere
        (None, None) => {
            let sum = |k: usize| (0..n).fold(Dd::ZERO, |sum, j| sum + factor.r[(k, j)]);
            (0..n).map(sum).collect()
        }
    };
    let own = constant.iter().fold(Dd::ZERO, |sum, &x| sum + x * x).to_f64();
    let whole = if design.constant.is_some() { own } else { weight };
    let rest = whole - own;
    let outside = design.constant.is_none() && rest > 1e-10 * whole;
    let mut matrix = DMatrix::zeros(n + 1, n);
    // B-splines are far from constant
    if lengths && design.constant.is_none() {
        let constant: Vec<f64> = constant.iter().map(|x| x.to_f64()).collect();
        for j in (0..n).asking(4 * n) {
            let column = &mut matrix.as_mut_slice()[j * (n + 1)..(j + 1) * (n + 1)];
            column.iter_mut().zip(caller.column(j).iter()).for_each(|(to, x)| *to = x.to_f64());
            let mean = self::dot(&constant, &column[..n]) / whole;
            column.iter_mut().zip(&constant).for_each(|(to, x)| *to -= mean * x);
            if outside {
                column[n] = mean * rest.sqrt();
            }
        }
    } else {
        for j in (0..n).asking(20 * n) {
            let mean = dot(&|k| constant[k], j) / whole;
            for k in 0..n {
                matrix[(k, j)] = (caller[(k, j)] - mean * constant[k]).to_f64();
            }
            if outside {
                matrix[(n, j)] = mean.to_f64() * rest.sqrt();
            }
        }
    }
    let beyond = outside.then(|| {
        let mut along = constant.clone();
        triangular::solve_upper(&triangular::multiply_upper(&factor.r, &factor.change), &mut along);
        (along.iter().map(|x| x.to_f64()).collect(), rest)
    });
    Centred { matrix, beyond }
}
