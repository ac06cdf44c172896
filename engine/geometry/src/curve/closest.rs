//! The point of a curve that is closest to a given point, of all its branches.
//!
//! Every piece is written in Bernstein's basis; then the squared distance is a ratio N / W² of
//! polynomials in that basis, and N − d² W² has no root where all its coefficients are ≥ 0: such a
//! part of the curve cannot come closer than d. Parts are halved until they are excluded so, while
//! a safeguarded Newton iteration finds the minimum within them; hence no branch is missed. The
//! ends of the curve are points like any other. Polynomials above
//! [`HIGHEST_DEGREE`](crate::space::HIGHEST_DEGREE), which have no such basis here, are
//! sampled densely instead.
//!
//! A graph is taken as the plane curve (x, y(x)).

use super::{
    Curve, CurveShape,
    bernstein::{elevated, halves, product},
    refine::BezierPiece,
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::cancel::{self, Asking};

/// How often a piece is halved while parts are kept that only rounding could still lower.
const EXACT_DEPTH: u32 = 12;
/// How often at all.
const DEEPEST: u32 = 44;
/// Parts that are looked at per point at most.
const MOST_PARTS: usize = 20_000;
/// Samples per condition of a polynomial without Bernstein's basis.
const SAMPLES: usize = 16;
/// Coefficients of squared distances are rounded by about so many times the largest.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The closest point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Parameter of the place on the curve.
    pub parameter: f64,
    /// The point; (x, y, 0) for a graph.
    pub point: Vector,
    /// How far it is.
    pub distance: f64,
    /// The same for a plane curve or graph, below 0 where the given point lies to the right of the
    /// curve's direction. None for space curves and where the curve has no direction.
    pub signed_distance: Option<f64>,
}

/// A curve prepared for many questions.
#[derive(Clone, Debug)]
pub struct Closest<'a> {
    shape: &'a CurveShape,
    pieces: Vec<Piece>,
    /// Parameters to start from where there are no pieces.
    seeds: Vec<f64>,
}

/// One piece in homogeneous Bernstein coefficients.
#[derive(Clone, Debug)]
struct Piece {
    interval: [f64; 2],
    /// w x, w y, w z.
    point: [Vec<f64>; 3],
    weight: Vec<f64>,
    polynomial: bool,
    /// A box around the piece.
    low: Vector,
    high: Vector,
}

/// The best parameter so far, with its squared distance.
#[derive(Clone, Copy)]
struct Best {
    parameter: f64,
    square: f64,
}

impl<'a> Closest<'a> {
    /// Prepares a curve.
    pub fn on(shape: &'a CurveShape) -> Self {
        let graph = shape.dimension() == Dimension::Graph;
        let pieces = shape.to_b_spline().and_then(|spline| spline.bezier_pieces()).unwrap_or_default();
        let pieces: Vec<Piece> = pieces.iter().asking(500).map(|piece| Piece::new(piece, graph)).collect();
        let seeds = if pieces.is_empty() { seeds(shape) } else { Vec::new() };
        Closest { shape, pieces, seeds }
    }

    /// The closest point to `to`, of which a graph and a plane curve read x and y only. `to` is
    /// finite.
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     curve::{Closest, Ends, Method, Points, construct::shape_through},
    ///     space::Vector,
    /// };
    ///
    /// // The straight line y = 2x; the foot of (5, 0) is (1, 2), √20 away.
    /// let points = Points::Graph { x: vec![0.0, 3.0], y: vec![0.0, 6.0] };
    /// let (line, _) = shape_through(&points, &Method::CubicSpline(Ends::not_a_knot()))?;
    /// let foot = Closest::on(&line).to(Vector::new(5.0, 0.0, 0.0));
    /// assert!((foot.point - Vector::new(1.0, 2.0, 0.0)).norm() < 1e-12);
    /// // It lies to the right of the direction in which x grows.
    /// assert!((foot.signed_distance.unwrap() + 20_f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to(&self, to: Vector) -> ClosestPoint {
        let to = if self.shape.dimension() == Dimension::Space { to } else { Vector::new(to.x, to.y, 0.0) };
        let [low, high] = self.shape.domain();
        let mut best = Best { parameter: low, square: f64::INFINITY };
        for end in [low, high] {
            self.consider(&to, end, &mut best);
        }
        let bounds: Vec<f64> = self.pieces.iter().asking(20).map(|piece| piece.nearest_square(&to)).collect();
        let first = (0..bounds.len()).min_by(|a, b| bounds[*a].total_cmp(&bounds[*b]));
        let mut left = MOST_PARTS;
        // the piece whose box is nearest first: it excludes most of the others
        for i in first.into_iter().chain(0..bounds.len()) {
            if bounds[i] <= best.square {
                cancel::checkpoint();
                self.search(&self.pieces[i], &to, &mut best, &mut left);
            }
        }
        for pair in self.seeds.windows(2) {
            self.local(&to, pair[0], pair[1], &mut best);
        }
        self.answer(&to, best)
    }

    fn answer(&self, to: &Vector, best: Best) -> ClosestPoint {
        let point = self.shape.place(best.parameter)[0];
        let distance = (to - point).norm();
        let signed_distance = match self.shape.dimension() {
            Dimension::Space => None,
            _ if distance == 0.0 => Some(0.0),
            _ => self.direction(best.parameter).map(|d| distance.copysign(d.cross(&(to - point)).z)),
        };
        ClosestPoint { parameter: best.parameter, point, distance, signed_distance }
    }

    /// The direction at `t`, at a corner the mean of both.
    fn direction(&self, t: f64) -> Option<Vector> {
        let [low, high] = self.shape.domain();
        let unit = |t: f64| self.shape.place(t)[1].try_normalize(0.0);
        let mean = unit(t.next_down().max(low))? + unit(t.min(high))?;
        mean.try_normalize(0.0)
    }

    /// Half the derivative of the squared distance, and that derivative's own.
    fn slope(&self, to: &Vector, t: f64) -> (f64, f64) {
        let [point, first, second, _] = self.shape.place(t);
        let away = point - to;
        (away.dot(&first), first.dot(&first) + away.dot(&second))
    }

    fn consider(&self, to: &Vector, t: f64, best: &mut Best) -> f64 {
        let place = if self.shape.dimension() == Dimension::Graph {
            Vector::new(t, self.shape.value(t).x, 0.0)
        } else {
            self.shape.value(t)
        };
        let square = (place - to).norm_squared();
        if square < best.square {
            *best = Best { parameter: t, square };
        }
        square
    }

    /// Considers the ends of a part of a smooth piece and, where the distance falls at its start
    /// and grows at its end, a minimum between by Newton's iteration held within a bracket; returns
    /// the squared distance there.
    fn local(&self, to: &Vector, low: f64, high: f64, best: &mut Best) -> Option<f64> {
        self.consider(to, low, best);
        self.consider(to, high, best);
        // the derivative at the right end is that of this piece
        let (mut a, mut b) = (low, high.next_down().max(low));
        if !(self.slope(to, a).0 < 0.0 && self.slope(to, b).0 > 0.0) {
            return None;
        }
        let mut t = 0.5 * a + 0.5 * b;
        for _ in 0..100 {
            let (slope, curvature) = self.slope(to, t);
            if slope == 0.0 {
                break;
            }
            if slope < 0.0 {
                a = t
            } else {
                b = t
            }
            let newton = t - slope / curvature;
            let next = if a < newton && newton < b { newton } else { 0.5 * a + 0.5 * b };
            if next == t || !(a < next && next < b) {
                break;
            }
            t = next;
        }
        Some(self.consider(to, t, best))
    }

    /// Excludes or searches all of a piece.
    fn search(&self, piece: &Piece, to: &Vector, best: &mut Best, left: &mut usize) {
        let (square, weight) = piece.squared_distance(to);
        let noise = ROUNDING * square.iter().fold(0.0f64, |m, n| m.max(n.abs()));
        let [low, high] = piece.interval;
        let mut waiting = vec![(square, weight, low, high, 0)];
        while let Some((square, weight, low, high, depth)) = waiting.pop() {
            cancel::checkpoint();
            let slack = if depth <= EXACT_DEPTH { 0.0 } else { noise };
            let excluded = |best: &Best| square.iter().zip(&weight).all(|(n, w)| n - best.square * w >= -slack);
            if excluded(best) || *left == 0 {
                continue;
            }
            *left -= 1;
            let found = self.local(to, low, high, best);
            let convex = square.windows(3).zip(weight.windows(3)).all(|(n, w)| {
                let bend = |x: &[f64]| x[0] - 2.0 * x[1] + x[2];
                bend(n) - best.square * bend(w) >= 0.0
            });
            let middle = 0.5 * low + 0.5 * high;
            // A convex function has one minimum. That of a polynomial piece has been found; a
            // rational one has its best there only if N − d² W² touches 0 at a place where it does
            // not slope.
            let settled = convex && (piece.polynomial || found.is_some_and(|square| square <= best.square));
            if settled || excluded(best) || depth == DEEPEST || !(low < middle && middle < high) {
                continue;
            }
            let ([square_left, square_right], [weight_left, weight_right]) = (halves(&square), halves(&weight));
            waiting.push((square_right, weight_right, middle, high, depth + 1));
            waiting.push((square_left, weight_left, low, middle, depth + 1));
        }
    }
}

/// Places dense enough for a polynomial of high degree, denser towards the ends as its waves are.
fn seeds(shape: &CurveShape) -> Vec<f64> {
    let count = match shape {
        CurveShape::Polynomial(polynomial) => SAMPLES * polynomial.conditions(),
        _ => SAMPLES * shape.breaks().len(),
    };
    let [low, high] = shape.domain();
    let place = |i: usize| {
        let part = (i as f64 / count as f64 * std::f64::consts::FRAC_PI_2).sin().powi(2);
        low * (1.0 - part) + high * part
    };
    (0..=count).map(place).collect()
}

impl Piece {
    fn new(piece: &BezierPiece, graph: bool) -> Self {
        let weighted =
            |k: usize| -> Vec<f64> { piece.control_points.iter().zip(&piece.weights).map(|(p, w)| p[k] * w).collect() };
        let (mut point, mut weight) = ([weighted(0), weighted(1), weighted(2)], piece.weights.clone());
        if graph {
            // (t, y(t)), of one degree more
            point = [product(&piece.interval, &weight), elevated(&point[0]), vec![0.0; weight.len() + 1]];
            weight = elevated(&weight);
        }
        let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        for i in (0..weight.len()).filter(|i| weight[*i] > 0.0) {
            let corner = Vector::new(point[0][i], point[1][i], point[2][i]) / weight[i];
            (low, high) = (low.inf(&corner), high.sup(&corner));
        }
        let polynomial = weight.iter().all(|w| *w == weight[0]);
        Piece { interval: piece.interval, point, weight, polynomial, low, high }
    }

    /// A lower bound of the squared distance: that of the box.
    fn nearest_square(&self, to: &Vector) -> f64 {
        let zero = Vector::zeros();
        let bound = (self.low - to).sup(&(to - self.high)).sup(&zero).norm_squared();
        // the box is rounded
        bound * (1.0 - ROUNDING)
    }

    /// The coefficients of `|w (C − to)|²` and of `w²`.
    fn squared_distance(&self, to: &Vector) -> (Vec<f64>, Vec<f64>) {
        let mut square = vec![0.0; 2 * self.weight.len() - 1];
        for k in 0..3 {
            let away: Vec<f64> = self.point[k].iter().zip(&self.weight).map(|(p, w)| p - to[k] * w).collect();
            square.iter_mut().zip(product(&away, &away)).for_each(|(s, x)| *s += x);
        }
        (square, product(&self.weight, &self.weight))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BSplineBasis;
    use crate::curve::{BSplineCurve, Ends, Method, Points, construct::shape_through};

    fn circle() -> CurveShape {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.]).unwrap();
        let corners = [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
        let points = corners.map(|[x, y]| Vector::new(x, y, 0.0)).to_vec();
        let weights = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { 0.5f64.sqrt() }).collect();
        CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Plane, points, Some(weights)).unwrap())
    }

    #[test]
    fn a_circle_inside_and_outside() {
        let circle = circle();
        let closest = Closest::on(&circle);
        for i in 0..50 {
            let angle = f64::from(i) * 0.37;
            for radius in [1e-3, 0.4, 1.0 - 1e-9, 1.7, 1e3] {
                let direction = Vector::new(angle.cos(), angle.sin(), 0.0);
                let answer = closest.to(direction * radius);
                assert!(
                    (answer.point - direction).norm() < 4e-8f64.min(1e-15 / radius.min(1e-1) * 50.0),
                    "{angle} {radius}"
                );
                assert!((answer.signed_distance.unwrap() - (1.0 - radius)).abs() < 1e-15 * (1.0 + radius));
            }
        }
        // every point is as near
        assert!((closest.to(Vector::zeros()).distance - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_graph_with_two_branches_and_ends() {
        // y = x² over [−1, 2]: from (0, b) with b > ½ the feet are ±√(b − ½)
        let shape =
            shape_through(&Points::Graph { x: vec![-1.0, 0.0, 2.0], y: vec![1.0, 0.0, 4.0] }, &Method::Lagrange);
        let shape = shape.unwrap().0;
        let closest = Closest::on(&shape);
        let answer = closest.to(Vector::new(1e-6, 1.0, 0.0));
        assert!((answer.parameter - 0.5f64.sqrt()).abs() < 1e-5 && answer.signed_distance.unwrap() > 0.0);
        assert!((closest.to(Vector::new(-1e-6, 1.0, 0.0)).parameter + 0.5f64.sqrt()).abs() < 1e-5);
        let end = closest.to(Vector::new(3.0, 5.0, 7.0));
        assert_eq!((end.parameter, end.distance), (2.0, 2f64.sqrt()));
        assert!(closest.to(Vector::new(0.5, 0.0, 0.0)).signed_distance.unwrap() < 0.0);
        assert!(closest.to(Vector::new(0.5, 0.25, 0.0)).distance < 1e-16);
    }

    /// Never beaten by dense sampling, also above the degree that has a Bernstein basis here.
    #[test]
    fn waves() {
        let nodes = |n: i32| (0..n).map(move |i| 3.0 * (f64::from(i) - f64::from(n) / 2.0 + 0.5) / f64::from(n));
        for (n, method) in [(40, Method::Lagrange), (25, Method::CubicSpline(Ends::natural())), (26, Method::Lagrange)]
        {
            // the nodes of Chebyshev, squeezed a little
            let x: Vec<f64> = nodes(n).map(|s| 1.5 * (s * std::f64::consts::FRAC_PI_3).sin()).collect();
            let y = x.iter().map(|x| 0.4 * (9.0 * x).sin()).collect();
            let shape = shape_through(&Points::Graph { x, y }, &method).unwrap().0;
            let closest = Closest::on(&shape);
            let [low, high] = shape.domain();
            for i in 0..40 {
                let to = Vector::new(1.8 * (f64::from(i) * 0.7).sin(), 0.8 * (f64::from(i) * 1.3).cos(), 0.0);
                let answer = closest.to(to);
                for j in 0..=4000 {
                    let t = low + (high - low) * f64::from(j) / 4000.0;
                    let sampled = (shape.place(t)[0] - to).norm();
                    assert!(answer.distance <= sampled * (1.0 + 1e-14) + 1e-15, "{n} {i} {t}");
                }
            }
        }
    }

    #[test]
    fn a_corner_has_a_side() {
        let points = Points::Space {
            points: [[0., 0.], [1., 0.], [1., 1.]].map(|[x, y]| Vector::new(x, y, 0.0)).to_vec(),
            dimension: Dimension::Plane,
            parametrization: crate::curve::Parametrization::Uniform,
        };
        let knots = crate::curve::KnotChoice::Averaging;
        let shape = shape_through(&points, &Method::BSpline { degree: 1, knots }).unwrap().0;
        let closest = Closest::on(&shape);
        let outside = closest.to(Vector::new(2.0, -1.0, 0.0));
        assert_eq!((outside.parameter, outside.signed_distance), (0.5, Some(-(2f64.sqrt()))));
        assert!((closest.to(Vector::new(0.5, 0.25, 0.0)).signed_distance.unwrap() - 0.25).abs() < 1e-16);
    }
}
