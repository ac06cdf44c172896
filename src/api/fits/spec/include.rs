//! Optional parts of an answer.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::estimation::spec;

/// Optional parts of the result, which grow with the nodes or with the square of the coefficients.
/// A repeated name counts once; one that does not apply (`ridge_trace` without ridge) adds at most
/// a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FitInclude)]
pub enum IncludeName {
    /// `residuals.values`, and `residuals.node_indices` where some node was left out.
    Residuals,
    /// `residuals.fitted`: the fitted function at the nodes, `residuals.heights` where filters
    /// changed what was fitted, and `residuals.node_indices` where some node was left out.
    Fitted,
    /// `collinearity.correlation`, `collinearity.variance_proportions`, the `weights` of near
    /// dependencies, and `estimable`.
    Collinearity,
    /// Condition, bias and error along λ*.
    LambdaCurve,
    /// The matrix B, and `matrix_b_factors`.
    MatrixB,
    /// The coefficients along k; for ridge.
    RidgeTrace,
    /// `robust.weights` and `robust.rejected`.
    RobustWeights,
    /// `node_indices` of each Hampel filter: the nodes that it took for peaks.
    Peaks,
    /// `covariance`: the covariance matrices of the coefficients, of which a fit has 600 at most.
    Covariance,
    /// `influence`: leverages and deletion figures, node by node.
    Influence,
    /// `curve` or `surface` of a polynomial: the fitted function as a B-spline (those of B-splines
    /// are always answered).
    Shape,
    /// `representative`: what of a fit regularised by `spectral` is used for others.
    Representative,
    /// `coefficients[].interval` and what belongs to it. They are in every answer to a fit, so this
    /// name adds nothing and does not stand in the answered `spec`.
    Intervals,
    /// `regularization.predicted_mse_corrected`, found by simulation: λ* is chosen 240
    /// times anew.
    PredictedMse,
    /// `numerics.enclosure`: intervals that are proved to contain the exact least-squares results.
    Enclosure,
}

/// The names of what is asked for.
pub fn named(include: spec::Include) -> Option<Vec<IncludeName>> {
    let names: Vec<_> = [
        (include.residuals, IncludeName::Residuals),
        (include.fitted, IncludeName::Fitted),
        (include.collinearity, IncludeName::Collinearity),
        (include.lambda_curve, IncludeName::LambdaCurve),
        (include.matrix_b, IncludeName::MatrixB),
        (include.ridge_trace, IncludeName::RidgeTrace),
        (include.robust_weights, IncludeName::RobustWeights),
        (include.peaks, IncludeName::Peaks),
        (include.covariance, IncludeName::Covariance),
        (include.influence, IncludeName::Influence),
        (include.shape, IncludeName::Shape),
        (include.representative, IncludeName::Representative),
        (include.predicted_mse, IncludeName::PredictedMse),
        (include.enclosure, IncludeName::Enclosure),
    ]
    .into_iter()
    .filter_map(|(wanted, name)| wanted.then_some(name))
    .collect();
    (!names.is_empty()).then_some(names)
}

/// Returns the requested parts.
pub fn include(names: &[IncludeName]) -> spec::Include {
    spec::Include {
        residuals: names.contains(&IncludeName::Residuals),
        fitted: names.contains(&IncludeName::Fitted),
        collinearity: names.contains(&IncludeName::Collinearity),
        lambda_curve: names.contains(&IncludeName::LambdaCurve),
        matrix_b: names.contains(&IncludeName::MatrixB),
        ridge_trace: names.contains(&IncludeName::RidgeTrace),
        robust_weights: names.contains(&IncludeName::RobustWeights),
        peaks: names.contains(&IncludeName::Peaks),
        covariance: names.contains(&IncludeName::Covariance),
        influence: names.contains(&IncludeName::Influence),
        shape: names.contains(&IncludeName::Shape),
        representative: names.contains(&IncludeName::Representative),
        predicted_mse: names.contains(&IncludeName::PredictedMse),
        enclosure: names.contains(&IncludeName::Enclosure),
    }
}

/// Returns the union of both.
pub fn both(a: spec::Include, b: spec::Include) -> spec::Include {
    spec::Include {
        residuals: a.residuals | b.residuals,
        fitted: a.fitted | b.fitted,
        collinearity: a.collinearity | b.collinearity,
        lambda_curve: a.lambda_curve | b.lambda_curve,
        matrix_b: a.matrix_b | b.matrix_b,
        ridge_trace: a.ridge_trace | b.ridge_trace,
        robust_weights: a.robust_weights | b.robust_weights,
        peaks: a.peaks | b.peaks,
        covariance: a.covariance | b.covariance,
        influence: a.influence | b.influence,
        shape: a.shape | b.shape,
        representative: a.representative | b.representative,
        predicted_mse: a.predicted_mse | b.predicted_mse,
        enclosure: a.enclosure | b.enclosure,
    }
}
