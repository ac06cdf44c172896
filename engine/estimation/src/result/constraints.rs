//! Result of constraints on the shape, with the proof that they hold.

use crate::spec::{ConstraintKind, Domain, FilterAxis};

/// Proof that the fitted function meets the constraints, and that no function of the model that
/// meets them is much better. It applies to the fitted function (`curve`, `surface`,
/// `predictions`); rounded coefficients of raw powers meet the constraints to
/// `numerics.correct_digits`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ConstraintsResult)
)]
pub struct ConstraintsReport {
    /// In the order of the request.
    #[cfg_attr(feature = "contract", serde(rename = "each"))]
    pub constraints: Vec<ConstraintReport>,
    /// Σ w r² of the constrained estimate; `residuals.least_squares_rss` is that of the best
    /// without constraints.
    pub rss: f64,
    /// No function of the model that meets the constraints has a Σ w r² below this (the value
    /// of the dual problem).
    pub rss_bound: f64,
    /// Length of the gradient of the Lagrangian relative to that of the projected heights: 0 at
    /// the exact solution.
    pub stationarity: f64,
    /// Number of rounds that searched for violated constraints; 0 where least squares meets all
    /// of them.
    pub rounds: usize,
}

/// Result of one constraint.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ConstraintResult)
)]
pub struct ConstraintReport {
    /// Property that the constraint imposes.
    pub kind: ConstraintKind,
    /// Axis of the constraint.
    pub along: FilterAxis,
    /// Part of the domain in which the constraint applies.
    pub domain: Domain,
    /// The derivative (its negative for `decreasing` and `concave`) is nowhere in `domain`
    /// below this number, which is not below 0: proved by Bernstein coefficients, over all
    /// places. In the unit of the heights over that of the axis, squared for bends.
    pub least_value: f64,
    /// The same of plain least squares; below 0 where the constraint had an effect.
    pub least_squares_least_value: f64,
    /// Places where the constraint is active.
    pub active: Vec<ActivePlace>,
}

/// A place where the constraint is active: without it the derivative would be below 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct ActivePlace {
    /// u, or x of a curve.
    pub u: f64,
    /// v of a surface.
    pub v: Option<f64>,
    /// Decrease of Σ w r² per unit by which the derivative may fall below 0 here (twice the
    /// Lagrange multiplier of half the sum).
    pub multiplier: f64,
}

impl ConstraintsReport {
    /// True if some constraint holds the function back.
    pub fn holds_back(&self) -> bool {
        self.constraints.iter().any(|one| !one.active.is_empty())
    }

    pub(crate) fn is_finite(&self) -> bool {
        let of = |one: &ConstraintReport| {
            let places = one.active.iter().flat_map(|active| [active.u, active.v.unwrap_or(0.0), active.multiplier]);
            let ranges = [one.domain.u, one.domain.v].into_iter().flatten().flatten();
            places.chain(ranges).chain([one.least_value, one.least_squares_least_value]).all(f64::is_finite)
        };
        [self.rss, self.rss_bound, self.stationarity].iter().all(|x| x.is_finite()) && self.constraints.iter().all(of)
    }
}
