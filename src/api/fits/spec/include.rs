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
    /// `representative`: the parts of a fit regularised by `spectral` that other fits use.
    Representative,
    /// `coefficients[].interval` and its kind. Every response to a fit has them: this name adds
    /// nothing and is not in the returned `spec`.
    Intervals,
    /// `regularization.predicted_mse_corrected`, found by simulation: λ* is chosen 240
    /// times anew.
    PredictedMse,
    /// `numerics.enclosure`: intervals that are proved to contain the exact least-squares results.
    Enclosure,
}

/// Returns a flag.
type Flag = fn(&mut spec::Include) -> &mut bool;

/// The flag of each name.
const FLAGS: [(IncludeName, Flag); 14] = [
    (IncludeName::Residuals, |include| &mut include.residuals),
    (IncludeName::Fitted, |include| &mut include.fitted),
    (IncludeName::Collinearity, |include| &mut include.collinearity),
    (IncludeName::LambdaCurve, |include| &mut include.lambda_curve),
    (IncludeName::MatrixB, |include| &mut include.matrix_b),
    (IncludeName::RidgeTrace, |include| &mut include.ridge_trace),
    (IncludeName::RobustWeights, |include| &mut include.robust_weights),
    (IncludeName::Peaks, |include| &mut include.peaks),
    (IncludeName::Covariance, |include| &mut include.covariance),
    (IncludeName::Influence, |include| &mut include.influence),
    (IncludeName::Shape, |include| &mut include.shape),
    (IncludeName::Representative, |include| &mut include.representative),
    (IncludeName::PredictedMse, |include| &mut include.predicted_mse),
    (IncludeName::Enclosure, |include| &mut include.enclosure),
];

/// Returns the names of the requested parts.
pub fn named(mut include: spec::Include) -> Option<Vec<IncludeName>> {
    let names: Vec<_> = FLAGS.iter().filter(|(_, flag)| *flag(&mut include)).map(|(name, _)| *name).collect();
    (!names.is_empty()).then_some(names)
}

/// Returns the requested parts.
pub fn include(names: &[IncludeName]) -> spec::Include {
    let mut include = spec::Include::default();
    for (_, flag) in FLAGS.iter().filter(|(name, _)| names.contains(name)) {
        *flag(&mut include) = true;
    }
    include
}

/// Returns the union of both.
pub fn both(mut a: spec::Include, mut b: spec::Include) -> spec::Include {
    for (_, flag) in FLAGS {
        *flag(&mut a) |= *flag(&mut b);
    }
    a
}
