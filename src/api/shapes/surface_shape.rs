//! Surfaces as they are written: everything needed to build one again.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{curve_shape::CurveBody, net::Net, point::PointBody};
use crate::api::json::{request::request, tags::tags};
use flankfit_engine::estimation::spec::{Degree, Domain};
use flankfit_engine::geometry::{
    BSplineBasis,
    space::Dimension,
    surface::{BSplineSurface, Border, CoonsPatch, GregoryPatch, Surface, SurfaceShape, gregory::GregoryNet},
};

/// A surface. Values are numbers for a graph z(u, v), points [x, y, z] for a surface of space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Surface, discriminator(property_name = "type", mapping(
    ("b_spline" = "#/components/schemas/BSplineSurface"),
    ("nurbs" = "#/components/schemas/NurbsSurface"),
    ("bezier" = "#/components/schemas/BezierSurface"),
    ("coons_bilinear" = "#/components/schemas/BilinearCoonsPatch"),
    ("coons_bicubic" = "#/components/schemas/BicubicCoonsPatch"),
    ("gregory" = "#/components/schemas/GregoryPatch"),
    ("patchwork" = "#/components/schemas/Patchwork")
)))]
pub enum SurfaceBody {
    BSpline(BSplineSurfaceBody),
    Nurbs(NurbsSurfaceBody),
    Bezier(BezierSurfaceBody),
    CoonsBilinear(Box<BilinearCoonsBody>),
    CoonsBicubic(Box<BicubicCoonsBody>),
    Gregory(GregoryBody),
    Patchwork(PatchworkBody),
}

/// Σ aᵢⱼ Nᵢ(u) Nⱼ(v).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BSplineSurface)]
pub struct BSplineSurfaceBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineSurfaceTag,
    pub degree: Degree,
    /// Full knot vectors of u and of v, ascending.
    pub knots: [Vec<f64>; 2],
    /// Rows along u, within a row along v.
    pub control_points: Vec<Vec<PointBody>>,
}

/// Σ wᵢⱼ aᵢⱼ Nᵢ(u) Nⱼ(v) / Σ wᵢⱼ Nᵢ(u) Nⱼ(v).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NurbsSurface)]
pub struct NurbsSurfaceBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NurbsSurfaceTag,
    pub degree: Degree,
    /// Full knot vectors of u and of v, ascending.
    pub knots: [Vec<f64>; 2],
    /// Rows along u, within a row along v.
    pub control_points: Vec<Vec<PointBody>>,
    /// One ≥ 0 for each control point.
    pub weights: Vec<Vec<f64>>,
}

/// A tensor Bézier patch; its degrees are one less than the numbers of control points.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BezierSurface)]
pub struct BezierSurfaceBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BezierTag,
    /// Rows along u, within a row along v; 2 to 26 of either.
    pub control_points: Vec<Vec<PointBody>>,
    /// For a rational patch, one ≥ 0 for each control point.
    pub weights: Option<Vec<Vec<f64>>>,
    /// Default [0, 1] both.
    pub domain: Option<Domain>,
}

request! {
    /// The bilinearly blended patch of four boundary curves.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = BilinearCoonsPatch)]
    pub struct BilinearCoonsBody as BilinearCoonsMembers {
        #[schema(inline)]
        required kind as "type": CoonsBilinearTag,
        required boundaries: BordersBody,
        /// Largest distance between two curves at their corner, in the unit of the request. Default
        /// 1e-6 of the largest coordinate.
        #[schema(minimum = 0)]
        optional tolerance: f64,
    }
}

request! {
    /// The bicubically blended patch of four boundary curves and the derivatives across them.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = BicubicCoonsPatch)]
    pub struct BicubicCoonsBody as BicubicCoonsMembers {
        #[schema(inline)]
        required kind as "type": CoonsBicubicTag,
        required boundaries: BordersBody,
        /// ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are estimated.
        optional cross_derivatives: BordersBody,
        /// Largest distance between two curves at their corner, in the unit of the request. Default
        /// 1e-6 of the largest coordinate.
        #[schema(minimum = 0)]
        optional tolerance: f64,
    }
}

request! {
    /// Curves along the borders of a patch: `u0` and `u1` run along v at the least and the greatest
    /// u, `v0` and `v1` along u. For points in space one may be missing: the patch then has three
    /// sides.
    #[derive(Default, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = Borders)]
    pub struct BordersBody as BordersMembers {
        optional u0: CurveBody,
        optional u1: CurveBody,
        optional v0: CurveBody,
        optional v1: CurveBody,
    }
}

/// Gregory's rational bicubic patch of 20 control points.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GregoryPatch)]
pub struct GregoryBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: GregoryTag,
    /// A net of 4 × 4; of its inner four points these are the ones felt along v0 and v1.
    #[schema(min_items = 4, max_items = 4)]
    pub control_points: Vec<Vec<PointBody>>,
    /// 2 × 2: the inner points that are felt along u0 and u1.
    #[schema(min_items = 2, max_items = 2)]
    pub inner_points: Vec<Vec<PointBody>>,
    /// Default [0, 1] both.
    pub domain: Option<Domain>,
}

request! {
    /// Patches over the rectangles between lines of constant u and v; some may have three sides.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = Patchwork)]
    pub struct PatchworkBody as PatchworkMembers {
        #[schema(inline)]
        required kind as "type": PatchworkTag,
        /// Parameters of the patch borders, both ends included, ascending.
        #[schema(min_items = 2)]
        required u: Vec<f64>,
        /// Parameters of the patch borders, both ends included, ascending.
        #[schema(min_items = 2)]
        required v: Vec<f64>,
        /// A row for each interval of u, in it a patch for each interval of v. A patch cannot be a
        /// patchwork.
        #[schema(no_recursion)]
        required patches: Vec<Vec<SurfaceBody>>,
    }
}

tags! {
    PatchworkTag = Patchwork,
    BSplineSurfaceTag = BSpline,
    NurbsSurfaceTag = Nurbs,
    BezierTag = Bezier,
    CoonsBilinearTag = CoonsBilinear,
    CoonsBicubicTag = CoonsBicubic,
    GregoryTag = Gregory,
}

impl SurfaceBody {
    /// A surface as it is written. `tolerance` is the one under which corners were found to meet,
    /// where it was given.
    pub fn of(shape: &SurfaceShape, tolerance: Option<f64>) -> Self {
        match shape {
            SurfaceShape::BSpline(surface) => b_spline(surface),
            SurfaceShape::Bezier(patch) => {
                let columns = patch.degrees()[1] + 1;
                SurfaceBody::Bezier(BezierSurfaceBody {
                    kind: BezierTag::Bezier,
                    control_points: Net::written(patch.dimension(), columns, patch.control_points()),
                    weights: patch.weights().map(|weights| rows(weights, columns)),
                    domain: Some(domain(patch.domain())),
                })
            }
            SurfaceShape::Coons(patch) => coons(patch, tolerance),
            SurfaceShape::Gregory(patch) => SurfaceBody::Gregory(gregory(patch)),
            SurfaceShape::Patchwork(work) => {
                let [u, v] = work.lines().clone();
                let columns = v.len() - 1;
                let bodies: Vec<SurfaceBody> =
                    work.patches().iter().map(|patch| SurfaceBody::of(patch, tolerance)).collect();
                SurfaceBody::Patchwork(PatchworkBody {
                    kind: PatchworkTag::Patchwork,
                    u,
                    v,
                    patches: bodies.chunks(columns).map(<[_]>::to_vec).collect(),
                })
            }
        }
    }
}

fn b_spline(surface: &BSplineSurface) -> SurfaceBody {
    let [u, v] = surface.bases();
    let degree = Degree::Each(u.degree(), v.degree());
    let knots = surface.bases().each_ref().map(|basis: &BSplineBasis| basis.knots().to_vec());
    let control_points = Net::written(surface.dimension(), v.size(), surface.control_points());
    match surface.weights() {
        None => {
            SurfaceBody::BSpline(BSplineSurfaceBody { kind: BSplineSurfaceTag::BSpline, degree, knots, control_points })
        }
        Some(weights) => SurfaceBody::Nurbs(NurbsSurfaceBody {
            kind: NurbsSurfaceTag::Nurbs,
            degree,
            knots,
            control_points,
            weights: rows(weights, v.size()),
        }),
    }
}

fn coons(patch: &CoonsPatch, tolerance: Option<f64>) -> SurfaceBody {
    let missing = patch.boundaries().collapsed();
    let curves = patch.boundaries().curves();
    let border = |border: Border| (Some(border) != missing).then(|| CurveBody::from(&curves[border as usize]));
    let boundaries =
        BordersBody { u0: border(Border::U0), u1: border(Border::U1), v0: border(Border::V0), v1: border(Border::V1) };
    match patch.cross_derivatives() {
        None => SurfaceBody::CoonsBilinear(Box::new(BilinearCoonsBody {
            kind: CoonsBilinearTag::CoonsBilinear,
            boundaries,
            tolerance,
        })),
        Some(curves) => {
            let [u0, u1, v0, v1] = curves.each_ref().map(|curve| Some(CurveBody::from(curve)));
            SurfaceBody::CoonsBicubic(Box::new(BicubicCoonsBody {
                kind: CoonsBicubicTag::CoonsBicubic,
                boundaries,
                cross_derivatives: Some(BordersBody { u0, u1, v0, v1 }),
                tolerance,
            }))
        }
    }
}

fn gregory(patch: &GregoryPatch) -> GregoryBody {
    let dimension: Dimension = patch.dimension();
    let GregoryNet { net, b } = patch.points();
    GregoryBody {
        kind: GregoryTag::Gregory,
        control_points: Net::written(dimension, 4, net.as_flattened()),
        inner_points: Net::written(dimension, 2, b.as_flattened()),
        domain: Some(domain(patch.domain())),
    }
}

fn domain([u, v]: [[f64; 2]; 2]) -> Domain {
    Domain { u: Some(u), v: Some(v) }
}

fn rows(values: &[f64], columns: usize) -> Vec<Vec<f64>> {
    values.chunks(columns).map(<[f64]>::to_vec).collect()
}
