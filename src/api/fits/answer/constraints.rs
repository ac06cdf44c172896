//! What constraints on the shape came to, as it is answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{ActivePlace, ConstraintReport, ConstraintsReport},
    spec::{ConstraintKind, Domain, FilterAxis, Include},
};

answer! {
    /// Proof that the fitted function meets the constraints, and that no function of the model that
    /// meets them is much better. It applies to the fitted function (`curve`, `surface`,
    /// `predictions`); rounded coefficients of raw powers meet the constraints to
    /// `numerics.correct_digits`.
    #[schema(as = ConstraintsResult)]
    pub struct ConstraintsResultBody from ConstraintsReport {
        constraints, rss, rss_bound, stationarity, rounds,
    } {
        /// In the order of the request.
        each: Vec<ConstraintResultBody> = constraints,
        /// Σ w r² of the constrained estimate; `residuals.least_squares_rss` is that of the best
        /// without constraints.
        rss: f64 = rss,
        /// No function of the model that meets the constraints has a Σ w r² below this (the value
        /// of the dual problem).
        rss_bound: f64 = rss_bound,
        /// Length of the gradient of the Lagrangian relative to that of the projected heights: 0 at
        /// the exact solution.
        stationarity: f64 = stationarity,
        /// Number of rounds that searched for violated constraints; 0 where least squares meets all
        /// of them.
        rounds: usize = rounds,
    }
}

answer! {
    /// Result of one constraint.
    #[schema(as = ConstraintResult)]
    pub struct ConstraintResultBody from ConstraintReport {
        kind, along, domain, least_value, least_squares_least_value, active,
    } {
        kind: ConstraintKind = kind,
        along: FilterAxis = along,
        domain: Domain = domain,
        /// The derivative (its negative for `decreasing` and `concave`) is nowhere in `domain`
        /// below this number, which is not below 0: proved by Bernstein coefficients, over all
        /// places. In the unit of the heights over that of the axis, squared for bends.
        least_value: f64 = least_value,
        /// The same of plain least squares; below 0 where the constraint had something to do.
        least_squares_least_value: f64 = least_squares_least_value,
        /// Places where the constraint is active.
        active: Vec<ActivePlaceBody> = active,
    }
}

answer! {
    /// A place where the constraint is active: without it the derivative would be below 0.
    #[schema(as = ActivePlace)]
    pub struct ActivePlaceBody from ActivePlace { u, v, multiplier } {
        /// u, or x of a curve.
        u: f64 = u,
        /// v of a surface.
        v?: f64 = v,
        /// Decrease of Σ w r² per unit by which the derivative may fall below 0 here (twice the
        /// Lagrange multiplier of half the sum).
        multiplier: f64 = multiplier,
    }
}

impl WriteAs<ConstraintKind> for ConstraintKind {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        object.string(name, self.name());
    }
}

impl WriteAs<FilterAxis> for FilterAxis {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        let axis = match self {
            FilterAxis::U => "u",
            FilterAxis::V => "v",
        };
        object.string(name, axis);
    }
}
