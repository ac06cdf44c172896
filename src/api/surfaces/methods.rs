//! Methods of surfaces.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{curves::methods::NoSettings, faults::Faults};
use flankfit_engine::{
    estimation::spec::{Degree, Domain, Spans},
    geometry::{
        contract::{Borders, Net, Point},
        curve::CurveShape,
        space::Vector,
        surface::{construct::Method, coons::Twists, least_squares::AxisKnots},
    },
    numerics::{check, tagged},
};

/// Method of a surface. `coons_bilinear`, `coons_bicubic` and `gregory` fill `boundaries` or every
/// cell of `mesh`, `bezier` every cell of `mesh`; `b_spline` passes through the nodes of `grid` or
/// `xyz`, `b_spline_least_squares` near these or near scattered `nodes`; `bezier`, `b_spline`,
/// `nurbs` and `gregory` take `control_points`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum SurfaceMethod {
    /// Bilinearly blended Coons patches: the curves are kept, with edges along them.
    CoonsBilinear(NoSettings),
    /// Bicubically blended Coons patches: C¹ across the lines of a mesh where the curves are.
    CoonsBicubic(CoonsBicubicSurfaceMethod),
    /// Gregory patches: continuous tangent planes across the lines of a mesh for any twists;
    /// borders become cubics. With `control_points` and `inner_points`: the patch itself.
    Gregory(GregorySurfaceMethod),
    /// Bicubic Bézier patches that fill a mesh, or with `control_points` the patch itself.
    Bezier(BezierSurfaceMethod),
    /// The B-spline surface through all nodes, or with `control_points` the surface itself.
    BSpline(BSplineSurfaceMethod),
    /// The least-squares B-spline surface. Exactly one of `knots`, `spans` and `placed_spans` sets
    /// the knots.
    BSplineLeastSquares(BSplineLeastSquaresSurfaceMethod),
    /// A NURBS surface of `control_points` with weights.
    Nurbs(NurbsSurfaceMethod),
}

tagged!(SurfaceMethod as name {
    "coons_bilinear" => CoonsBilinear,
    "coons_bicubic" => CoonsBicubic,
    "gregory" => Gregory,
    "bezier" => Bezier,
    "b_spline" => BSpline,
    "b_spline_least_squares" => BSplineLeastSquares,
    "nurbs" => Nurbs,
});

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CoonsBicubicSurfaceMethod {
    /// With `boundaries`: ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are
    /// estimated.
    pub cross_derivatives: Option<Borders>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct GregorySurfaceMethod {
    /// With `boundaries`: ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are
    /// estimated.
    pub cross_derivatives: Option<Borders>,
    /// With `control_points`: 2 × 2, the inner points next to u0 and u1.
    pub inner_points: Option<Vec<Vec<Point>>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BezierSurfaceMethod {
    /// With `control_points`: one weight ≥ 0 for each, for a rational patch.
    pub weights: Option<Vec<Vec<f64>>>,
    /// With `control_points`: the domain. Default [0, 1] for both.
    pub domain: Option<Domain>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineSurfaceMethod {
    pub degree: Degree,
    /// Full knot vectors of u and v; default averages of neighbouring parameters. Needed with
    /// `control_points`.
    pub knots: Option<[Vec<f64>; 2]>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineLeastSquaresSurfaceMethod {
    pub degree: Degree,
    /// Full knot vectors of u and v.
    pub knots: Option<[Vec<f64>; 2]>,
    /// Spans of equal width.
    pub spans: Option<Spans>,
    /// For a grid: number of spans with about equal numbers of nodes.
    pub placed_spans: Option<Spans>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NurbsSurfaceMethod {
    pub degree: Degree,
    /// Full knot vectors of u and v.
    pub knots: [Vec<f64>; 2],
    /// One ≥ 0 for each control point.
    pub weights: Vec<Vec<f64>>,
}

/// The method of a request, and what belongs to its control points and boundaries.
pub struct Requested {
    /// The value of `type`.
    pub name: &'static str,
    pub method: Method,
    /// Derivatives across borders.
    pub cross: [Option<CurveShape>; 4],
    /// Weights of control points.
    pub weights: Option<Vec<Vec<f64>>>,
    pub inner: Option<[[Vector; 2]; 2]>,
    pub domain: Option<[[f64; 2]; 2]>,
}

impl Requested {
    pub fn is_near(&self) -> bool {
        matches!(self.method, Method::BSplineLeastSquares { .. })
    }
}

impl SurfaceMethod {
    /// Returns the method, or adds what is wrong with it.
    pub fn requested(self, faults: &mut Faults) -> Option<Requested> {
        let name = self.name();
        let of = |method| {
            let cross = Default::default();
            Requested { name, method, cross, weights: None, inner: None, domain: None }
        };
        let curves = |cross: Option<Borders>| cross.unwrap_or_default().curves();
        Some(match self {
            SurfaceMethod::CoonsBilinear(_) => of(Method::CoonsBilinear),
            SurfaceMethod::CoonsBicubic(method) => {
                let cross = curves(method.cross_derivatives);
                Requested { cross, ..of(Method::CoonsBicubic { twists: Twists::default() }) }
            }
            SurfaceMethod::Gregory(method) => {
                let inner = match &method.inner_points {
                    Some(rows) => Some(inner(rows, faults)?),
                    None => None,
                };
                Requested { cross: curves(method.cross_derivatives), inner, ..of(Method::Gregory) }
            }
            SurfaceMethod::Bezier(BezierSurfaceMethod { weights, domain }) => {
                let domain = domain.map(|domain| [domain.u, domain.v].map(|range| range.unwrap_or([0.0, 1.0])));
                Requested { weights, domain, ..of(Method::Bezier) }
            }
            SurfaceMethod::BSpline(BSplineSurfaceMethod { degree, knots }) => {
                let knots = knots.map_or([None, None], |knots| knots.map(Some));
                of(Method::BSpline { degrees: degree.each(), knots })
            }
            SurfaceMethod::BSplineLeastSquares(method) => {
                let knots = match (method.knots, method.spans, method.placed_spans) {
                    (Some(knots), None, None) => knots.map(AxisKnots::Given),
                    (None, Some(spans), None) => spans.each().map(AxisKnots::Uniform),
                    (None, None, Some(spans)) => spans.each().map(AxisKnots::Spans),
                    (knots, spans, placed) => {
                        let any = knots.is_some() || spans.is_some() || placed.is_some();
                        let number = if any { "only one" } else { "one" };
                        faults.push("/method", format!("give {number} of `knots`, `spans` and `placed_spans`"));
                        return None;
                    }
                };
                of(Method::BSplineLeastSquares { degrees: method.degree.each(), knots })
            }
            SurfaceMethod::Nurbs(NurbsSurfaceMethod { degree, knots, weights }) => {
                let method = Method::Nurbs { degrees: degree.each(), knots: knots.map(Some) };
                Requested { weights: Some(weights), ..of(method) }
            }
        })
    }
}

fn inner(rows: &[Vec<Point>], faults: &mut Faults) -> Option<[[Vector; 2]; 2]> {
    let net = net(rows, "/method/inner_points", faults)?;
    if (net.rows, net.columns) != (2, 2) {
        let detail = format!("{} × {} points, where 2 × 2 are needed", net.rows, net.columns);
        faults.push("/method/inner_points", detail);
        return None;
    }
    Some(std::array::from_fn(|i| std::array::from_fn(|j| net.values[2 * i + j])))
}

/// Returns the net of rows of points at a pointer, or adds what is wrong with them.
pub fn net(rows: &[Vec<Point>], at: &str, faults: &mut Faults) -> Option<Net> {
    let mut found = check::Faults::default();
    let net = Net::new(rows, "", &mut found);
    faults.append(Faults::of_engine(at, &found));
    net
}
