//! Methods of requests: wire parts to methods.

use super::methods::*;
use crate::api::{
    faults::Faults,
    json::{
        members::of_object,
        tags::{read_tag, unknown_type},
        value::read_value,
    },
    shapes::{
        THROUGH,
        point::{self, PointBody},
    },
};
use flankfit_engine::geometry::{
    curve::{Ends, KnotChoice, Method, Points, Tangents},
    space::{Dimension, Vector},
};

/// The methods that there are.
const METHODS: &str = "lagrange, newton, hermite, cubic_hermite, cubic_spline, b_spline, b_spline_least_squares, \
    nurbs_least_squares and smoothing_spline are";

/// The ends of a cubic spline.
const ENDS: &str = "clamped, natural, second_derivative, not_a_knot and periodic are";

/// The method of a request, with its name.
pub enum RequestedMethod {
    Through { name: &'static str, method: Method },
    Near { name: &'static str, method: NearBody },
}

/// A method near points, as it stands in the request.
pub enum NearBody {
    BSpline(BSplineLeastSquaresCurveMethod),
    Nurbs(NurbsLeastSquaresCurveMethod),
    Smoothing(SmoothingSplineMethod),
}

impl RequestedMethod {
    /// Why nothing of a fit may stand beside it, where that is so.
    pub fn takes_no_fit(&self) -> Option<&'static str> {
        match self {
            RequestedMethod::Through { .. } => Some(THROUGH),
            RequestedMethod::Near { method: NearBody::Smoothing(_), .. } => Some(
                "a smoothing spline has its `parameter`, `noise_sigma` and `weight` in its method, and no other \
                 estimator",
            ),
            RequestedMethod::Near { .. } => None,
        }
    }
}

/// Reads the method that stands at `/method`, for these points.
pub fn read(slice: &[u8], points: &Points, faults: &mut Faults) -> Option<RequestedMethod> {
    const AT: &str = "/method";
    let dimension = match points {
        Points::Graph { .. } => Dimension::Graph,
        Points::Space { dimension, .. } => *dimension,
    };
    let values = Values { dimension };
    let through = |name, method| Some(RequestedMethod::Through { name, method });
    match read_tag(slice, AT, METHODS, faults)?.as_str() {
        "lagrange" => {
            read_value::<LagrangeMethod>(slice, AT, faults)?;
            through("lagrange", Method::Lagrange)
        }
        "newton" => {
            read_value::<NewtonMethod>(slice, AT, faults)?;
            through("newton", Method::Newton)
        }
        "hermite" => {
            let body: HermiteMethod = read_value(slice, AT, faults)?;
            let mut derivatives = Vec::with_capacity(body.derivatives.len());
            for (i, orders) in body.derivatives.iter().enumerate() {
                derivatives.push(values.read(orders, &format!("{AT}/derivatives/{i}"), faults)?);
            }
            through("hermite", Method::Hermite { derivatives })
        }
        "cubic_hermite" => {
            let body: CubicHermiteMethod = read_value(slice, AT, faults)?;
            let tangents = match (body.tangents, body.values) {
                (TangentsName::Given, Some(given)) => {
                    Tangents::Given(values.read(&given, &format!("{AT}/values"), faults)?)
                }
                (TangentsName::Given, None) => {
                    faults.push_missing(format!("{AT}/values"), "missing; the tangents `given` need them");
                    return None;
                }
                (_, Some(_)) => {
                    faults.push(format!("{AT}/values"), "only the tangents `given` take values");
                    return None;
                }
                (TangentsName::FiniteDifference, None) => Tangents::FiniteDifference,
                (TangentsName::CatmullRom, None) => Tangents::CatmullRom,
                (TangentsName::Parabola, None) => Tangents::Parabola,
                (TangentsName::ModifiedAkima, None) => Tangents::ModifiedAkima,
                (TangentsName::Monotone, None) => Tangents::Monotone,
                (TangentsName::Akima, None) => Tangents::Akima,
            };
            through("cubic_hermite", Method::CubicHermite(tangents))
        }
        "cubic_spline" => {
            let members: CubicSplineMembers<'_> = of_object(slice, AT, faults)?;
            let ends = members.ends.required_text(faults)?;
            through("cubic_spline", Method::CubicSpline(values.ends(ends, faults)?))
        }
        "b_spline" => {
            let body: BSplineCurveMethod = read_value(slice, AT, faults)?;
            let knots = body.knots.map_or(KnotChoice::Averaging, KnotChoice::Given);
            through("b_spline", Method::BSpline { degree: body.degree, knots })
        }
        "b_spline_least_squares" => {
            let method = NearBody::BSpline(read_value(slice, AT, faults)?);
            Some(RequestedMethod::Near { name: "b_spline_least_squares", method })
        }
        "nurbs_least_squares" => {
            let method = NearBody::Nurbs(read_value(slice, AT, faults)?);
            Some(RequestedMethod::Near { name: "nurbs_least_squares", method })
        }
        "smoothing_spline" => {
            let method = NearBody::Smoothing(read_value(slice, AT, faults)?);
            Some(RequestedMethod::Near { name: "smoothing_spline", method })
        }
        other => {
            unknown_type(AT, other, METHODS, faults);
            None
        }
    }
}

/// Values that must be of the kind of the points.
struct Values {
    dimension: Dimension,
}

impl Values {
    fn read(&self, bodies: &[PointBody], at: &str, faults: &mut Faults) -> Option<Vec<Vector>> {
        if bodies.is_empty() {
            return Some(Vec::new());
        }
        let (dimension, values) = point::read(bodies, at, faults)?;
        if dimension != self.dimension {
            faults.push(at, "they must be of the kind of the points: numbers for a graph, else as many coordinates");
            return None;
        }
        Some(values)
    }

    fn pair(&self, start: PointBody, end: PointBody, at: &str, faults: &mut Faults) -> Option<[Vector; 2]> {
        let mut value = |body, name: &str| Some(self.read(&[body], &format!("{at}/{name}"), faults)?[0]);
        let (start, end) = (value(start, "start"), value(end, "end"));
        Some([start?, end?])
    }

    fn ends(&self, slice: &[u8], faults: &mut Faults) -> Option<Ends> {
        const AT: &str = "/method/ends";
        Some(match read_tag(slice, AT, ENDS, faults)?.as_str() {
            "clamped" => {
                let body: ClampedEnds = read_value(slice, AT, faults)?;
                let [start, end] = self.pair(body.start, body.end, AT, faults)?;
                Ends::clamped(start, end)
            }
            "natural" => {
                read_value::<NaturalEnds>(slice, AT, faults)?;
                Ends::natural()
            }
            "second_derivative" => {
                let body: SecondDerivativeEnds = read_value(slice, AT, faults)?;
                let [start, end] = self.pair(body.start, body.end, AT, faults)?;
                Ends::second_derivatives(start, end)
            }
            "not_a_knot" => {
                read_value::<NotAKnotEnds>(slice, AT, faults)?;
                Ends::not_a_knot()
            }
            "periodic" => {
                read_value::<PeriodicEnds>(slice, AT, faults)?;
                Ends::Periodic
            }
            other => {
                unknown_type(AT, other, ENDS, faults);
                return None;
            }
        })
    }
}
