//! Rows of the orthonormal factor Q.

use nalgebra::DMatrix;

use super::Factor;
use crate::{
    estimation::{
        data::Sample,
        design::{Design, Row},
    },
    numerics::{Dd, Real, cancel::Asking, triangular},
};

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
        rows::<f64>(design, sample, &factor.r.map(|x| x.to_f64()))
    } else {
        rows::<Dd>(design, sample, &factor.r)
    }
}

fn rows<T: Real>(design: &Design, sample: &Sample, r: &DMatrix<T>) -> Vec<f64> {
    let (m, n) = (sample.count(), design.size());
    let mut out = Vec::with_capacity(m * n);
    let mut row = Row::<T>::new(design);
    let mut full = vec![T::of(0.0); n];
    for k in (0..m).asking(2 * n * n) {
        row.at(design, sample, k);
        full.iter_mut().for_each(|x| *x = T::of(0.0));
        let root = sample.w(k).sqrt();
        for (&j, &x) in row.index.iter().zip(&row.values) {
            full[j] = x.mul_f64(root);
        }
        triangular::solve_upper_transposed(r, &mut full);
        out.extend(full.iter().map(|x| x.to_f64()));
    }
    out
}
