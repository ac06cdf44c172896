//! Result of constraints on the shape, with the proof that they hold.

use crate::spec::{ConstraintKind, Domain, FilterAxis};

/// What constraints came to: that they hold, and that no function of the model that meets them is
/// much better.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintsReport {
    /// In the order asked for.
    pub constraints: Vec<ConstraintReport>,
    /// Σ w r² of the constrained estimate.
    pub rss: f64,
    /// No function of the model that meets the constraints has a Σ w r² below this (the value of
    /// the dual problem).
    pub rss_bound: f64,
    /// How far the gradient of the Lagrangian is from 0, relative to the heights.
    pub stationarity: f64,
    /// Rounds in which violated places were looked for.
    pub rounds: usize,
}

/// What one constraint came to.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintReport {
    /// What the function has to do.
    pub kind: ConstraintKind,
    /// Along which axis.
    pub along: FilterAxis,
    /// Where.
    pub domain: Domain,
    /// A lower bound, not below 0, of the derivative over the domain; of its negative where it must
    /// not be positive.
    pub least_value: f64,
    /// The same of plain least squares, which may be below 0.
    pub least_squares_least_value: f64,
    /// Where the constraint holds the function back.
    pub active: Vec<ActivePlace>,
}

/// A place where a constraint holds the function back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActivePlace {
    /// u; x of a curve.
    pub u: f64,
    /// v of a surface.
    pub v: Option<f64>,
    /// By how much Σ w r² would fall for each unit by which the derivative might be below 0 there.
    pub multiplier: f64,
}

impl ConstraintsReport {
    /// Whether some constraint holds the function back.
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
