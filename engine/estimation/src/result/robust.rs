//! Report on a robust estimate.

use crate::spec::Start;

/// Report on a robust estimate. Lengths are in the unit of the heights (times √weight, where
/// nodes have weights).
///
/// With `m_estimator`, `least_trimmed_squares` and `trimmed` the spectrum, regularisation, bias and
/// collinearity are those of the matrix weighted with node weights times `weights`; with the other
/// estimators those of the matrix with node weights alone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Robust)
)]
pub struct RobustReport {
    /// True if the iteration met its own criterion.
    pub converged: bool,
    /// Reweightings (`m_estimator`, `student`), Newton's steps (`lp`), fits of subsets
    /// (`least_trimmed_squares`), changes of the vertex (the others).
    pub iterations: usize,
    /// Last change of residuals and scale, in scales (`m_estimator`), or of residuals, relative
    /// to the largest (`lp`).
    pub tolerance_reached: Option<f64>,
    /// Scale of the residuals (`m_estimator`, `least_trimmed_squares`; s, b or a of
    /// `maximum_likelihood`; MAD for `lp`), or `dispersion` (the others); 0 for an exact fit of
    /// most nodes, absent where too few nodes have a residual.
    pub scale: Option<f64>,
    /// τ: without regularisation std_error² is τ² times the diagonal of (XᵀX)⁻¹, X with the
    /// node weights. Absent where it does not exist.
    pub dispersion: Option<f64>,
    /// Minimum of the objective: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), the sum of the h smallest r²,
    /// Jaeckel's dispersion, the squares of trimmed or winsorized nodes, or −ln L.
    pub objective: f64,
    /// One per counted node, in the order posted. `m_estimator`: ψ(u)/u. `least_trimmed_squares`: 1
    /// in the sum, otherwise 0. The others: influence per unit of residual, relative to what a
    /// residual of one scale has, at most 1 (these do not enter the matrix). Present when
    /// `robust_weights` was included.
    pub weights: Option<Vec<f64>>,
    /// Number of nodes with weight 0.
    pub rejected_count: usize,
    /// Posted nodes (from 0, grids row by row) with weight 0. Present when `robust_weights` was
    /// included.
    pub rejected: Option<Vec<usize>>,
    /// Largest dual on the vertex; at most 1 (but for rounding) proves that nothing does
    /// better.
    pub certificate: Option<f64>,
    /// True if the minimum has no other coefficients; present where this is known.
    pub unique: Option<bool>,
    /// Posted nodes that determine the surface, which passes through them.
    pub vertex: Option<Vec<usize>>,
    /// h, the number of nodes in the trimmed sum.
    pub subset_size: Option<usize>,
    /// Start of the iteration.
    pub start: Option<Start>,
    /// Kind of the solution reached.
    pub solution: LocalSolution,
    /// The tuning constant that follows from a share of gross errors.
    pub minimax: Option<MinimaxReport>,
    /// The distribution of the errors (`maximum_likelihood`); absent for an exact fit.
    pub likelihood: Option<LikelihoodReport>,
    /// The estimate before regularisation, in the order of `coefficients`.
    pub coefficients: Vec<f64>,
}

/// Huber's k against a share ε of gross errors (Eq. 10).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Minimax)
)]
pub struct MinimaxReport {
    /// ε.
    pub contamination: f64,
    /// True if ε was estimated.
    pub estimated: bool,
    /// Residuals up to k scales count by their squares.
    pub k: f64,
    /// The greatest asymptotic variance that the estimator has with any symmetric gross errors,
    /// in squares of the scale; without them it is 1 at least.
    pub variance: f64,
}

/// The distribution of the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Likelihood)
)]
pub struct LikelihoodReport {
    /// ν of Student's distribution, p of the generalised normal, given or estimated; absent for
    /// Laplace's.
    pub shape: Option<f64>,
    /// Asymptotic standard error of an estimated shape; absent at an end of its range.
    pub shape_std_error: Option<f64>,
    /// ln L of the unregularised estimate, with every constant.
    pub log_likelihood: f64,
}

/// Kind of solution: no other is better (`global`); the one reached from the start (`from_start`),
/// there may be others; the best of many random starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = SolutionName)
)]
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
