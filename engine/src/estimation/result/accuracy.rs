//! How uncertain nodes and rounding move the coefficients.

#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationReport {
    pub least_squares: PerturbationBounds,
    pub regularized: PerturbationBounds,
}

/// Bounds on the relative error of the coefficients in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationBounds {
    /// Ineq. 22, mended; `None` where κ·ε ≥ 1.
    pub square_bound: Option<f64>,
    /// Wedin's first-order bound, with the residual term.
    pub first_order_bound: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    Double,
    DoubleDouble,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    pub arithmetic: Arithmetic,
    /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
    /// side.
    pub correct_digits: f64,
}
