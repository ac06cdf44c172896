//! A curve that was built, with what is to be said of it.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::near_result::{CoordinateFitBody, KnotInsertionBody, SmoothingBody};
use crate::api::{json::writer::whole, problem::Problem, shapes::places::out_of_range, warning::WarningBody};
use flankfit_engine::{
    geometry::curve::{Absence, Constructed, Curve, CurveShape, Stability, overshoot::Overshoot},
    words::rounded,
};

/// A curve, everything needed to build it again, and its stability.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BuiltCurve)]
pub struct BuiltCurveBody<'a> {
    pub curve: CurveShape,
    /// Range of the parameter: of x for a graph.
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub domain: [f64; 2],
    /// For points of plane or space: the parameter of each.
    pub parameters: Option<Vec<f64>>,
    /// For methods that pass through all points.
    pub stability: Option<StabilityBody>,
    /// For least squares: the fit of each coordinate, as `POST /v1/fits` returns it.
    pub fits: Option<Vec<CoordinateFitBody<'a>>>,
    /// For least squares with a `tolerance`: how knots were inserted.
    pub knot_insertion: Option<KnotInsertionBody>,
    /// For a smoothing spline.
    pub smoothing: Option<SmoothingBody>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// Stability of a curve through points: measures of oscillation. A result that does not exist is
/// absent, with a warning.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Stability)]
pub struct StabilityBody {
    /// Largest factor by which errors of the values grow anywhere on the curve.
    pub lebesgue_constant: Option<f64>,
    /// The parameter at which they grow most.
    pub lebesgue_at: Option<f64>,
    /// The farthest that the curve leaves the range of the two points it runs between; absent where
    /// it never does.
    pub overshoot: Option<Overshoot>,
    /// Condition number of the equations that were solved, in the 2-norm.
    pub condition: Option<f64>,
    /// The farthest that the curve misses one of its points after all rounding, in one coordinate.
    pub interpolation_error: f64,
}

/// Overshoots above this part of the range are warned of.
const NOTABLE_OVERSHOOT: f64 = 0.1;

/// Returns the answer of a curve through points; `parametric` for points of plane or space.
pub fn through(constructed: &Constructed, parametric: bool) -> Result<Vec<u8>, Problem> {
    let Constructed { shape, parameters, stability } = constructed;
    let body = BuiltCurveBody {
        parameters: parametric.then(|| parameters.clone()),
        stability: Some(stability.into()),
        warnings: warnings(stability),
        ..BuiltCurveBody::new(shape)
    };
    whole(&body).map_err(|_| out_of_range("/points"))
}

impl BuiltCurveBody<'_> {
    /// Creates the answer with nothing but the curve.
    pub fn new(shape: &CurveShape) -> Self {
        BuiltCurveBody {
            curve: shape.clone(),
            domain: shape.domain(),
            parameters: None,
            stability: None,
            fits: None,
            knot_insertion: None,
            smoothing: None,
            warnings: Vec::new(),
        }
    }
}

impl From<&Stability> for StabilityBody {
    fn from(stability: &Stability) -> Self {
        let Stability { lebesgue, overshoot, condition, interpolation_error } = stability;
        let lebesgue = lebesgue.as_ref().ok();
        StabilityBody {
            lebesgue_constant: lebesgue.map(|found| found.constant),
            lebesgue_at: lebesgue.map(|found| found.at),
            overshoot: *overshoot,
            condition: condition.as_ref().ok().copied(),
            interpolation_error: *interpolation_error,
        }
    }
}

fn warnings(stability: &Stability) -> Vec<WarningBody> {
    let mut warnings = Vec::new();
    let mut absent = |figure: &str, absence: Absence| {
        warnings.push(WarningBody::new("figure_left_out", format!("{figure}: {absence}")));
    };
    if let Err(absence) = &stability.lebesgue {
        absent("lebesgue_constant", *absence);
    }
    if let Err(absence) = &stability.condition {
        absent("condition", *absence);
    }
    if let Some(overshoot) = &stability.overshoot
        && let Some(relative) = overshoot.relative.filter(|relative| *relative > NOTABLE_OVERSHOOT)
    {
        let [before, after] = overshoot.between;
        warnings.push(WarningBody::new(
            "overshoot",
            format!(
                "between points {before} and {after} the curve leaves their range by {}, {:.0} % of the range of \
                 all points",
                rounded(overshoot.amount, 4),
                100.0 * relative
            ),
        ));
    }
    warnings
}
