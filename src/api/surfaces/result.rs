//! A surface that was built, with what is to be said of it.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    curves::near_result::{BandedFitBody, CoordinateFitBody},
    json::writer::whole,
    problem::Problem,
    shapes::places::out_of_range,
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::spec::Domain,
    geometry::{
        contract,
        surface::{
            Border, Surface, SurfaceShape,
            construct::Built,
            continuity::{ContinuityClass, ContinuityTolerance, Joint, Worst},
            triangle::DegenerateBorder,
        },
    },
    numerics::cancel::Asking,
};

/// A surface, everything needed to build it again, and a report.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BuiltSurface)]
pub struct BuiltSurfaceBody<'a> {
    pub surface: contract::Surface,
    pub domain: Domain,
    /// For nodes on a grid: the parameters of its rows and columns.
    pub parameters: Option<NodeParametersBody>,
    /// For least squares with a whole grid: number of nodes.
    pub count: Option<usize>,
    /// Nodes minus control points.
    pub degrees_of_freedom: Option<usize>,
    /// Sum of squared residuals, over all coordinates.
    pub rss: Option<f64>,
    /// √(rss/count).
    pub rms: Option<f64>,
    /// √(rss/degrees of freedom/coordinates), the noise of a coordinate; absent where nothing is
    /// left.
    pub sigma: Option<f64>,
    /// For a mesh: the largest gap between crossing curves, and its place.
    pub gap: Option<Worst>,
    /// For meshes, borders and patches with cubic borders: the largest distance from the curves,
    /// and its place.
    pub deviation: Option<Worst>,
    /// For several patches: continuity across their common borders.
    pub continuity: Option<ContinuityBody>,
    /// Borders that are points: there the surface has three sides.
    pub degenerate_borders: Option<Vec<DegenerateBorderBody>>,
    /// For least squares with up to some hundred coefficients: the fit, as returned by `POST
    /// /v1/fits`.
    pub fits: Option<Vec<CoordinateFitBody<'a>>>,
    /// For least squares with more coefficients: the fit.
    pub banded_fit: Option<BandedFitBody>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// Parameters of a grid's rows and columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = NodeParameters)]
pub struct NodeParametersBody {
    /// One for each row.
    pub u: Vec<f64>,
    /// One for each column.
    pub v: Vec<f64>,
}

/// Continuity across common borders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Continuity)]
pub struct ContinuityBody {
    /// The worst class of all joints.
    pub class: ContinuityClass,
    /// Each line along which two patches meet.
    pub joints: Vec<JointBody>,
}

/// One line between two patches.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Joint)]
pub struct JointBody {
    /// Which parameter is constant on the line.
    pub constant: AxisName,
    /// Value of the coordinate there.
    pub at: f64,
    /// The range of the other one.
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub along: [f64; 2],
    pub class: ContinuityClass,
    /// Distance of the two sides.
    pub gap: Worst,
    /// Angle between the two normals, in degrees; absent where a normal does not exist.
    pub normal_angle_deg: Option<Worst>,
    /// Jump of S_u or S_v.
    pub first_derivative: Worst,
    /// Jump of S_uu, S_uv or S_vv.
    pub second_derivative: Worst,
    /// Jump of a principal curvature; absent where it does not exist.
    pub curvature: Option<Worst>,
}

/// One of the two parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SurfaceAxis)]
pub enum AxisName {
    U,
    V,
}

/// A border that is a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DegenerateBorder)]
pub struct DegenerateBorderBody {
    pub border: Border,
    /// The point.
    pub point: Vec<f64>,
}

/// Jumps that rounding may leave, against the size of what jumps.
const ROUNDING: f64 = 1e-9;
/// Angles of normals that rounding may leave, in radians.
const ANGLE: f64 = 1e-7;

/// The answer of a surface that was built of `nodes` nodes; `tolerance` is the one its curves meet
/// under.
pub fn built(built: &Built, nodes: Option<usize>, tolerance: Option<f64>) -> Result<Vec<u8>, Problem> {
    let Built { shape, parameters, residual_sum_of_squares, gap, deviation, joints, degenerate } = built;
    let mut body = BuiltSurfaceBody {
        parameters: parameters.clone().map(|[u, v]| NodeParametersBody { u, v }),
        gap: *gap,
        deviation: *deviation,
        degenerate_borders: (!degenerate.is_empty()).then(|| degenerate.iter().map(Into::into).collect()),
        ..BuiltSurfaceBody::new(shape, tolerance)
    };
    if let (Some(rss), Some(count), SurfaceShape::BSpline(surface)) = (residual_sum_of_squares, nodes, shape) {
        let left = count.saturating_sub(surface.control_points().len());
        let numbers = (left * shape.dimension().count()) as f64;
        (body.count, body.degrees_of_freedom, body.rss) = (Some(count), Some(left), Some(*rss));
        body.rms = Some((rss / count as f64).sqrt());
        body.sigma = (left > 0).then(|| (rss / numbers).sqrt());
    }
    if matches!(shape, SurfaceShape::Patchwork(_)) {
        let tolerance = tolerances(shape, tolerance);
        body.continuity = Some(ContinuityBody {
            class: joints.iter().map(|joint| joint.class(&tolerance)).min().unwrap_or(ContinuityClass::C2),
            joints: joints.iter().map(|joint| JointBody::new(joint, &tolerance)).collect(),
        });
    }
    whole(&body).map_err(|_| out_of_range("/method"))
}

impl BuiltSurfaceBody<'_> {
    /// Creates the answer with nothing but the surface, whose curves meet within `tolerance`.
    pub fn new(shape: &SurfaceShape, tolerance: Option<f64>) -> Self {
        let [u, v] = shape.domain();
        BuiltSurfaceBody {
            surface: contract::Surface::new(shape, tolerance),
            domain: Domain { u: Some(u), v: Some(v) },
            parameters: None,
            count: None,
            degrees_of_freedom: None,
            rss: None,
            rms: None,
            sigma: None,
            gap: None,
            deviation: None,
            continuity: None,
            degenerate_borders: None,
            fits: None,
            banded_fit: None,
            warnings: Vec::new(),
        }
    }
}

impl From<&DegenerateBorder> for DegenerateBorderBody {
    fn from(DegenerateBorder { border, point, extent: _ }: &DegenerateBorder) -> Self {
        DegenerateBorderBody { border: *border, point: point.as_slice().to_vec() }
    }
}

impl JointBody {
    fn new(joint: &Joint, tolerance: &ContinuityTolerance) -> Self {
        let Joint { axis, at, along, gap, normal_angle, first_derivative, second_derivative, curvature } = joint;
        JointBody {
            constant: [AxisName::U, AxisName::V][*axis],
            at: *at,
            along: *along,
            class: joint.class(tolerance),
            gap: *gap,
            normal_angle_deg: normal_angle.map(|found| Worst { value: found.value.to_degrees(), at: found.at }),
            first_derivative: *first_derivative,
            second_derivative: *second_derivative,
            curvature: *curvature,
        }
    }
}

/// Returns the tolerances of continuity: curves may leave gaps as large as their tolerance,
/// derivatives may jump by rounding errors.
fn tolerances(shape: &SurfaceShape, tolerance: Option<f64>) -> ContinuityTolerance {
    let [us, vs] = shape.breaks();
    let jets = us.iter().flat_map(|u| vs.iter().map(move |v| shape.jet(*u, *v)));
    let (mut value, mut first, mut second) = (0.0f64, 0.0f64, 0.0f64);
    for jet in jets.into_iter().asking(200) {
        value = value.max(jet.value.amax());
        first = first.max(jet.u.amax()).max(jet.v.amax());
        second = second.max(jet.uu.amax()).max(jet.uv.amax()).max(jet.vv.amax());
    }
    ContinuityTolerance {
        gap: tolerance.unwrap_or(0.0).max(ROUNDING * value),
        angle: ANGLE,
        first: ROUNDING * first,
        second: 1e3 * ROUNDING * second.max(first),
    }
}
