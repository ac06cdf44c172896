//! Any curve as a B-spline, which is what CAD reads.
//!
//! Control points are polar forms of the pieces, so that the same polynomials result, to rounding.
//! A break gets as many knots as the continuity there asks for; where rounding leaves it open how
//! continuous the pieces are, as many as continuity of the value does.

use super::{BSplineCurve, Curve, CurveShape, PiecewisePolynomial, check};
use crate::{
    BSplineBasis,
    space::{HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::{Dd, check::Faults};

/// Coefficients of pieces are right to this part of their terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// How far, in parts of the largest value, the B-spline may lie from the pieces before more knots
/// are spent.
const AWAY: f64 = 1e-14;

/// Coefficients of powers, from the lowest, and the place they are powers of the distance from.
struct Piece {
    at: f64,
    powers: Vec<[Dd; 3]>,
}

impl CurveShape {
    /// The same curve as a B-spline, with weights where it has them. Refused for a polynomial whose
    /// degree is above [`HIGHEST_DEGREE`].
    ///
    /// ```
    /// use flankfit_geometry::curve::{Method, Points, construct::shape_through};
    ///
    /// // x² from 0 to 2 in Bernstein form: control heights 0, 0, 4.
    /// let points = Points::Graph { x: vec![0.0, 1.0, 2.0], y: vec![0.0, 1.0, 4.0] };
    /// let (parabola, _) = shape_through(&points, &Method::Newton)?;
    /// let spline = parabola.to_b_spline()?;
    /// let heights: Vec<f64> = spline.control_points().iter().map(|point| point.x).collect();
    /// assert_eq!(heights, [0.0, 0.0, 4.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_b_spline(&self) -> Result<BSplineCurve, Faults> {
        match self {
            CurveShape::BSpline(curve) => Ok(curve.clone()),
            CurveShape::PiecewisePolynomial(curve) => piecewise(curve),
            CurveShape::Polynomial(curve) => {
                let degree = curve.conditions() - 1;
                check::degree("degree", degree, 0, HIGHEST_DEGREE)?;
                let [low, high] = curve.domain();
                let at = 0.5 * low + 0.5 * high;
                let piece = Piece { at, powers: curve.powers(at) };
                assemble(curve, degree, &[low, high], &[], &[piece])
            }
        }
    }
}

fn piecewise(curve: &PiecewisePolynomial) -> Result<BSplineCurve, Faults> {
    let (p, breaks) = (curve.degree(), curve.places());
    let lift = |v: &Vector| [v.x, v.y, v.z].map(Dd::from);
    let pieces: Vec<Piece> = (0..breaks.len() - 1)
        .map(|i| Piece { at: breaks[i], powers: curve.piece(i).iter().map(lift).collect() })
        .collect();
    let orders: Vec<Option<usize>> =
        (1..breaks.len() - 1).map(|i| continuity(&pieces[i - 1], &pieces[i], breaks[i])).collect();
    // at least one knot, so that every piece keeps a span of its own
    let knots = |order: &Option<usize>| order.map_or(p + 1, |order| (p - order.min(p)).max(1));
    let smooth: Vec<usize> = orders.iter().map(knots).collect();
    let spline = assemble(curve, p, breaks, &smooth, &pieces)?;
    if agrees(curve, &spline) {
        return Ok(spline);
    }
    let apart: Vec<usize> = orders.iter().map(|order| if order.is_some() { p.max(1) } else { p + 1 }).collect();
    assemble(curve, p, breaks, &apart, &pieces)
}

/// The order of the highest derivative up to which two pieces agree at their break; None if not
/// even the values do.
fn continuity(left: &Piece, right: &Piece, at: f64) -> Option<usize> {
    let h = Dd::diff(at, left.at);
    let agree = |order: usize| {
        (0..3).all(|k| {
            let (mut sum, mut size, mut power) = (Dd::ZERO, 0.0, Dd::ONE);
            for j in order..left.powers.len() {
                let term = left.powers[j][k] * power * binomial(j, order);
                sum += term;
                size += term.abs().hi;
                power *= h;
            }
            let other = right.powers[order][k];
            (sum - other).abs().hi <= ROUNDING * (size + other.abs().hi)
        })
    };
    (0..left.powers.len()).take_while(|order| agree(*order)).last()
}

/// The B-spline with so many knots at the inner breaks.
fn assemble(
    curve: &impl Curve,
    degree: usize,
    breaks: &[f64],
    inner: &[usize],
    pieces: &[Piece],
) -> Result<BSplineCurve, Faults> {
    let last = breaks.len() - 1;
    let mut knots = Vec::new();
    for (i, at) in breaks.iter().enumerate() {
        let times = if i == 0 || i == last { degree + 1 } else { inner[i - 1] };
        knots.extend(std::iter::repeat_n(*at, times));
    }
    let basis = BSplineBasis::new(degree, knots)?;
    let knots = basis.knots();
    let point = |i: usize| {
        // the span with a width that is nearest to the middle of the function's support
        let spans = (i..=i + degree).filter(|j| knots[*j] < knots[j + 1]);
        let span = spans.min_by_key(|j| (2 * j).abs_diff(2 * i + degree)).unwrap_or(i);
        let piece = breaks[1..last].partition_point(|b| *b <= knots[span]);
        polar(&pieces[piece], &knots[i + 1..=i + degree])
    };
    let points = (0..basis.size()).map(point).collect();
    BSplineCurve::new(basis, curve.dimension(), points, None)
}

/// The polar form: the k-th power becomes the k-th elementary symmetric function of the distances,
/// over its number of terms.
fn polar(piece: &Piece, arguments: &[f64]) -> Vector {
    let p = arguments.len();
    let mut symmetric = vec![Dd::ZERO; p + 1];
    symmetric[0] = Dd::ONE;
    for (count, u) in arguments.iter().enumerate() {
        let distance = Dd::diff(*u, piece.at);
        for k in (1..=count + 1).rev() {
            let below = symmetric[k - 1];
            symmetric[k] += below * distance;
        }
    }
    let coordinate = |k: usize| {
        let terms = piece.powers.iter().zip(&symmetric).enumerate();
        terms.fold(Dd::ZERO, |sum, (j, (c, e))| sum + c[k] * *e / binomial(p, j)).to_f64()
    };
    Vector::new(coordinate(0), coordinate(1), coordinate(2))
}

/// Exact for what degrees there are.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

fn agrees(curve: &PiecewisePolynomial, spline: &BSplineCurve) -> bool {
    let (mut away, mut largest) = (0.0f64, 0.0f64);
    for pair in curve.places().windows(2) {
        for part in [0.0, 0.25, 0.5, 0.75] {
            let t = pair[0] + (pair[1] - pair[0]) * part;
            let value = curve.value(t);
            away = away.max((value - spline.value(t)).amax());
            largest = largest.max(value.amax());
        }
    }
    away <= AWAY * largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Ends, KnotChoice, Method, Points, Tangents, construct::shape_through};

    fn shape(method: Method) -> CurveShape {
        let x = vec![0.0, 0.5, 2.0, 2.25, 4.0, 7.0];
        let y = vec![1.0, 3.0, -2.0, 0.5, 0.5, 4.0];
        shape_through(&Points::Graph { x, y }, &method).unwrap().0
    }

    #[test]
    fn the_same_curve_with_as_few_knots_as_it_needs() {
        let third = Method::BSpline { degree: 3, knots: KnotChoice::Averaging };
        for (method, knots) in [
            (Method::Lagrange, 12),
            (Method::Newton, 12),
            (Method::CubicHermite(Tangents::Akima), 16),
            (Method::CubicHermite(Tangents::FiniteDifference), 16),
            (Method::CubicSpline(Ends::natural()), 12),
            (Method::CubicSpline(Ends::not_a_knot()), 12),
            (third, 10),
        ] {
            let shape = shape(method.clone());
            let spline = shape.to_b_spline().unwrap();
            assert_eq!(spline.basis().knots().len(), knots, "{method:?}");
            for i in 0..=70 {
                let t = f64::from(i) * 0.1;
                let (one, other) = (shape.jet(t), spline.jet(t));
                for k in 0..2 {
                    let (miss, size) = ((one[k] - other[k]).amax(), one[k].amax().max(10.0));
                    assert!(miss < 1e-14 * size, "{method:?} {t} {k} {miss:e} {size:e}");
                }
            }
        }
    }

    #[test]
    fn jumps_and_corners_stay() {
        let c = [0., 1., 2., 1., 5., 0.].map(|c| Vector::new(c, -c, 0.0)).to_vec();
        let places = vec![0.0, 2.0, 3.0, 4.0];
        let curve = PiecewisePolynomial::new(crate::space::Dimension::Plane, places, 1, c).unwrap();
        let spline = CurveShape::PiecewisePolynomial(curve.clone()).to_b_spline().unwrap();
        assert_eq!(spline.basis().knots(), [0., 0., 2., 3., 3., 4., 4.]);
        for t in [0.0, 1.5, 2.0, 2.5, 3.0, 4.0] {
            assert_eq!(curve.value(t), spline.value(t), "{t}");
        }
        let steps = PiecewisePolynomial::new(curve.dimension(), vec![0.0, 1.0, 2.0], 0, vec![Vector::x(), Vector::y()]);
        let spline = CurveShape::PiecewisePolynomial(steps.unwrap()).to_b_spline().unwrap();
        assert_eq!(spline.value(1.5), Vector::y());
    }

    #[test]
    fn too_high_a_degree_is_refused() {
        let x: Vec<f64> = (0..27).map(f64::from).collect();
        let points = Points::Graph { y: x.clone(), x };
        let shape = shape_through(&points, &Method::Lagrange).unwrap().0;
        assert!(shape.to_b_spline().unwrap_err().to_string().contains("degree 26 is not within"));
    }
}
