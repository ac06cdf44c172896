//! Methods of surfaces: wire parts to methods.

use super::methods::*;
use crate::api::{
    faults::Faults,
    json::{
        members::{Member, of_object},
        tags::{read_tag, unknown_type},
        value::read_value,
    },
    shapes::{
        net::{Net, equal_rows},
        point::PointBody,
        surface_reader::borders,
        surface_shape::BordersBody,
    },
};
use flankfit_engine::geometry::{
    curve::CurveShape,
    space::Vector,
    surface::{construct::Method, coons::Twists, least_squares::AxisKnots},
};

/// The methods that there are.
const METHODS: &str = "coons_bilinear, coons_bicubic, gregory, bezier, b_spline, b_spline_least_squares and nurbs are";

/// The method of a request.
pub struct RequestedMethod {
    /// The contract's name.
    pub name: &'static str,
    pub method: Method,
    /// Derivatives across borders.
    pub cross: [Option<CurveShape>; 4],
    /// Of a net of control points.
    pub weights: Option<Vec<Vec<f64>>>,
    pub inner: Option<[[Vector; 2]; 2]>,
    pub domain: Option<[[f64; 2]; 2]>,
}

impl RequestedMethod {
    pub fn is_near(&self) -> bool {
        matches!(self.method, Method::BSplineLeastSquares { .. })
    }
}

/// Reads the method that stands at `/method`.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<RequestedMethod> {
    const AT: &str = "/method";
    let plain = |name, method| RequestedMethod {
        name,
        method,
        cross: Default::default(),
        weights: None,
        inner: None,
        domain: None,
    };
    Some(match read_tag(slice, AT, METHODS, faults)?.as_str() {
        "coons_bilinear" => {
            read_value::<CoonsBilinearMethod>(slice, AT, faults)?;
            plain("coons_bilinear", Method::CoonsBilinear)
        }
        "coons_bicubic" => {
            let members: CoonsBicubicMembers<'_> = of_object(slice, AT, faults)?;
            let method = Method::CoonsBicubic { twists: Twists::default() };
            RequestedMethod { cross: cross(&members.cross_derivatives, faults)?, ..plain("coons_bicubic", method) }
        }
        "gregory" => {
            let members: GregoryMembers<'_> = of_object(slice, AT, faults)?;
            let inner = match members.inner_points.optional(faults)? {
                Some(rows) => Some(inner(&rows, faults)?),
                None => None,
            };
            RequestedMethod {
                cross: cross(&members.cross_derivatives, faults)?,
                inner,
                ..plain("gregory", Method::Gregory)
            }
        }
        "bezier" => {
            let body: BezierMethod = read_value(slice, AT, faults)?;
            let domain = body.domain.map(|domain| [domain.u, domain.v].map(|range| range.unwrap_or([0.0, 1.0])));
            RequestedMethod { weights: body.weights, domain, ..plain("bezier", Method::Bezier) }
        }
        "b_spline" => {
            let body: BSplineSurfaceMethod = read_value(slice, AT, faults)?;
            let knots = body.knots.map_or([None, None], |knots| knots.map(Some));
            plain("b_spline", Method::BSpline { degrees: body.degree.each(), knots })
        }
        "b_spline_least_squares" => {
            let body: BSplineLeastSquaresSurfaceMethod = read_value(slice, AT, faults)?;
            let degrees = body.degree.each();
            let knots = match (body.knots, body.spans, body.placed_spans) {
                (Some(knots), None, None) => knots.map(AxisKnots::Given),
                (None, Some(spans), None) => spans.each().map(AxisKnots::Uniform),
                (None, None, Some(spans)) => spans.each().map(AxisKnots::Spans),
                (None, None, None) => {
                    faults.push(AT, "give one of `knots`, `spans` and `placed_spans`");
                    return None;
                }
                _ => {
                    faults.push(AT, "give only one of `knots`, `spans` and `placed_spans`");
                    return None;
                }
            };
            plain("b_spline_least_squares", Method::BSplineLeastSquares { degrees, knots })
        }
        "nurbs" => {
            let body: NurbsSurfaceMethod = read_value(slice, AT, faults)?;
            let method = Method::Nurbs { degrees: body.degree.each(), knots: body.knots.map(Some) };
            RequestedMethod { weights: Some(body.weights), ..plain("nurbs", method) }
        }
        other => {
            unknown_type(AT, other, METHODS, faults);
            return None;
        }
    })
}

fn cross(derivatives: &Member<'_, BordersBody>, faults: &mut Faults) -> Option<[Option<CurveShape>; 4]> {
    match derivatives.text() {
        Some(slice) => borders(slice, &derivatives.pointer(), faults),
        None => Some(Default::default()),
    }
}

fn inner(rows: &[Vec<PointBody>], faults: &mut Faults) -> Option<[[Vector; 2]; 2]> {
    const AT: &str = "/method/inner_points";
    equal_rows(rows, AT, faults)?;
    let net = Net::read(rows, AT, faults)?;
    if (net.rows, net.columns) != (2, 2) {
        faults.push(AT, format!("{} × {} points, where 2 × 2 are wanted", net.rows, net.columns));
        return None;
    }
    Some(std::array::from_fn(|i| std::array::from_fn(|j| net.values[2 * i + j])))
}
