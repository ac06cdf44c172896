//! A surface that was built, with what is to be said of it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    curves::{
        near_result::{BandedFitBody, CoordinateFitBody},
        result::write_warnings,
    },
    json::writer::{Json, Object},
    problem::Problem,
    shapes::{places::beyond, surface_shape::SurfaceBody},
    warning::WarningBody,
};
use flankfit_engine::estimation::spec::Domain;
use flankfit_engine::geometry::surface::{
    Surface, SurfaceShape,
    construct::Built,
    continuity::{ContinuityClass, ContinuityTolerance, Joint, Worst},
    triangle::DegenerateBorder,
};
use flankfit_engine::numerics::cancel::Asking;

/// A surface, everything needed to build it again, and a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BuiltSurface)]
pub struct BuiltSurfaceBody {
    pub surface: SurfaceBody,
    pub domain: Domain,
    /// For nodes on a grid: the parameters of its rows and columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<NodeParametersBody>,
    /// For least squares with a whole grid: number of nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Nodes less control points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<usize>,
    /// Sum of squared residuals, over all coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rss: Option<f64>,
    /// √(rss/count).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// √(rss/degrees of freedom/coordinates), the noise of a coordinate; left out where nothing is
    /// left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// For a mesh: the largest gap between crossing curves, and its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<WorstBody>,
    /// For meshes, borders and patches with cubic borders: the largest distance from the curves,
    /// and its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<WorstBody>,
    /// For several patches: continuity across their common borders.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuity: Option<ContinuityBody>,
    /// Borders that are points: there the surface has three sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degenerate_borders: Option<Vec<DegenerateBorderBody>>,
    /// For least squares with up to some hundred coefficients: the fit as in the answer of `POST
    /// /v1/fits`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fits: Option<Vec<CoordinateFitBody>>,
    /// For least squares with more coefficients: the fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub banded_fit: Option<BandedFitBody>,
    /// What to know about the answer; empty where there is nothing to say.
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

/// The largest of some figures, and the [u, v] where it was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Worst)]
pub struct WorstBody {
    /// The largest figure.
    pub value: f64,
    /// `[u, v]`, where it was found.
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub at: [f64; 2],
}

/// Continuity across common borders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Continuity)]
pub struct ContinuityBody {
    /// The worst class of all joints.
    pub class: ContinuityName,
    /// Each line along which two patches meet.
    pub joints: Vec<JointBody>,
}

/// Continuity of two patches, from worst to best: a gap; a common line with an edge; a common
/// tangent plane; equal first derivatives; equal second derivatives, hence equal curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ContinuityClass)]
pub enum ContinuityName {
    Apart,
    C0,
    G1,
    C1,
    C2,
}

/// One line between two patches.
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
    pub class: ContinuityName,
    /// Distance of the two sides.
    pub gap: WorstBody,
    /// Angle between the two normals, in degrees; absent where a normal does not exist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_angle_deg: Option<WorstBody>,
    /// Jump of S_u or S_v.
    pub first_derivative: WorstBody,
    /// Jump of S_uu, S_uv or S_vv.
    pub second_derivative: WorstBody,
    /// Jump of a principal curvature; absent where it does not exist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<WorstBody>,
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
    pub border: BorderName,
    /// The point.
    pub point: Vec<f64>,
}

/// A border: at the least or the greatest u or v.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Border)]
pub enum BorderName {
    U0,
    U1,
    V0,
    V1,
}

/// Jumps that rounding may leave, against the size of what jumps.
const ROUNDING: f64 = 1e-9;
/// Angles of normals that rounding may leave, in radians.
const ANGLE: f64 = 1e-7;

/// The answer of a surface that was built of `nodes` nodes; `tolerance` is the one its curves meet
/// under.
pub fn built(built: &Built, nodes: Option<usize>, tolerance: Option<f64>) -> Result<Vec<u8>, Problem> {
    let Built { shape, parameters, residual_sum_of_squares, gap, deviation, joints, degenerate } = built;
    let mut json = Json::with_capacity(4096);
    let mut object = json.object();
    write_surface(&mut object, shape, tolerance);
    if let Some([u, v]) = parameters {
        object.object("parameters", |object| {
            object.numbers("u", u).numbers("v", v);
        });
    }
    if let (Some(rss), Some(count), SurfaceShape::BSpline(surface)) = (residual_sum_of_squares, nodes, shape) {
        let left = count.saturating_sub(surface.control_points().len());
        let numbers = (left * shape.dimension().count()) as f64;
        object
            .count("count", count)
            .count("degrees_of_freedom", left)
            .number("rss", *rss)
            .number("rms", (rss / count as f64).sqrt())
            .maybe_number("sigma", (left > 0).then(|| (rss / numbers).sqrt()));
    }
    for (name, worst) in [("gap", gap), ("deviation", deviation)] {
        if let Some(worst) = worst {
            write_worst(&mut object, name, worst);
        }
    }
    if matches!(shape, SurfaceShape::Patchwork(_)) {
        write_continuity(&mut object, joints, &tolerances(shape, tolerance));
    }
    if !degenerate.is_empty() {
        object.list("degenerate_borders", degenerate, |object, DegenerateBorder { border, point, extent: _ }| {
            object.string("border", border.name()).numbers("point", point.as_slice());
        });
    }
    write_warnings(&mut object, &[]);
    object.end();
    json.finish().map_err(|_| beyond("/method"))
}

/// What every surface that was built begins with.
pub fn write_surface(object: &mut Object<'_>, shape: &SurfaceShape, tolerance: Option<f64>) {
    let [u, v] = shape.domain();
    object.field("surface", &SurfaceBody::of(shape, tolerance)).object("domain", |object| {
        object.numbers("u", &u).numbers("v", &v);
    });
}

fn write_worst(object: &mut Object<'_>, name: &'static str, Worst { value, at }: &Worst) {
    object.object(name, |object| {
        object.number("value", *value).numbers("at", at);
    });
}

fn write_continuity(object: &mut Object<'_>, joints: &[Joint], tolerance: &ContinuityTolerance) {
    let worst = joints.iter().map(|joint| joint.class(tolerance)).min().unwrap_or(ContinuityClass::C2);
    object.object("continuity", |object| {
        object.string("class", class_name(worst)).list("joints", joints, |object, joint| {
            let Joint { axis, at, along, gap, normal_angle, first_derivative, second_derivative, curvature } = joint;
            object
                .string("constant", ["u", "v"][*axis])
                .number("at", *at)
                .numbers("along", along)
                .string("class", class_name(joint.class(tolerance)));
            write_worst(object, "gap", gap);
            if let Some(Worst { value, at }) = normal_angle {
                write_worst(object, "normal_angle_deg", &Worst { value: value.to_degrees(), at: *at });
            }
            write_worst(object, "first_derivative", first_derivative);
            write_worst(object, "second_derivative", second_derivative);
            if let Some(curvature) = curvature {
                write_worst(object, "curvature", curvature);
            }
        });
    });
}

fn class_name(class: ContinuityClass) -> &'static str {
    match class {
        ContinuityClass::Apart => "apart",
        ContinuityClass::C0 => "c0",
        ContinuityClass::G1 => "g1",
        ContinuityClass::C1 => "c1",
        ContinuityClass::C2 => "c2",
    }
}

/// What counts as continuous: curves may leave gaps as large as their tolerance, derivatives jump
/// as rounding lets them.
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
