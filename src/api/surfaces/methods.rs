//! What a surface is made of and how, as it is written.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    json::{request::request, tags::tags},
    shapes::point::PointBody,
    shapes::{
        curve_shape::CurveBody,
        surface_shape::{
            BSplineSurfaceTag, BezierTag, BordersBody, CoonsBicubicTag, CoonsBilinearTag, GregoryTag, NurbsSurfaceTag,
        },
    },
};
use flankfit_engine::estimation::spec::{Degree, Domain, Spans};

/// Method of a surface. `coons_bilinear`, `coons_bicubic` and `gregory` fill `boundaries` or every
/// cell of `mesh`, `bezier` every cell of `mesh`; `b_spline` passes through the nodes of `grid` or
/// `xyz`, `b_spline_least_squares` near these or near scattered `nodes`; `bezier`, `b_spline`,
/// `nurbs` and `gregory` take `control_points`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = SurfaceMethod, discriminator(property_name = "type", mapping(
    ("coons_bilinear" = "#/components/schemas/CoonsBilinearMethod"),
    ("coons_bicubic" = "#/components/schemas/CoonsBicubicMethod"),
    ("gregory" = "#/components/schemas/GregoryMethod"),
    ("bezier" = "#/components/schemas/BezierMethod"),
    ("b_spline" = "#/components/schemas/BSplineSurfaceMethod"),
    ("b_spline_least_squares" = "#/components/schemas/BSplineLeastSquaresSurfaceMethod"),
    ("nurbs" = "#/components/schemas/NurbsSurfaceMethod")
)))]
pub enum SurfaceMethodBody {
    CoonsBilinear(CoonsBilinearMethod),
    CoonsBicubic(CoonsBicubicMethod),
    Gregory(GregoryMethod),
    Bezier(BezierMethod),
    BSpline(BSplineSurfaceMethod),
    BSplineLeastSquares(BSplineLeastSquaresSurfaceMethod),
    Nurbs(NurbsSurfaceMethod),
}

request! {
    /// Curves along the lines of a mesh, from two families of planes u = const and v = const.
    #[derive(Deserialize)]
    #[schema(as = CurveMesh)]
    pub struct MeshBody as MeshMembers {
        /// Positions of the curves over v, ascending.
        #[schema(min_items = 2)]
        required u: Vec<f64>,
        /// Positions of the curves over u, ascending.
        #[schema(min_items = 2)]
        required v: Vec<f64>,
        /// For each u its curve over v. For points in space the first or the last may be `null`:
        /// the patches there are three-sided.
        required u_curves: Vec<Option<CurveBody>>,
        /// For each v its curve over u; `null` as above.
        required v_curves: Vec<Option<CurveBody>>,
    }
}

/// Bilinearly blended Coons patches: the curves are kept, with edges along them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CoonsBilinearMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: CoonsBilinearTag,
}

request! {
    /// Bicubically blended Coons patches: C¹ across the lines of a mesh where the curves are.
    pub struct CoonsBicubicMethod as CoonsBicubicMembers {
        #[schema(inline)]
        required kind as "type": CoonsBicubicTag,
        /// With `boundaries`: ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are
        /// estimated.
        optional cross_derivatives: BordersBody,
    }
}

request! {
    /// Gregory patches: continuous tangent planes across the lines of a mesh for any twists;
    /// borders become cubics. With `control_points` and `inner_points`: the patch itself.
    pub struct GregoryMethod as GregoryMembers {
        #[schema(inline)]
        required kind as "type": GregoryTag,
        /// With `boundaries`: ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are
        /// estimated.
        optional cross_derivatives: BordersBody,
        /// With `control_points`: 2 × 2, the inner points next to u0 and u1.
        optional inner_points: Vec<Vec<PointBody>>,
    }
}

/// Bicubic Bézier patches that fill a mesh, or with `control_points` the patch itself.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BezierMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BezierTag,
    /// With `control_points`: one weight ≥ 0 for each, for a rational patch.
    pub weights: Option<Vec<Vec<f64>>>,
    /// With `control_points`: the domain. Default [0, 1] for both.
    pub domain: Option<Domain>,
}

/// The B-spline surface through all nodes, or with `control_points` the surface itself.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineSurfaceMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineSurfaceTag,
    pub degree: Degree,
    /// Full knot vectors of u and v; default averages of neighbouring parameters. Needed with
    /// `control_points`.
    pub knots: Option<[Vec<f64>; 2]>,
}

/// The least-squares B-spline surface. Exactly one of `knots`, `spans` and `placed_spans` sets the
/// knots.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineLeastSquaresSurfaceMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineLeastSquaresSurfaceTag,
    pub degree: Degree,
    /// Full knot vectors of u and v.
    pub knots: Option<[Vec<f64>; 2]>,
    /// Spans of equal width.
    pub spans: Option<Spans>,
    /// For a grid: number of spans with about equal numbers of nodes.
    pub placed_spans: Option<Spans>,
}

/// A NURBS surface of `control_points` with weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NurbsSurfaceMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NurbsSurfaceTag,
    pub degree: Degree,
    /// Full knot vectors of u and v.
    pub knots: [Vec<f64>; 2],
    /// One ≥ 0 for each control point.
    pub weights: Vec<Vec<f64>>,
}

tags! {
    BSplineLeastSquaresSurfaceTag = BSplineLeastSquares,
}
