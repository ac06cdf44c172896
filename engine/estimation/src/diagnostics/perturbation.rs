//! Bounds on the change of the coefficients by uncertain nodes (Section 4 of the paper, Eqs.
//! 16–23).
//!
//! Two bounds on `‖δA‖/‖A‖` in the scaled columns, with `ε_X = ‖δX‖/‖X‖` and `ε_Y = ‖δY‖/‖Y‖`:
//! * *square*: Ineq. 22 for square nonsingular X, its silent assumption ‖X+δX‖ ≥ ‖X‖ removed:
//!   `κ(ε_X + ε_Y)/(1 − κ ε_X)`; it does not exist once κ ε_X ≥ 1;
//! * *first order*: the one that holds for least squares, with the residual term (Wedin):
//!   `κ(ε_X + ε_Y‖Y‖/(‖X‖‖A‖)) + κ² ε_X ‖R‖/(‖X‖‖A‖)`.

use crate::{
    result::{PerturbationBounds, PerturbationReport},
    spec::NodeUncertainty,
};

/// Quantities of one estimate from which the bounds are computed.
pub(crate) struct Estimate {
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
pub(crate) fn report(
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
