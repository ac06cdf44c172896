//! Rows of the orthonormal factor Q.

use nalgebra::DMatrix;

use super::Factor;
use crate::{
    data::Sample,
    design::{Design, Row},
};
use flankfit_numerics::{Dd, Real, cancel::Asking, matvec, triangular};

/// Condition up to which rows in double precision keep what matters.
const EASY: f64 = 1e3;

/// `qₖ = R⁻ᵀ √wₖ wₖ` of every counted node, row by row, so that `QᵀQ = I` however the columns were
/// conditioned.
pub(crate) fn orthonormal_rows(design: &Design, factor: &Factor, sample: &Sample) -> Vec<f64> {
    let n = design.size();
    let length: Vec<f64> =
        (0..n).map(|j| factor.r.column(j).iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| factor.r[(i, j)].to_f64() / length[j]);
    let inverse = triangular::inverse_upper(&unit);
    let condition = unit.norm() * inverse.norm() / n as f64;
    if condition < EASY {
        by_inverse(design, sample, &triangular::inverse_upper(&factor.r.map(|x| x.to_f64())))
    } else {
        by_solution(design, sample, &factor.r)
    }
}

/// Computes the rows by products with the inverse, which do not wait for each other as a solution
/// does.
fn by_inverse(design: &Design, sample: &Sample, inverse: &DMatrix<f64>) -> Vec<f64> {
    let n = design.size();
    let mut out = Vec::with_capacity(sample.count() * n);
    let mut q = vec![0.0; n];
    each_row(design, sample, |full: &mut [f64]| {
        matvec::transposed_times(inverse, full, &mut q);
        out.extend_from_slice(&q);
    });
    out
}

fn by_solution(design: &Design, sample: &Sample, r: &DMatrix<Dd>) -> Vec<f64> {
    let mut out = Vec::with_capacity(sample.count() * design.size());
    each_row(design, sample, |full: &mut [Dd]| {
        triangular::solve_upper_transposed(r, full);
        out.extend(full.iter().map(|x| x.to_f64()));
    });
    out
}

/// Hands on `√wₖ wₖ` of every counted node.
fn each_row<T: Real>(design: &Design, sample: &Sample, mut take: impl FnMut(&mut [T])) {
    let n = design.size();
    let mut row = Row::<T>::new(design);
    let mut full = vec![T::of(0.0); n];
    for k in (0..sample.count()).asking(2 * n * n) {
        row.at(design, sample, k);
        full.iter_mut().for_each(|x| *x = T::of(0.0));
        let root = sample.w(k).sqrt();
        for (&j, &x) in row.index.iter().zip(&row.values) {
            full[j] = x.mul_f64(root);
        }
        take(&mut full);
    }
}
