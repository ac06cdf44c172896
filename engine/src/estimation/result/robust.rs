//! How a robust estimate was reached.

use crate::estimation::spec::Start;

/// How a robust estimate was reached. Lengths are in the unit of the heights (times √weight, where
/// nodes carry weights).
#[derive(Clone, Debug, PartialEq)]
pub struct RobustReport {
    /// Whether the iteration ended within its tolerance.
    pub converged: bool,
    /// Reweightings, Newton's steps, concentration steps or changes of the vertex.
    pub iterations: usize,
    /// M: the last change of residuals and scale, in scales. Lp: the last change of residuals,
    /// relative to the largest.
    pub tolerance_reached: Option<f64>,
    /// s of M-estimators and trimmed squares, MAD of Lp, τ of the others; 0 for an exact fit,
    /// `None` where too few nodes tell it.
    pub scale: Option<f64>,
    /// τ in the covariance `τ² (XᵀX)⁻¹` of the unregularised estimate.
    pub dispersion: Option<f64>,
    /// What is least: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), Σ of the h smallest r², or Jaeckel's D.
    pub objective: f64,
    /// One per counted node, in the order posted.
    pub weights: Vec<f64>,
    /// Posted nodes of weight 0.
    pub rejected: Vec<usize>,
    /// Largest dual on the vertex; at most 1 (but for rounding) proves the optimum.
    pub certificate: Option<f64>,
    /// Whether no other coefficients do as well; `None` where the estimator does not tell.
    pub unique: Option<bool>,
    /// Posted nodes that the surface passes through by construction.
    pub vertex: Option<Vec<usize>>,
    /// h of trimmed squares.
    pub subset_size: Option<usize>,
    /// Where the iteration of an M-estimator started.
    pub start: Option<Start>,
    /// Which minimum was reached.
    pub solution: LocalSolution,
    /// The estimate before regularisation, in the caller's terms.
    pub coefficients: Vec<f64>,
}

/// Which minimum was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalSolution {
    /// Of all coefficients none do better.
    Global,
    /// The solution that the iteration reaches from its start; there may be others.
    FromStart,
    /// The best of many random starts.
    BestOfMany,
}
