//! Results of curves and surfaces near points: fits of coordinates, inserted knots, smoothing, and
//! fits of many coefficients.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::fits::answer::FitResultBody;
use flankfit_engine::estimation::{result::Arithmetic, spec::Criterion};

/// The fit of one coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CoordinateFit)]
pub struct CoordinateFitBody<'a> {
    /// `y` of a curve's graph, `z` of a surface's; else `x`, `y` or `z`.
    pub coordinate: Cow<'static, str>,
    /// The fit, as returned by `POST /v1/fits`, without the shape.
    pub result: FitResultBody<'a>,
}

/// Report on the insertion of knots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = KnotInsertion)]
pub struct KnotInsertionBody {
    /// Reason why it ended.
    pub stop: KnotInsertionStop,
    /// The rounds, in order.
    pub steps: Vec<KnotInsertionStep>,
}

/// Reason why the insertion ended: the tolerance is met; no span that misses it has enough points
/// for another knot; the limit of knots or rounds is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum KnotInsertionStop {
    ToleranceMet,
    TooFewPoints,
    LimitReached,
}

/// One round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KnotInsertionStep {
    /// Spans between knots.
    pub spans: usize,
    /// Largest distance of a point from the curve.
    pub max_error: f64,
    /// Root mean square of the residuals after the round.
    pub rms: f64,
}

/// A smoothing spline.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Smoothing)]
pub struct SmoothingBody {
    /// The weight of ∫ f″².
    pub lambda: f64,
    /// Absent where λ or the degrees of freedom were given.
    pub criterion: Option<Criterion>,
    /// True if the criterion is met within the range of λ.
    pub reached: bool,
    /// Trace of the smoother: how many parameters the curve is worth.
    pub effective_degrees_of_freedom: f64,
    /// Points counted.
    pub count: usize,
    /// Distinct abscissae among them; points that share one are averaged by their weights.
    pub abscissae: usize,
    /// The residuals of each coordinate: one entry for a graph, two or three for points.
    pub coordinates: Vec<CoordinateResidualsBody>,
}

/// Residuals of one coordinate.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CoordinateResiduals)]
pub struct CoordinateResidualsBody {
    /// `y` of a curve's graph, `z` of a surface's; else `x`, `y` or `z`.
    pub coordinate: Cow<'static, str>,
    /// Σ w r².
    pub rss: f64,
    /// √(RSS/Σw).
    pub rms: f64,
    /// Largest amount of a residual, in the caller's unit.
    pub max_abs: f64,
    /// √(RSS/(m − effective degrees of freedom)); absent where there is nothing left.
    pub sigma: Option<f64>,
    /// For a surface of many coefficients without a penalty: standard errors of the control points,
    /// row by row.
    pub std_errors: Option<Vec<Vec<f64>>>,
    /// With `"include": ["residuals"]`: residuals of the counted nodes, in the order posted.
    pub values: Option<Vec<f64>>,
}

/// Result of a fit of many coefficients by a banded factorisation.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BandedFit)]
pub struct BandedFitBody {
    /// Nodes counted.
    pub count: usize,
    /// Count minus effective degrees of freedom.
    pub degrees_of_freedom: f64,
    /// The number of coefficients, or the trace of the smoother under a penalty.
    pub effective_degrees_of_freedom: f64,
    /// Condition number of the Fisher information matrix (with penalty) on a unit diagonal; absent
    /// where it could not be found.
    pub condition: Option<f64>,
    /// The residuals of each coordinate: one entry for a graph, two or three for points.
    pub coordinates: Vec<CoordinateResidualsBody>,
    /// For each span of u, the nodes over each span of v.
    pub nodes_per_span: Vec<Vec<usize>>,
    /// Pairs of spans without a node.
    pub empty_spans: usize,
    pub penalty: Option<PenaltyBody>,
    /// How the matrix was factored.
    pub arithmetic: Arithmetic,
    /// Corrections of the coefficients by residuals in double-double, and the size of the last one
    /// against them.
    pub corrections: usize,
    /// Size of the last correction relative to the coefficients; 0 without a correction.
    pub last_correction: f64,
}

/// The weight of a penalty.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Penalty)]
pub struct PenaltyBody {
    /// Factor λ of the penalty that is added to the sum of squares.
    pub lambda: f64,
    /// Absent where λ was given.
    pub criterion: Option<Criterion>,
    /// True if the criterion is met within the range of λ.
    pub reached: bool,
}
