//! The matrix B in the caller's columns.

use nalgebra::DMatrix;

use crate::{data::Sample, design::Design, factor::Factor};
use flankfit_numerics::{
    Dd,
    cancel::{self, Asking},
    triangular,
};

/// Rows of B in the caller's columns: `√w W R⁻¹ (Σ cᵢ X̃Vᵢ Vᵢᵀ) S`, whose product with the caller's
/// A is what Eq. 29 adds.
pub(crate) fn matrix_b(
    design: &Design,
    sample: &Sample,
    factor: &Factor,
    image: &DMatrix<f64>,
    v: &DMatrix<f64>,
    c: &[f64],
    scale: &[f64],
) -> Vec<Vec<f64>> {
    let n = design.size();
    // middle = R⁻¹ image diag(c) Vᵀ S, so that a row of B is √w (row of W) · middle columns of the
    // middle matrix cancel down to σ₁ in the products: both are formed in double-double
    let mut middle = DMatrix::from_element(n, n, Dd::ZERO);
    for (i, &ci) in c.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        let mut direction: Vec<Dd> = image.column(i).iter().map(|&x| Dd::from(x)).collect();
        triangular::solve_upper(&factor.r, &mut direction);
        cancel::checkpoint();
        for j in (0..n).asking(10 * n) {
            let factor = Dd::product(ci, v[(j, i)]) * scale[j];
            for k in 0..n {
                middle[(k, j)] += direction[k] * factor;
            }
        }
    }
    let mut row = crate::design::Row::<Dd>::new(design);
    (0..sample.count())
        .map(|k| {
            cancel::checkpoint();
            row.at(design, sample, k);
            let root = sample.w(k).sqrt();
            (0..n)
                .asking(10 * n)
                .map(|j| {
                    let terms = row.index.iter().zip(&row.values);
                    root * terms.fold(Dd::ZERO, |sum, (&s, &x)| sum + x * middle[(s, j)]).to_f64()
                })
                .collect()
        })
        .collect()
}

/// `X̃Vᵢ`, node by node (Eq. 37).
pub(crate) fn image_of_nodes(
    design: &Design,
    sample: &Sample,
    factor: &Factor,
    image: &DMatrix<f64>,
    i: usize,
) -> Vec<f64> {
    let mut direction: Vec<Dd> = image.column(i).iter().map(|&x| Dd::from(x)).collect();
    triangular::solve_upper(&factor.r, &mut direction);
    let mut row = crate::design::Row::<Dd>::new(design);
    (0..sample.count())
        .asking(10 * design.size())
        .map(|k| {
            row.at(design, sample, k);
            let terms = row.index.iter().zip(&row.values);
            sample.w(k).sqrt() * terms.fold(Dd::ZERO, |sum, (&s, &x)| sum + x * direction[s]).to_f64()
        })
        .collect()
}
