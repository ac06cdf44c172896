//! Curves as they are written: everything needed to build one again.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    net::Net,
    point::{self, PointBody},
};
use crate::api::{
    faults::Faults,
    json::{
        tags::{read_tag, tags, unknown_type},
        value::read_value,
    },
};
use flankfit_engine::{
    geometry::{
        BSplineBasis,
        curve::{BSplineCurve, Curve, CurveShape, PiecewisePolynomial, Polynomial, polynomial::Form},
        space::{HIGHEST_DEGREE, Vector, degree_too_high},
    },
    numerics::{Dd, check},
    words::counted,
};

/// A curve. Values are numbers for a graph y(x), points for a curve of plane or space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Curve, discriminator(property_name = "type", mapping(
    ("polynomial" = "#/components/schemas/PolynomialCurve"),
    ("piecewise_polynomial" = "#/components/schemas/PiecewisePolynomialCurve"),
    ("b_spline" = "#/components/schemas/BSplineCurve"),
    ("nurbs" = "#/components/schemas/NurbsCurve")
)))]
pub enum CurveBody {
    Polynomial(PolynomialCurveBody),
    PiecewisePolynomial(PiecewisePolynomialBody),
    BSpline(BSplineCurveBody),
    Nurbs(NurbsCurveBody),
}

/// One polynomial over the whole domain: in the barycentric form by `nodes`, `weights` and
/// `values`, in Newton's form by `nodes` (each as often as it has conditions) and `coefficients`.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PolynomialCurve)]
pub struct PolynomialCurveBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: PolynomialCurveTag,
    pub form: PolynomialFormName,
    /// Abscissae of the interpolation.
    pub nodes: Vec<f64>,
    /// Barycentric: Σ wᵢ yᵢ/(x − xᵢ) / Σ wᵢ/(x − xᵢ). They follow from the nodes and may be left
    /// out.
    pub weights: Option<Vec<f64>>,
    /// Barycentric: the values at the nodes.
    pub values: Option<Vec<PointBody>>,
    /// Newton: divided differences c₀ + c₁(x − x₀) + c₂(x − x₀)(x − x₁) + ….
    pub coefficients: Option<Vec<PointBody>>,
    /// Newton form: rounding remainders of `coefficients`; without them a few digits are lost.
    pub coefficient_remainders: Option<Vec<PointBody>>,
}

/// Form of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = PolynomialForm)]
pub enum PolynomialFormName {
    Barycentric,
    Newton,
}

/// Polynomial pieces: on the piece between breaks bᵢ and bᵢ₊₁ it is Σ cₖ (t − bᵢ)ᵏ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PiecewisePolynomialCurve)]
pub struct PiecewisePolynomialBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: PiecewisePolynomialTag,
    /// Ascending, both ends included.
    #[schema(min_items = 2)]
    pub breaks: Vec<f64>,
    /// For each piece its coefficients from the lowest power on, as many for every piece.
    #[schema(min_items = 1)]
    pub coefficients: Vec<Vec<PointBody>>,
}

/// Σ aᵢ Nᵢ(t) (Eq. 6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BSplineCurve)]
pub struct BSplineCurveBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineCurveTag,
    /// Degree of the pieces, from 0 (steps).
    #[schema(maximum = 25)]
    pub degree: usize,
    /// The full knot vector, ascending: as many as control points, degree and 1 together.
    pub knots: Vec<f64>,
    /// Their number is that of the knots minus the degree minus 1: numbers for a graph, `[x, y]` or
    /// `[x, y, z]` otherwise.
    #[schema(min_items = 1)]
    pub control_points: Vec<PointBody>,
}

/// Σ wᵢ aᵢ Nᵢ(t) / Σ wⱼ Nⱼ(t) (Eq. 9).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NurbsCurve)]
pub struct NurbsCurveBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NurbsCurveTag,
    /// Degree of the pieces, from 0 (steps).
    #[schema(maximum = 25)]
    pub degree: usize,
    /// The full knot vector, ascending: as many as control points, degree and 1 together.
    pub knots: Vec<f64>,
    /// Their number is that of the knots minus the degree minus 1: numbers for a graph, `[x, y]` or
    /// `[x, y, z]` otherwise.
    #[schema(min_items = 1)]
    pub control_points: Vec<PointBody>,
    /// One ≥ 0 for each control point; somewhere on every span one above 0.
    #[schema(min_items = 1)]
    pub weights: Vec<f64>,
}

tags! {
    PolynomialCurveTag = Polynomial,
    PiecewisePolynomialTag = PiecewisePolynomial,
    BSplineCurveTag = BSpline,
    NurbsCurveTag = Nurbs,
}

/// The types of curves.
const CURVES: &str = "polynomial, piecewise_polynomial, b_spline and nurbs are";

/// Reads a curve that stands at `at`.
pub fn read_curve(slice: &[u8], at: &str, faults: &mut Faults) -> Option<CurveShape> {
    match read_tag(slice, at, CURVES, faults)?.as_str() {
        "polynomial" => polynomial(read_value(slice, at, faults)?, at, faults).map(CurveShape::Polynomial),
        "piecewise_polynomial" => {
            pieces(read_value(slice, at, faults)?, at, faults).map(CurveShape::PiecewisePolynomial)
        }
        "b_spline" => {
            let body: BSplineCurveBody = read_value(slice, at, faults)?;
            b_spline(body.degree, body.knots, &body.control_points, None, at, faults).map(CurveShape::BSpline)
        }
        "nurbs" => {
            let body: NurbsCurveBody = read_value(slice, at, faults)?;
            b_spline(body.degree, body.knots, &body.control_points, Some(body.weights), at, faults)
                .map(CurveShape::BSpline)
        }
        other => {
            unknown_type(at, other, CURVES, faults);
            None
        }
    }
}

/// Builds a part of the object at `at`.
pub fn built<T>(made: Result<T, check::Faults>, at: &str, faults: &mut Faults) -> Option<T> {
    made.map_err(|found| faults.append(Faults::of_engine(at, &found))).ok()
}

fn polynomial(body: PolynomialCurveBody, at: &str, faults: &mut Faults) -> Option<Polynomial> {
    let foreign: &[(&str, bool)] = match body.form {
        PolynomialFormName::Barycentric => &[
            ("coefficients", body.coefficients.is_some()),
            ("coefficient_remainders", body.coefficient_remainders.is_some()),
        ],
        PolynomialFormName::Newton => &[("weights", body.weights.is_some()), ("values", body.values.is_some())],
    };
    let before = faults.count();
    for (name, _) in foreign.iter().filter(|(_, there)| *there) {
        faults.push(format!("{at}/{name}"), "it belongs to the other form");
    }
    if faults.count() > before {
        return None;
    }
    let name = match body.form {
        PolynomialFormName::Barycentric => "values",
        PolynomialFormName::Newton => "coefficients",
    };
    let place = format!("{at}/{name}");
    let Some(values) = body.values.or(body.coefficients) else {
        faults.push_missing(place, "missing");
        return None;
    };
    let (dimension, values) = point::read(&values, &place, faults)?;
    match body.form {
        PolynomialFormName::Barycentric => {
            let polynomial = built(Polynomial::lagrange(dimension, body.nodes, values), at, faults)?;
            check_weights(body.weights.as_deref(), &polynomial, at, faults)?;
            Some(polynomial)
        }
        PolynomialFormName::Newton => {
            let remainders = match &body.coefficient_remainders {
                None => vec![Vector::zeros(); values.len()],
                Some(remainders) => {
                    let place = format!("{at}/coefficient_remainders");
                    let (own, remainders) = point::read(remainders, &place, faults)?;
                    if own != dimension || remainders.len() != values.len() {
                        faults.push(place, "there must be one for each coefficient, of the same kind");
                        return None;
                    }
                    remainders
                }
            };
            let sum = |(high, low): (&Vector, &Vector)| std::array::from_fn(|c| Dd::from(high[c]) + Dd::from(low[c]));
            let differences = values.iter().zip(&remainders).map(sum).collect();
            built(Polynomial::of_differences(dimension, body.nodes, differences), at, faults)
        }
    }
}

/// Given weights must be those of the nodes, up to a common factor: others would be another,
/// rational, curve.
fn check_weights(given: Option<&[f64]>, polynomial: &Polynomial, at: &str, faults: &mut Faults) -> Option<()> {
    let (Some(given), Form::Barycentric(form)) = (given, polynomial.form()) else { return Some(()) };
    let own = form.weights();
    let largest = (0..own.len()).max_by(|i, j| own[*i].abs().total_cmp(&own[*j].abs())).unwrap_or(0);
    let factor = given.get(largest).map_or(f64::NAN, |weight| weight / own[largest]);
    let same = |(own, given): (&f64, &f64)| (given / factor - own).abs() <= 1e-8 * own.abs();
    if given.len() == own.len() && own.iter().zip(given).all(same) {
        return Some(());
    }
    faults.push(format!("{at}/weights"), "they are not the barycentric weights of these nodes; leave them out");
    None
}

fn pieces(body: PiecewisePolynomialBody, at: &str, faults: &mut Faults) -> Option<PiecewisePolynomial> {
    let net = Net::read(&body.coefficients, &format!("{at}/coefficients"), faults)?;
    if net.rows + 1 != body.breaks.len() {
        let detail = format!(
            "{} between {}",
            counted(net.rows, "piece", "pieces"),
            counted(body.breaks.len(), "break", "breaks")
        );
        faults.push(format!("{at}/coefficients"), detail);
        return None;
    }
    built(PiecewisePolynomial::new(net.dimension, body.breaks, net.columns - 1, net.values), at, faults)
}

fn b_spline(
    degree: usize,
    knots: Vec<f64>,
    control_points: &[PointBody],
    weights: Option<Vec<f64>>,
    at: &str,
    faults: &mut Faults,
) -> Option<BSplineCurve> {
    let points = point::read(control_points, &format!("{at}/control_points"), faults);
    if degree > HIGHEST_DEGREE {
        faults.append(Faults::of_engine(at, &degree_too_high("degree", degree)));
        return None;
    }
    let basis = built(BSplineBasis::new(degree, knots), &format!("{at}/knots"), faults);
    let (dimension, points) = points?;
    built(BSplineCurve::new(basis?, dimension, points, weights), at, faults)
}

impl From<&CurveShape> for CurveBody {
    fn from(shape: &CurveShape) -> Self {
        match shape {
            CurveShape::Polynomial(curve) => CurveBody::Polynomial(written_polynomial(curve)),
            CurveShape::PiecewisePolynomial(curve) => CurveBody::PiecewisePolynomial(PiecewisePolynomialBody {
                kind: PiecewisePolynomialTag::PiecewisePolynomial,
                breaks: curve.places().to_vec(),
                coefficients: Net::written(curve.dimension(), curve.degree() + 1, curve.coefficients()),
            }),
            CurveShape::BSpline(curve) => {
                let degree = curve.basis().degree();
                let knots = curve.basis().knots().to_vec();
                let control_points = point::written(curve.dimension(), curve.control_points());
                match curve.weights() {
                    None => CurveBody::BSpline(BSplineCurveBody {
                        kind: BSplineCurveTag::BSpline,
                        degree,
                        knots,
                        control_points,
                    }),
                    Some(weights) => CurveBody::Nurbs(NurbsCurveBody {
                        kind: NurbsCurveTag::Nurbs,
                        degree,
                        knots,
                        control_points,
                        weights: weights.to_vec(),
                    }),
                }
            }
        }
    }
}

fn written_polynomial(curve: &Polynomial) -> PolynomialCurveBody {
    let dimension = curve.dimension();
    let body = |form, nodes: &[f64]| PolynomialCurveBody {
        kind: PolynomialCurveTag::Polynomial,
        form,
        nodes: nodes.to_vec(),
        weights: None,
        values: None,
        coefficients: None,
        coefficient_remainders: None,
    };
    match curve.form() {
        Form::Barycentric(form) => PolynomialCurveBody {
            weights: Some(form.weights().to_vec()),
            values: Some(point::written(dimension, form.values())),
            ..body(PolynomialFormName::Barycentric, form.nodes())
        },
        Form::Newton(form) => {
            let parts = |part: fn(&Dd) -> f64| {
                let vector = |difference: &[Dd; 3]| Vector::from_fn(|c, _| part(&difference[c]));
                point::written(dimension, &form.differences().iter().map(vector).collect::<Vec<_>>())
            };
            PolynomialCurveBody {
                coefficients: Some(parts(|d| d.hi)),
                coefficient_remainders: Some(parts(|d| d.lo)),
                ..body(PolynomialFormName::Newton, form.nodes())
            }
        }
    }
}
