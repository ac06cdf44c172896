//! Report on a robust estimate.

use crate::spec::{Distribution, Start};

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
    /// What is least: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), Σ of the h smallest r², Jaeckel's D, Σ r² of
    /// trimmed or winsorized nodes, or −ln L.
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
    /// Huber's k against a share of gross errors, where it was asked for by that.
    pub minimax: Option<MinimaxReport>,
    /// The distribution of the errors, where one was asked for.
    pub likelihood: Option<LikelihoodReport>,
    /// The estimate before regularisation, in the caller's terms.
    pub coefficients: Vec<f64>,
}

/// Huber's k against a share ε of gross errors (Eq. 10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimaxReport {
    /// ε.
    pub contamination: f64,
    /// Whether ε was estimated.
    pub estimated: bool,
    /// k.
    pub k: f64,
    /// The greatest asymptotic variance over the class of distributions, in squares of the scale.
    pub variance: f64,
}

/// The distribution of the errors, with the greatest likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LikelihoodReport {
    /// As it was asked for: with the shape, where that was given.
    pub distribution: Distribution,
    /// ν of Student's distribution, p of the generalised normal; `None` for Laplace's.
    pub shape: Option<f64>,
    /// Standard error of an estimated shape, asymptotic; `None` at an end of its range.
    pub shape_std_error: Option<f64>,
    /// ln L, with every constant.
    pub log_likelihood: f64,
}

/// Which minimum was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalSolution {
    /// No other coefficients are better.
    Global,
    /// The solution that the iteration reaches from its start; there may be others.
    FromStart,
    /// The best of many random starts.
    BestOfMany,
}

impl MinimaxReport {
    pub(crate) fn is_finite(&self) -> bool {
        [self.contamination, self.k, self.variance].iter().all(|x| x.is_finite())
    }
}

impl LikelihoodReport {
    pub(crate) fn is_finite(&self) -> bool {
        let shape = [self.shape, self.shape_std_error];
        self.log_likelihood.is_finite() && shape.iter().flatten().all(|x| x.is_finite())
    }
}
