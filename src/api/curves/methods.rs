//! Methods that lead a curve through or near points.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{faults::Faults, shapes::THROUGH};
use flankfit_engine::{
    estimation::spec::Parameter,
    geometry::{
        contract::{self, Point},
        curve::{Ends, KnotChoice, Method, Tangents},
        space::{Dimension, Vector},
    },
    numerics::{check, tagged},
};

/// Method of a curve through the points (all but the last three) or near them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum CurveMethod {
    /// The polynomial through all points, in barycentric form (Eqs. 1 and 2).
    Lagrange(NoSettings),
    /// The same polynomial by divided differences.
    Newton(NoSettings),
    /// The polynomial through points with given derivatives (Eqs. 3 and 4).
    Hermite(HermiteCurveMethod),
    /// Cubic pieces with given or estimated tangents (Eq. 5).
    CubicHermite(CubicHermiteCurveMethod),
    /// Cubic pieces with continuous second derivatives.
    CubicSpline(CubicSplineCurveMethod),
    /// The B-spline through all points (Eqs. 6 to 8).
    BSpline(BSplineCurveMethod),
    /// The least-squares B-spline. Exactly one of `knots`, `spans`, `control_count` and `tolerance`
    /// sets the knots.
    BSplineLeastSquares(BSplineLeastSquaresCurveMethod),
    /// The NURBS nearest to the points, with given weights of the control points (Eq. 9).
    NurbsLeastSquares(NurbsLeastSquaresCurveMethod),
    /// The natural cubic spline of least Σ w (y − f)² + λ ∫ f″².
    SmoothingSpline(SmoothingSplineCurveMethod),
}

tagged!(CurveMethod as name {
    "lagrange" => Lagrange,
    "newton" => Newton,
    "hermite" => Hermite,
    "cubic_hermite" => CubicHermite,
    "cubic_spline" => CubicSpline,
    "b_spline" => BSpline,
    "b_spline_least_squares" => BSplineLeastSquares,
    "nurbs_least_squares" => NurbsLeastSquares,
    "smoothing_spline" => SmoothingSpline,
});

/// A method that has only its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HermiteCurveMethod {
    /// For each point its known derivatives, from the first order; the list may be empty.
    pub derivatives: Vec<Vec<Point>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CubicHermiteCurveMethod {
    pub tangents: TangentsName,
    /// With `given`: the first derivative at each point.
    pub values: Option<Vec<Point>>,
}

/// Tangents of cubic pieces. `monotone` (Fritsch and Butland) keeps values between those of the
/// neighbours; `akima` is least affected by outlying points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Tangents)]
pub enum TangentsName {
    Given,
    FiniteDifference,
    CatmullRom,
    Parabola,
    Monotone,
    Akima,
    ModifiedAkima,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CubicSplineCurveMethod {
    pub ends: EndsBody,
}

/// End conditions of a cubic spline: the paper's (i) to (iv), and `periodic`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = Ends)]
pub enum EndsBody {
    /// Given first derivatives.
    Clamped(EndDerivatives),
    /// Free ends: second derivatives 0.
    Natural(NoSettings),
    /// Given second derivatives.
    SecondDerivative(EndDerivatives),
    /// The two pieces at either end are one cubic: continuous third derivatives.
    NotAKnot(NoSettings),
    /// Periodic: the last point repeats the first, and slope and curvature are continuous there.
    Periodic(NoSettings),
}

tagged!(EndsBody {
    "clamped" => Clamped,
    "natural" => Natural,
    "second_derivative" => SecondDerivative,
    "not_a_knot" => NotAKnot,
    "periodic" => Periodic,
});

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EndDerivatives {
    pub start: Point,
    pub end: Point,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineCurveMethod {
    /// Degree of the pieces; 3 gives continuous curvature.
    #[schema(minimum = 1, maximum = 25)]
    pub degree: usize,
    /// The full knot vector; default averages of neighbouring parameters (The NURBS Book, 9.8).
    pub knots: Option<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineLeastSquaresCurveMethod {
    /// Degree of the pieces; 3 gives continuous curvature.
    #[schema(minimum = 0, maximum = 25)]
    pub degree: usize,
    /// The full knot vector.
    pub knots: Option<Vec<f64>>,
    /// Equal spans.
    #[schema(minimum = 1)]
    pub spans: Option<usize>,
    /// Number of control points; knots are placed so that every span has points (The NURBS Book,
    /// 9.68 and 9.69).
    #[schema(minimum = 1)]
    pub control_count: Option<usize>,
    /// Largest distance of a point from the curve; knots are inserted until it is met or none can
    /// be inserted.
    #[schema(exclusive_minimum = 0)]
    pub tolerance: Option<f64>,
    /// One weight for each point; it multiplies the squared residual.
    pub weight: Option<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NurbsLeastSquaresCurveMethod {
    /// Degree of the pieces.
    #[schema(minimum = 0, maximum = 25)]
    pub degree: usize,
    /// The full knot vector.
    pub knots: Vec<f64>,
    /// One above 0 for each control point.
    pub weights: Vec<f64>,
    /// One weight for each point; it multiplies the squared residual.
    pub weight: Option<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothingSplineCurveMethod {
    /// λ: `gcv` (default), `discrepancy` (with `noise_sigma`), `l_curve`, or `fixed` with a value.
    pub parameter: Option<Parameter>,
    /// Deviation of a height of weight 1.
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma: Option<f64>,
    /// Instead of `parameter`: how many parameters the curve is worth, more than 2 (a line) and
    /// less than the number of points (the interpolant).
    #[schema(minimum = 2)]
    pub degrees_of_freedom: Option<f64>,
    /// One weight for each point; it multiplies the squared residual.
    pub weight: Option<Vec<f64>>,
}

/// A method that passes through its points, or one near them.
pub enum Requested {
    Through(Method),
    Near(NearMethod),
}

/// A method near points.
pub enum NearMethod {
    BSpline(BSplineLeastSquaresCurveMethod),
    Nurbs(NurbsLeastSquaresCurveMethod),
    Smoothing(SmoothingSplineCurveMethod),
}

impl CurveMethod {
    /// Returns why the request may have no field of a fit, if so.
    pub fn takes_no_fit(&self) -> Option<&'static str> {
        match self {
            CurveMethod::BSplineLeastSquares(_) | CurveMethod::NurbsLeastSquares(_) => None,
            CurveMethod::SmoothingSpline(_) => {
                Some("a smoothing spline has `parameter`, `noise_sigma` and `weight` in its method, and no estimator")
            }
            _ => Some(THROUGH),
        }
    }

    /// Returns the method for points of a dimension, or adds what is wrong with it.
    pub fn requested(self, dimension: Dimension, faults: &mut Faults) -> Option<Requested> {
        const AT: &str = "/method";
        let values = Values { dimension };
        let method = match self {
            CurveMethod::Lagrange(_) => Method::Lagrange,
            CurveMethod::Newton(_) => Method::Newton,
            CurveMethod::Hermite(method) => {
                let orders = method.derivatives.iter().enumerate();
                let read =
                    |(i, orders): (usize, &Vec<Point>)| values.read(orders, &format!("{AT}/derivatives/{i}"), faults);
                Method::Hermite { derivatives: orders.map(read).collect::<Option<_>>()? }
            }
            CurveMethod::CubicHermite(method) => Method::CubicHermite(values.tangents(method, faults)?),
            CurveMethod::CubicSpline(method) => Method::CubicSpline(values.ends(method.ends, faults)?),
            CurveMethod::BSpline(BSplineCurveMethod { degree, knots }) => {
                Method::BSpline { degree, knots: knots.map_or(KnotChoice::Averaging, KnotChoice::Given) }
            }
            CurveMethod::BSplineLeastSquares(method) => return Some(Requested::Near(NearMethod::BSpline(method))),
            CurveMethod::NurbsLeastSquares(method) => return Some(Requested::Near(NearMethod::Nurbs(method))),
            CurveMethod::SmoothingSpline(method) => return Some(Requested::Near(NearMethod::Smoothing(method))),
        };
        Some(Requested::Through(method))
    }
}

/// Values that must be of the kind of the points.
struct Values {
    dimension: Dimension,
}

impl Values {
    fn read(&self, points: &[Point], at: &str, faults: &mut Faults) -> Option<Vec<Vector>> {
        if points.is_empty() {
            return Some(Vec::new());
        }
        let mut found = check::Faults::default();
        let Some((dimension, values)) = contract::values(points, "", &mut found) else {
            faults.append(Faults::of_engine(at, &found));
            return None;
        };
        if dimension != self.dimension {
            faults.push(at, "they must be like the points: numbers for a graph, else as many coordinates");
            return None;
        }
        Some(values)
    }

    fn tangents(&self, method: CubicHermiteCurveMethod, faults: &mut Faults) -> Option<Tangents> {
        const AT: &str = "/method/values";
        match (method.tangents, method.values) {
            (TangentsName::Given, Some(given)) => return self.read(&given, AT, faults).map(Tangents::Given),
            (TangentsName::Given, None) => faults.push_missing(AT, "required; the tangents `given` need them"),
            (_, Some(_)) => faults.push(AT, "only the tangents `given` take values"),
            (TangentsName::FiniteDifference, None) => return Some(Tangents::FiniteDifference),
            (TangentsName::CatmullRom, None) => return Some(Tangents::CatmullRom),
            (TangentsName::Parabola, None) => return Some(Tangents::Parabola),
            (TangentsName::ModifiedAkima, None) => return Some(Tangents::ModifiedAkima),
            (TangentsName::Monotone, None) => return Some(Tangents::Monotone),
            (TangentsName::Akima, None) => return Some(Tangents::Akima),
        }
        None
    }

    fn ends(&self, ends: EndsBody, faults: &mut Faults) -> Option<Ends> {
        let mut pair = |EndDerivatives { start, end }| {
            let mut value = |point, name| Some(self.read(&[point], &format!("/method/ends/{name}"), faults)?[0]);
            let (start, end) = (value(start, "start"), value(end, "end"));
            Some((start?, end?))
        };
        Some(match ends {
            EndsBody::Clamped(given) => pair(given).map(|(start, end)| Ends::clamped(start, end))?,
            EndsBody::Natural(_) => Ends::natural(),
            EndsBody::SecondDerivative(given) => {
                pair(given).map(|(start, end)| Ends::second_derivatives(start, end))?
            }
            EndsBody::NotAKnot(_) => Ends::not_a_knot(),
            EndsBody::Periodic(_) => Ends::Periodic,
        })
    }
}
