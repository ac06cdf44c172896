//! Curves in their written form.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::points::{Net, Point, points, values};
use crate::{
    BSplineBasis,
    curve::{BSplineCurve, Curve as _, CurveShape, PiecewisePolynomial, Polynomial, polynomial::Form},
    space::{HIGHEST_DEGREE, Vector, degree_too_high},
};
use flankfit_numerics::{Dd, check::Faults, contract::refused, words::counted};

/// A curve. Values are numbers for a graph y(x), points for a curve of plane or space.
#[derive(Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Curve {
    /// One polynomial over the whole domain: in the barycentric form by `nodes`, `weights` and
    /// `values`, in Newton's form by `nodes` (each repeated for every condition) and
    /// `coefficients`.
    Polynomial(PolynomialCurve),
    /// Polynomial pieces: on the piece between breaks bᵢ and bᵢ₊₁ it is Σ cₖ (t − bᵢ)ᵏ.
    PiecewisePolynomial(PiecewisePolynomialCurve),
    /// Σ aᵢ Nᵢ(t) (Eq. 6).
    BSpline(PolynomialSpline),
    /// Σ wᵢ aᵢ Nᵢ(t) / Σ wⱼ Nⱼ(t) (Eq. 9).
    Nurbs(NurbsCurve),
}

flankfit_numerics::tagged!(Curve {
    "polynomial" => Polynomial,
    "piecewise_polynomial" => PiecewisePolynomial,
    "b_spline" => BSpline,
    "nurbs" => Nurbs,
});

#[skip_serializing_none]
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct PolynomialCurve {
    form: PolynomialForm,
    /// Abscissae of the interpolation.
    nodes: Vec<f64>,
    /// Barycentric: Σ wᵢ yᵢ/(x − xᵢ) / Σ wᵢ/(x − xᵢ). They follow from the nodes and may be left
    /// out.
    weights: Option<Vec<f64>>,
    /// Barycentric: the values at the nodes.
    values: Option<Vec<Point>>,
    /// Newton: divided differences c₀ + c₁(x − x₀) + c₂(x − x₀)(x − x₁) + ….
    coefficients: Option<Vec<Point>>,
    /// Newton form: rounding remainders of `coefficients`; without them a few digits are lost.
    coefficient_remainders: Option<Vec<Point>>,
}

/// Form of a polynomial.
#[derive(Clone, Copy, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum PolynomialForm {
    Barycentric,
    Newton,
}

#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct PiecewisePolynomialCurve {
    /// Ascending, both ends included.
    #[schema(min_items = 2)]
    breaks: Vec<f64>,
    /// For each piece its coefficients from the lowest power on, as many for every piece.
    #[schema(min_items = 1)]
    coefficients: Vec<Vec<Point>>,
}

#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BSplineCurve)]
struct PolynomialSpline {
    /// Degree of the pieces, from 0 (steps).
    #[schema(maximum = 25)]
    degree: usize,
    /// The full knot vector, ascending: as many as control points, degree and 1 together.
    knots: Vec<f64>,
    /// Their number is that of the knots minus the degree minus 1: numbers for a graph, `[x, y]` or
    /// `[x, y, z]` otherwise.
    #[schema(min_items = 1)]
    control_points: Vec<Point>,
}

#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct NurbsCurve {
    /// Degree of the pieces, from 0 (steps).
    #[schema(maximum = 25)]
    degree: usize,
    /// The full knot vector, ascending: as many as control points, degree and 1 together.
    knots: Vec<f64>,
    /// Their number is that of the knots minus the degree minus 1: numbers for a graph, `[x, y]` or
    /// `[x, y, z]` otherwise.
    #[schema(min_items = 1)]
    control_points: Vec<Point>,
    /// One ≥ 0 for each control point; somewhere on every span one above 0.
    #[schema(min_items = 1)]
    weights: Vec<f64>,
}

flankfit_numerics::written_as!(CurveShape, Curve);

impl Serialize for CurveShape {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Curve::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for CurveShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shape = match Curve::deserialize(deserializer)? {
            Curve::Polynomial(curve) => polynomial(curve).map(CurveShape::Polynomial),
            Curve::PiecewisePolynomial(curve) => pieces(curve).map(CurveShape::PiecewisePolynomial),
            Curve::BSpline(PolynomialSpline { degree, knots, control_points }) => {
                b_spline(degree, knots, &control_points, None).map(CurveShape::BSpline)
            }
            Curve::Nurbs(NurbsCurve { degree, knots, control_points, weights }) => {
                b_spline(degree, knots, &control_points, Some(weights)).map(CurveShape::BSpline)
            }
        };
        shape.map_err(refused)
    }
}

fn polynomial(curve: PolynomialCurve) -> Result<Polynomial, Faults> {
    let PolynomialCurve { form, nodes, weights, values: given, coefficients, coefficient_remainders: remainders } =
        curve;
    let mut faults = Faults::default();
    let (foreign, place, given) = match form {
        PolynomialForm::Barycentric => {
            let foreign = [("coefficients", coefficients.is_some()), ("coefficient_remainders", remainders.is_some())];
            (foreign, "values", given)
        }
        PolynomialForm::Newton => {
            ([("weights", weights.is_some()), ("values", given.is_some())], "coefficients", coefficients)
        }
    };
    foreign.iter().filter(|(_, is_given)| *is_given).for_each(|(name, _)| {
        faults.push(name, "it belongs to the other form");
    });
    if !faults.is_empty() {
        return Err(faults);
    }
    let Some(given) = given else { return Err(Faults::one(place, "missing")) };
    let Some((dimension, values)) = values(&given, place, &mut faults) else { return Err(faults) };
    if matches!(form, PolynomialForm::Barycentric) {
        let polynomial = Polynomial::lagrange(dimension, nodes, values)?;
        return check_weights(weights.as_deref(), &polynomial).map(|()| polynomial);
    }
    let remainders = match remainders {
        None => vec![Vector::zeros(); values.len()],
        Some(remainders) => {
            const PLACE: &str = "coefficient_remainders";
            let Some((own, remainders)) = self::values(&remainders, PLACE, &mut faults) else { return Err(faults) };
            if own != dimension || remainders.len() != values.len() {
                return Err(Faults::one(PLACE, "there must be one for each coefficient, of the same kind"));
            }
            remainders
        }
    };
    let sum = |(high, low): (&Vector, &Vector)| std::array::from_fn(|c| Dd::from(high[c]) + Dd::from(low[c]));
    Polynomial::of_differences(dimension, nodes, values.iter().zip(&remainders).map(sum).collect())
}

/// Checks that weights are those of the nodes, up to a common factor: others belong to another,
/// rational, curve.
fn check_weights(given: Option<&[f64]>, polynomial: &Polynomial) -> Result<(), Faults> {
    let (Some(given), Form::Barycentric(form)) = (given, polynomial.form()) else { return Ok(()) };
    let own = form.weights();
    let largest = (0..own.len()).max_by(|i, j| own[*i].abs().total_cmp(&own[*j].abs())).unwrap_or(0);
    let factor = given.get(largest).map_or(f64::NAN, |weight| weight / own[largest]);
    let same = |(own, given): (&f64, &f64)| (given / factor - own).abs() <= 1e-8 * own.abs();
    if given.len() == own.len() && own.iter().zip(given).all(same) {
        return Ok(());
    }
    Err(Faults::one("weights", "they are not the barycentric weights of these nodes; omit them"))
}

fn pieces(curve: PiecewisePolynomialCurve) -> Result<PiecewisePolynomial, Faults> {
    const PLACE: &str = "coefficients";
    let mut faults = Faults::default();
    let Some(net) = Net::new(&curve.coefficients, PLACE, &mut faults) else { return Err(faults) };
    if net.rows + 1 != curve.breaks.len() {
        let [pieces, breaks] = [counted(net.rows, "piece", "pieces"), counted(curve.breaks.len(), "break", "breaks")];
        return Err(Faults::one(PLACE, format_args!("{pieces} between {breaks}")));
    }
    PiecewisePolynomial::new(net.dimension, curve.breaks, net.columns - 1, net.values)
}

fn b_spline(
    degree: usize,
    knots: Vec<f64>,
    control_points: &[Point],
    weights: Option<Vec<f64>>,
) -> Result<BSplineCurve, Faults> {
    let mut faults = Faults::default();
    let controls = values(control_points, "control_points", &mut faults);
    if degree > HIGHEST_DEGREE {
        faults.append(degree_too_high("degree", degree));
        return Err(faults);
    }
    match (BSplineBasis::new(degree, knots), controls) {
        (Ok(basis), Some((dimension, points))) => BSplineCurve::new(basis, dimension, points, weights),
        (basis, _) => {
            faults.append(basis.err().unwrap_or_default().within("knots"));
            Err(faults)
        }
    }
}

impl From<&CurveShape> for Curve {
    fn from(shape: &CurveShape) -> Self {
        match shape {
            CurveShape::Polynomial(curve) => Curve::Polynomial(curve.into()),
            CurveShape::PiecewisePolynomial(curve) => Curve::PiecewisePolynomial(PiecewisePolynomialCurve {
                breaks: curve.places().to_vec(),
                coefficients: Net::points(curve.dimension(), curve.degree() + 1, curve.coefficients()),
            }),
            CurveShape::BSpline(curve) => {
                let (degree, knots) = (curve.basis().degree(), curve.basis().knots().to_vec());
                let control_points = points(curve.dimension(), curve.control_points());
                match curve.weights() {
                    None => Curve::BSpline(PolynomialSpline { degree, knots, control_points }),
                    Some(weights) => {
                        Curve::Nurbs(NurbsCurve { degree, knots, control_points, weights: weights.to_vec() })
                    }
                }
            }
        }
    }
}

impl From<&Polynomial> for PolynomialCurve {
    fn from(curve: &Polynomial) -> Self {
        let dimension = curve.dimension();
        let of = |form, nodes: &[f64]| PolynomialCurve {
            form,
            nodes: nodes.to_vec(),
            weights: None,
            values: None,
            coefficients: None,
            coefficient_remainders: None,
        };
        match curve.form() {
            Form::Barycentric(form) => PolynomialCurve {
                weights: Some(form.weights().to_vec()),
                values: Some(points(dimension, form.values())),
                ..of(PolynomialForm::Barycentric, form.nodes())
            },
            Form::Newton(form) => {
                let parts = |part: fn(&Dd) -> f64| {
                    let vector = |difference: &[Dd; 3]| Vector::from_fn(|c, _| part(&difference[c]));
                    points(dimension, &form.differences().iter().map(vector).collect::<Vec<_>>())
                };
                PolynomialCurve {
                    coefficients: Some(parts(|d| d.hi)),
                    coefficient_remainders: Some(parts(|d| d.lo)),
                    ..of(PolynomialForm::Newton, form.nodes())
                }
            }
        }
    }
}
