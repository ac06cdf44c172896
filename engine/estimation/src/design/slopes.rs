//! Derivatives of the columns with respect to the abscissae of the nodes.

use super::measurement_matrix::{Basis, Design};
use crate::data::Sample;
use flankfit_numerics::cancel::Asking;

/// `Σ w ((∂x/∂u)² + (∂x/∂v)²)` over the nodes, by column.
pub(crate) fn slopes(design: &Design, sample: &Sample) -> Vec<f64> {
    let n = design.size();
    let mut sums = vec![0.0; n];
    match &design.basis {
        Basis::Columns { .. } => {
            let weight: f64 = (0..sample.count()).map(|k| sample.w(k)).sum();
            sums.fill(weight);
        }
        Basis::Product { u, v } => {
            let (mut fu, mut du) = (vec![0.0; u.size()], vec![0.0; u.size()]);
            let (mut fv, mut dv) = (vec![0.0; v.size()], vec![0.0; v.size()]);
            for k in (0..sample.count()).asking(1000) {
                let (x, y) = sample.place(k);
                u.caller_row(x, &mut fu, &mut du);
                v.caller_row(y, &mut fv, &mut dv);
                add_slopes(design, sample.w(k), [&fu, &du], [&fv, &dv], &mut sums);
            }
        }
    }
    sums
}

/// Adds `weight ((∂x/∂u)² + (∂x/∂v)²)` of every column; `u` and `v` hold values and slopes of the
/// caller's functions.
pub(crate) fn add_slopes(design: &Design, weight: f64, u: [&[f64]; 2], v: [&[f64]; 2], sums: &mut [f64]) {
    if let Some(net) = &design.rational {
        let weights = net.weights();
        net.slopes(u, v, |column, along_u, along_v| {
            sums[column] += weight * weights[column].powi(2) * (along_u * along_u + along_v * along_v);
        });
        return;
    }
    for (sum, &(i, j)) in sums.iter_mut().zip(&design.terms) {
        *sum += weight * ((u[1][i] * v[0][j]).powi(2) + (u[0][i] * v[1][j]).powi(2));
    }
}
