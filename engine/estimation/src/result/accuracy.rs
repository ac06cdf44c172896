//! Effect of uncertain nodes and rounding on the coefficients.

/// How far uncertain nodes can move the coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationReport {
    /// Bounds for the least-squares estimate.
    pub least_squares: PerturbationBounds,
    /// Bounds for the regularised estimate.
    pub regularized: PerturbationBounds,
}

/// Bounds on the relative error of the coefficients in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationBounds {
    /// Ineq. 22, corrected; `None` where κ·ε ≥ 1.
    pub square_bound: Option<f64>,
    /// Wedin's first-order bound, with the residual term.
    pub first_order_bound: Option<f64>,
}

/// The arithmetic that the factorisation was carried out in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// IEEE double precision.
    Double,
    /// Unevaluated sums of two doubles: twice the precision.
    DoubleDouble,
}

/// What rounding leaves of the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    /// Arithmetic of the factorisation.
    pub arithmetic: Arithmetic,
    /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
    /// side.
    pub correct_digits: f64,
}
