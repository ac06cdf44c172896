//! How a curve is led through or near points, as it is written.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    json::{request::request, tags::tags},
    shapes::point::PointBody,
};
use flankfit_engine::estimation::spec::Parameter;

/// Method of a curve through the points (all but the last three) or near them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = CurveMethod, discriminator(property_name = "type", mapping(
    ("lagrange" = "#/components/schemas/LagrangeMethod"),
    ("newton" = "#/components/schemas/NewtonMethod"),
    ("hermite" = "#/components/schemas/HermiteMethod"),
    ("cubic_hermite" = "#/components/schemas/CubicHermiteMethod"),
    ("cubic_spline" = "#/components/schemas/CubicSplineMethod"),
    ("b_spline" = "#/components/schemas/BSplineCurveMethod"),
    ("b_spline_least_squares" = "#/components/schemas/BSplineLeastSquaresCurveMethod"),
    ("nurbs_least_squares" = "#/components/schemas/NurbsLeastSquaresCurveMethod"),
    ("smoothing_spline" = "#/components/schemas/SmoothingSplineMethod")
)))]
pub enum CurveMethodBody {
    Lagrange(LagrangeMethod),
    Newton(NewtonMethod),
    Hermite(HermiteMethod),
    CubicHermite(CubicHermiteMethod),
    CubicSpline(CubicSplineMethod),
    BSpline(BSplineCurveMethod),
    BSplineLeastSquares(BSplineLeastSquaresCurveMethod),
    NurbsLeastSquares(NurbsLeastSquaresCurveMethod),
    SmoothingSpline(SmoothingSplineMethod),
}

/// The polynomial through all points, in barycentric form (Eqs. 1 and 2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LagrangeMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LagrangeTag,
}

/// The same polynomial by divided differences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewtonMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NewtonTag,
}

/// The polynomial through points with given derivatives (Eqs. 3 and 4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HermiteMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: HermiteTag,
    /// For each point its known derivatives, from the first order; the list may be empty.
    pub derivatives: Vec<Vec<PointBody>>,
}

/// Cubic pieces with given or estimated tangents (Eq. 5).
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CubicHermiteMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: CubicHermiteTag,
    pub tangents: TangentsName,
    /// With `given`: the first derivative at each point.
    pub values: Option<Vec<PointBody>>,
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

request! {
    /// Cubic pieces with continuous second derivatives.
    pub struct CubicSplineMethod as CubicSplineMembers {
        #[schema(inline)]
        required kind as "type": CubicSplineTag,
        required ends: EndsBody,
    }
}

/// End conditions of a cubic spline: the paper's (i) to (iv), and `periodic`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Ends, discriminator(property_name = "type", mapping(
    ("clamped" = "#/components/schemas/ClampedEnds"),
    ("natural" = "#/components/schemas/NaturalEnds"),
    ("second_derivative" = "#/components/schemas/SecondDerivativeEnds"),
    ("not_a_knot" = "#/components/schemas/NotAKnotEnds"),
    ("periodic" = "#/components/schemas/PeriodicEnds")
)))]
pub enum EndsBody {
    Clamped(ClampedEnds),
    Natural(NaturalEnds),
    SecondDerivative(SecondDerivativeEnds),
    NotAKnot(NotAKnotEnds),
    Periodic(PeriodicEnds),
}

/// Given first derivatives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ClampedEnds {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: ClampedTag,
    pub start: PointBody,
    pub end: PointBody,
}

/// Free ends: second derivatives 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NaturalEnds {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NaturalTag,
}

/// Given second derivatives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SecondDerivativeEnds {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: SecondDerivativeTag,
    pub start: PointBody,
    pub end: PointBody,
}

/// The two pieces at either end are one cubic: continuous third derivatives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NotAKnotEnds {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NotAKnotTag,
}

/// Periodic: the last point repeats the first, and slope and curvature are continuous there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PeriodicEnds {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: PeriodicTag,
}

/// The B-spline through all points (Eqs. 6 to 8).
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineCurveMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineCurveMethodTag,
    /// Degree of the pieces; 3 gives continuous curvature.
    #[schema(minimum = 1, maximum = 25)]
    pub degree: usize,
    /// The full knot vector; default averages of neighbouring parameters (The NURBS Book, 9.8).
    pub knots: Option<Vec<f64>>,
}

/// The least-squares B-spline. Exactly one of `knots`, `spans`, `control_count` and `tolerance`
/// sets the knots.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineLeastSquaresCurveMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineLeastSquaresTag,
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

/// The NURBS nearest to the points, with given weights of the control points (Eq. 9).
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NurbsLeastSquaresCurveMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NurbsLeastSquaresTag,
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

/// The natural cubic spline of least Σ w (y − f)² + λ ∫ f″².
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothingSplineMethod {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: SmoothingSplineTag,
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

tags! {
    LagrangeTag = Lagrange,
    NewtonTag = Newton,
    HermiteTag = Hermite,
    CubicHermiteTag = CubicHermite,
    CubicSplineTag = CubicSpline,
    BSplineCurveMethodTag = BSpline,
    BSplineLeastSquaresTag = BSplineLeastSquares,
    NurbsLeastSquaresTag = NurbsLeastSquares,
    SmoothingSplineTag = SmoothingSpline,
    ClampedTag = Clamped,
    NaturalTag = Natural,
    SecondDerivativeTag = SecondDerivative,
    NotAKnotTag = NotAKnot,
    PeriodicTag = Periodic,
}
