//! How far uncertain nodes can move the coefficients (Section 4 of the paper, Eqs. 16–23).
//!
//! Two bounds on `‖δA‖/‖A‖` in the scaled columns, with `ε_X = ‖δX‖/‖X‖` and `ε_Y = ‖δY‖/‖Y‖`:
//! * *square*: Ineq. 22 for square nonsingular X, its silent assumption ‖X+δX‖ ≥ ‖X‖ removed:
//!   `κ(ε_X + ε_Y)/(1 − κ ε_X)`; it does not exist once κ ε_X ≥ 1;
//! * *first order*: the one that holds for least squares, with the residual term (Wedin):
//!   `κ(ε_X + ε_Y‖Y‖/(‖X‖‖A‖)) + κ² ε_X ‖R‖/(‖X‖‖A‖)`.

use super::{
    design::{Basis, Design},
    result::{PerturbationBounds, PerturbationReport},
    sample::Sample,
    scaled::ScaledColumns,
    spec::NodeUncertainty,
};
use crate::numerics::cancel::Asking;

/// What the bounds need of one estimate.
pub struct Estimate {
    /// cond(FIM) = κ².
    pub condition: Option<f64>,
    /// Largest eigenvalue, ‖X‖².
    pub largest: f64,
    /// ‖A‖ in the scaled columns.
    pub norm: f64,
}

/// `slopes`: Σ w ((∂x̃/∂u)² + (∂x̃/∂v)²) over nodes and scaled columns; `weight`: Σ w.
///
/// Bounds for least squares and for the regularised estimate (B held fixed, whose residual is that
/// of least squares).
pub fn report(
    slopes: f64,
    weight: f64,
    uncertainty: NodeUncertainty,
    heights: f64,
    rss: f64,
    [least_squares, regularized]: [Estimate; 2],
) -> PerturbationReport {
    let moved_x = uncertainty.position * slopes.sqrt();
    let moved_y = uncertainty.height * weight.sqrt();
    let bounds = |estimate: Estimate| {
        let (Some(condition), true) = (estimate.condition, estimate.norm > 0.0 && estimate.largest > 0.0) else {
            return PerturbationBounds { square_bound: None, first_order_bound: None };
        };
        let (kappa, norm) = (condition.sqrt(), estimate.largest.sqrt());
        let relative_x = moved_x / norm;
        let relative_y = if heights > 0.0 { moved_y / heights } else { 0.0 };
        let stretch = norm * estimate.norm;
        let first = kappa * (relative_x + moved_y / stretch) + kappa * kappa * relative_x * rss.sqrt() / stretch;
        let square = kappa * (relative_x + relative_y) / (1.0 - kappa * relative_x);
        PerturbationBounds {
            square_bound: (kappa * relative_x < 1.0 && square.is_finite()).then_some(square),
            first_order_bound: first.is_finite().then_some(first),
        }
    };
    PerturbationReport { least_squares: bounds(least_squares), regularized: bounds(regularized) }
}

/// The squared Frobenius norm of δX̃ for unit moves, from the sums over nodes of each column.
pub fn of_scaled(sums: &[f64], columns: &ScaledColumns) -> f64 {
    columns.kept.iter().zip(&columns.scale).map(|(&j, s)| sums[j] / (s.to_f64() * s.to_f64())).sum()
}

/// `Σ w ((∂x/∂u)² + (∂x/∂v)²)` over the nodes, by column.
pub fn slopes(design: &Design, sample: &Sample) -> Vec<f64> {
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
pub fn add_slopes(design: &Design, weight: f64, u: [&[f64]; 2], v: [&[f64]; 2], sums: &mut [f64]) {
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
