//! Effect of uncertain nodes and rounding on the coefficients.

use super::enclosure::Enclosure;

/// Bounds on the relative error of the coefficients that the nodes' uncertainty causes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Perturbation)
)]
pub struct PerturbationReport {
    /// Bounds for the least-squares estimate.
    pub least_squares: PerturbationBounds,
    /// Bounds for the regularised estimate.
    pub regularized: PerturbationBounds,
}

/// Bounds on the relative error of the coefficients, in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct PerturbationBounds {
    /// Bound by Ineq. 22; absent where the inequality does not apply.
    pub square_bound: Option<f64>,
    /// First-order bound with the residual term.
    pub first_order_bound: Option<f64>,
}

/// Arithmetic of the decisive steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ArithmeticName)
)]
pub enum Arithmetic {
    /// IEEE double precision.
    Double,
    /// Unevaluated sums of two doubles: twice the precision.
    DoubleDouble,
}

/// Numerical accuracy of the result.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Numerics {
    /// Arithmetic of the factorisation.
    pub arithmetic: Arithmetic,
    /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
    /// side. Posted numbers count as decimals that were rounded to doubles, unless their last bits
    /// are 0 (integers, halves): what that rounding may move is no correct digit. `enclosure` takes
    /// the doubles as exact.
    pub correct_digits: f64,
    /// Proved intervals of the least-squares results; present when `enclosure` was included.
    pub enclosure: Option<Enclosure>,
}
