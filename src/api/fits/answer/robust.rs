//! How a robust estimate was reached, as it is answered.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{fits::spec::estimator::StartName, json::writer::Object};
use flankfit_engine::estimation::result::{LocalSolution, RobustReport};

/// How a robust estimate was reached. Lengths are in the unit of the heights (times √weight, where
/// nodes carry weights).
///
/// With `m_estimator` and `least_trimmed_squares` the spectrum, regularisation, bias and
/// collinearity of the answer are those of the matrix weighted with node weights times `weights`;
/// with the other estimators those of the matrix with node weights alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Robust)]
pub struct RobustBody {
    /// Whether the iteration ended by its own criterion.
    pub converged: bool,
    /// Reweightings (`m_estimator`), Newton's steps (`lp`), fits of subsets
    /// (`least_trimmed_squares`), changes of the vertex (the others).
    pub iterations: usize,
    /// Last change of residuals and scale, in scales (`m_estimator`), or of residuals, relative to
    /// the largest (`lp`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_reached: Option<f64>,
    /// Scale of the residuals (`m_estimator`, `least_trimmed_squares`; MAD for `lp`), or
    /// `dispersion` (the others); 0 for an exact fit of most nodes, absent where too few nodes lie
    /// off the surface to tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// τ: without regularisation std_error² is τ² times the diagonal of (XᵀX)⁻¹, X with the node
    /// weights. Absent where it does not exist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dispersion: Option<f64>,
    /// What is least: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), the sum of the h smallest r², or Jaeckel's
    /// dispersion.
    pub objective: f64,
    /// One per counted node, in the order posted. `m_estimator`: ψ(u)/u. `least_trimmed_squares`: 1
    /// in the sum, 0 not. The others: influence per unit of residual, relative to what a residual
    /// of one scale has, at most 1 (these do not enter the matrix). Present when `robust_weights`
    /// was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<Vec<f64>>,
    /// How many nodes were given no weight.
    pub rejected_count: usize,
    /// Posted nodes (from 0, grids row by row) that were given no weight. Present when
    /// `robust_weights` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<Vec<usize>>,
    /// Largest dual on the vertex; at most 1 (but for rounding) proves that nothing does better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<f64>,
    /// Whether no other coefficients do as well; where this is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unique: Option<bool>,
    /// Posted nodes that determine the surface, which passes through them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<Vec<usize>>,
    /// h, the number of nodes in the trimmed sum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subset_size: Option<usize>,
    /// Where the iteration started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<StartName>,
    /// Which solution was reached.
    pub solution: SolutionName,
    /// The estimate before regularisation, in the order of `coefficients`.
    pub coefficients: Vec<f64>,
}

/// Nothing does better (`global`); the one reached from the start (`from_start`), there may be
/// others; the best of many random starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SolutionName {
    Global,
    FromStart,
    BestOfMany,
}

/// Writes the fields of [`RobustBody`].
pub(in crate::api) fn write(object: &mut Object<'_>, report: &RobustReport, by_node: bool) {
    let RobustReport {
        converged,
        iterations,
        tolerance_reached,
        scale,
        dispersion,
        objective,
        weights,
        rejected,
        certificate,
        unique,
        vertex,
        subset_size,
        start,
        solution,
        coefficients,
    } = report;
    object
        .field("converged", converged)
        .count("iterations", *iterations)
        .maybe_number("tolerance_reached", *tolerance_reached)
        .maybe_number("scale", *scale)
        .maybe_number("dispersion", *dispersion)
        .number("objective", *objective);
    if by_node {
        object.numbers("weights", weights);
    }
    object.count("rejected_count", rejected.len());
    if by_node {
        object.counts("rejected", rejected);
    }
    object.maybe_number("certificate", *certificate).maybe("unique", *unique);
    if let Some(nodes) = vertex {
        object.counts("vertex", nodes);
    }
    object
        .maybe("subset_size", *subset_size)
        .maybe("start", start.map(StartName::from))
        .field("solution", &SolutionName::from(*solution))
        .numbers("coefficients", coefficients);
}

impl From<LocalSolution> for SolutionName {
    fn from(solution: LocalSolution) -> Self {
        match solution {
            LocalSolution::Global => SolutionName::Global,
            LocalSolution::FromStart => SolutionName::FromStart,
            LocalSolution::BestOfMany => SolutionName::BestOfMany,
        }
    }
}
