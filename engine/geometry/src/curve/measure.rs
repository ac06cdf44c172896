//! Curvature, torsion and arc length: what follows from the jet of any curve.
//!
//! A graph is measured as the plane curve (x, y(x)): x and y count in one unit.

use super::{Curve, check};
use flankfit_numerics::{cancel, check::Faults, sum2};
use std::collections::VecDeque;

/// The relative error that an arc length is computed to, by default.
pub const DEFAULT_TOLERANCE: f64 = 1e-12;

/// Parts of one call at most, in addition to the smooth pieces.
pub const MOST_PARTS: usize = 10_000;

/// A derivative by the parameter is taken to be right to this part of the largest place over the
/// width of the smooth piece: rounding of the places alone makes that much of it.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Bending of a curve at one place. None where the derivative is 0, so that it has no direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bending {
    /// Per unit of length: of a graph or plane curve above 0 where it turns left, of a space curve
    /// never below 0.
    pub curvature: Option<f64>,
    /// Per unit of length, of a space curve that is not straight there.
    pub torsion: Option<f64>,
}

/// Curvature and torsion at `t`.
///
/// ```
/// use flankfit_geometry::curve::{Method, Points, bending, construct::shape_through};
///
/// // y = x² turns left with curvature 2 at its vertex, and with 2/√125 where the slope is 2.
/// let points = Points::Graph { x: vec![-1.0, 0.0, 1.0], y: vec![1.0, 0.0, 1.0] };
/// let (parabola, _) = shape_through(&points, &Method::Newton)?;
/// assert_eq!(bending(&parabola, 0.0).curvature, Some(2.0));
/// assert!((bending(&parabola, 1.0).curvature.unwrap() - 2.0 / 125_f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn bending(curve: &(impl Curve + ?Sized), t: f64) -> Bending {
    let [_, first, second, third] = curve.place(t);
    let speed = first.norm();
    let cross = first.cross(&second);
    let space = curve.dimension().count() == 3;
    let size = if space { cross.norm() } else { cross.z };
    let finite = |x: f64| x.is_finite().then_some(x);
    Bending {
        curvature: finite(size / speed / speed / speed),
        torsion: if space { finite(cross.dot(&third) / size / size) } else { None },
    }
}

/// A length and a bound on its error, both in the unit of the coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcLength {
    /// Length of the arc.
    pub length: f64,
    /// Error of quadrature, and of the rounding of the places.
    pub error: f64,
    /// Whether the error is within the tolerance asked for. It is not where the curve is short
    /// against its distance from the origin, and where the parts that a call may make do not
    /// suffice.
    pub converged: bool,
}

/// The length of the curve from `from` to `to` (below 0 where `to` lies before `from`), by
/// Gauss–Kronrod quadrature of 7 and 15 points per smooth piece, halved until the estimated error
/// is below `tolerance` times the length or below what rounding of the places makes, at most
/// [`MOST_PARTS`] times. Refused outside of the domain.
///
/// ```
/// use flankfit_geometry::curve::{Method, Points, arc_length, construct::shape_through};
///
/// // The parabola y = x² from 0 to 1: √5/2 + asinh(2)/4.
/// let points = Points::Graph { x: vec![-1.0, 0.0, 1.0], y: vec![1.0, 0.0, 1.0] };
/// let (parabola, _) = shape_through(&points, &Method::Newton)?;
/// let measured = arc_length(&parabola, 0.0, 1.0, 1e-12)?;
/// let exact = 0.5 * 5_f64.sqrt() + 0.25 * 2_f64.asinh();
/// assert!(measured.converged && (measured.length - exact).abs() <= measured.error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn arc_length(curve: &(impl Curve + ?Sized), from: f64, to: f64, tolerance: f64) -> Result<ArcLength, Faults> {
    let mut parts = MOST_PARTS;
    part_length(curve, &curve.breaks(), [from, to], tolerance, &mut parts)
}

/// The lengths from the start of the domain to each of `at`, in that order, and last the whole
/// length; errors add up along the way. All of them together make no more than [`MOST_PARTS`] parts
/// in addition to one for each piece between the places.
pub fn arc_lengths(
    curve: &(impl Curve + ?Sized),
    at: &[f64],
    tolerance: f64,
) -> Result<(Vec<ArcLength>, ArcLength), Faults> {
    let ([low, high], breaks) = (curve.domain(), curve.breaks());
    let mut order: Vec<usize> = (0..at.len()).collect();
    order.sort_by(|a, b| at[*a].total_cmp(&at[*b]));
    let mut parts = MOST_PARTS;
    let mut sum = ArcLength { length: 0.0, error: 0.0, converged: true };
    let mut lengths = vec![sum; at.len()];
    let mut reached = low;
    for place in order.into_iter().map(Some).chain([None]) {
        cancel::checkpoint();
        let to = place.map_or(high, |place| at[place]);
        let step = part_length(curve, &breaks, [reached, to], tolerance, &mut parts)?;
        sum.length += step.length;
        sum.error += step.error;
        sum.converged = sum.error <= allowance(tolerance) * sum.length;
        reached = to;
        if let Some(place) = place {
            lengths[place] = sum;
        }
    }
    Ok((lengths, sum))
}

/// No sum of rounded numbers is better than a few units in the last place.
fn allowance(tolerance: f64) -> f64 {
    tolerance.max(16.0 * f64::EPSILON)
}

/// A part of a smooth piece of the curve.
struct Segment {
    ends: [f64; 2],
    /// The width of the piece.
    piece: f64,
    estimate: Estimate,
}

impl Segment {
    fn new(curve: &(impl Curve + ?Sized), ends: [f64; 2], piece: f64) -> Self {
        Segment { ends, piece, estimate: estimate(curve, ends[0], ends[1]) }
    }

    /// Effect of the rounding of the places on its length.
    fn noise(&self) -> f64 {
        let share = (self.ends[1] - self.ends[0]) / self.piece;
        ROUNDING * self.estimate.farthest * share + 8.0 * f64::EPSILON * self.estimate.value
    }
}

/// One length; what it halves is taken off `halvings`.
fn part_length(
    curve: &(impl Curve + ?Sized),
    breaks: &[f64],
    [from, to]: [f64; 2],
    tolerance: f64,
    halvings: &mut usize,
) -> Result<ArcLength, Faults> {
    let [low, high] = curve.domain();
    if let Some(value) = [from, to].into_iter().find(|t| !(low <= *t && *t <= high)) {
        return Err(check::out_of_domain(value, low, high));
    }
    let (start, end) = (from.min(to), from.max(to));
    if start == end {
        return Ok(ArcLength { length: 0.0, error: 0.0, converged: true });
    }
    // level by level, so that what is left when the halvings are used up is spread over the curve
    let first = breaks.partition_point(|place| *place <= start).saturating_sub(1);
    let mut waiting: VecDeque<Segment> = breaks[first..]
        .windows(2)
        .take_while(|piece| piece[0] < end)
        .map(|piece| Segment::new(curve, [piece[0].max(start), piece[1].min(end)], piece[1] - piece[0]))
        .collect();
    let total: f64 = waiting.iter().map(|part| part.estimate.value).sum();
    // every part may err as much as its share of the parameter
    let allowed = tolerance.max(4.0 * f64::EPSILON) * total / (end - start);
    let (mut values, mut errors, mut noises) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(part) = waiting.pop_front() {
        cancel::checkpoint();
        let ([a, b], error) = (part.ends, part.estimate.error);
        let middle = 0.5 * a + 0.5 * b;
        let done = error <= allowed * (b - a) || error <= part.noise();
        if done || *halvings == 0 || !(a < middle && middle < b) {
            values.push(part.estimate.value);
            errors.push(error);
            noises.push(part.noise());
        } else {
            *halvings -= 1;
            waiting.extend([[a, middle], [middle, b]].map(|ends| Segment::new(curve, ends, part.piece)));
        }
    }
    let length = sum2(&values).to_f64();
    // what rounds here does so independently of what rounds there
    let noise = noises.iter().map(|n| n * n).sum::<f64>().sqrt();
    let error = errors.iter().sum::<f64>() + noise + 2.0 * f64::EPSILON * length;
    let converged = error <= allowance(tolerance) * length;
    Ok(ArcLength { length: length * (to - from).signum(), error, converged })
}

struct Estimate {
    value: f64,
    error: f64,
    /// The largest coordinate of the places looked at.
    farthest: f64,
}

/// Places and weights of 15 points on [-1, 1] for the places ≥ 0, and the weights of the 7 of them
/// that are Gauss's.
const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_56, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
];

/// The integral of the speed over one part of a smooth piece. The error is estimated as in
/// QUADPACK: the difference of the two rules, raised to the power that their orders differ by.
fn estimate(curve: &(impl Curve + ?Sized), low: f64, high: f64) -> Estimate {
    let (center, half) = (0.5 * low + 0.5 * high, 0.5 * (high - low));
    let mut farthest = 0.0f64;
    let mut speed = |t: f64| {
        let [place, first, ..] = curve.place(t);
        farthest = farthest.max(place.amax());
        first.norm()
    };
    let mut samples = [[0.0; 2]; 8];
    let (mut kronrod, mut gauss) = (0.0, 0.0);
    for (sample, (x, long, short)) in samples.iter_mut().zip(KRONROD) {
        *sample = if x == 0.0 { [speed(center), 0.0] } else { [speed(center - half * x), speed(center + half * x)] };
        let sum = sample[0] + sample[1];
        kronrod += long * sum;
        gauss += short * sum;
    }
    let mean = 0.5 * kronrod;
    let spread: f64 = samples
        .iter()
        .zip(KRONROD)
        .map(|(s, (x, long, _))| long * ((s[0] - mean).abs() + if x == 0.0 { 0.0 } else { (s[1] - mean).abs() }))
        .sum();
    let difference = (kronrod - gauss).abs();
    let error = if spread > 0.0 { spread * (200.0 * difference / spread).powf(1.5).min(1.0) } else { difference };
    Estimate { value: kronrod * half, error: error * half, farthest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BSplineBasis;
    use crate::curve::{BSplineCurve, PiecewisePolynomial};
    use crate::space::{Dimension, Vector};

    #[test]
    fn the_two_rules_integrate_powers() {
        for power in 0..23 {
            let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
            let sum = |pick: fn(&(f64, f64, f64)) -> f64| -> f64 {
                let both = |x: f64| if x == 0.0 { x.powi(power) } else { x.powi(power) + (-x).powi(power) };
                KRONROD.iter().map(|k| pick(k) * both(k.0)).sum()
            };
            assert!((sum(|k| k.1) - exact).abs() < 1e-15, "{power}");
            assert!(power > 13 || (sum(|k| k.2) - exact).abs() < 1e-15, "{power}");
        }
    }

    fn quarter(radius: f64) -> BSplineCurve {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).unwrap();
        let points = [[1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| Vector::new(x, y, 0.0) * radius).to_vec();
        BSplineCurve::new(basis, Dimension::Plane, points, Some(vec![1.0, 0.5f64.sqrt(), 1.0])).unwrap()
    }

    #[test]
    fn a_circle() {
        let arc = quarter(3.0);
        let length = arc_length(&arc, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap();
        let exact = 1.5 * std::f64::consts::PI;
        assert!((length.length - exact).abs() <= length.error && length.error < 1e-11, "{length:?}");
        assert_eq!(arc_length(&arc, 1.0, 0.0, 1e-12).unwrap().length, -length.length);
        assert_eq!(arc_length(&arc, 0.5, 0.5, 1e-12).unwrap().length, 0.0);
        assert!(arc_length(&arc, 0.0, 1.5, 1e-12).is_err());
        for t in [0.0, 0.3, 1.0] {
            let bending = bending(&arc, t);
            assert!((bending.curvature.unwrap() - 1.0 / 3.0).abs() < 1e-15 && bending.torsion.is_none());
        }
    }

    /// Curves whose speed is mostly or wholly rounding: answered in bounded time, with the error
    /// that rounding leaves.
    #[test]
    fn where_rounding_hides_the_speed() {
        let basis = |knots: &[f64]| BSplineBasis::new(3, knots.to_vec()).unwrap();
        let knots = [0., 0., 0., 0., 0.3, 0.7, 1., 1., 1., 1.];
        let point = Vector::new(0.1, 0.7, 1e3 / 3.0);
        let weights = Some(vec![1.0, 0.3, 0.7, 2.0, 1.1, 0.9]);
        let still = BSplineCurve::new(basis(&knots), Dimension::Space, vec![point; 6], weights).unwrap();
        let found = arc_length(&still, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap();
        assert!(found.length.abs() <= found.error && found.error < 1e-10, "{found:?}");

        let half = 0.5f64.sqrt();
        let far = |x: f64, y: f64| Vector::new(1e6 + x, 1e6 + y, 0.0);
        let corners = [(1., 0.), (1., 1.), (0., 1.), (-1., 1.), (-1., 0.), (-1., -1.), (0., -1.), (1., -1.), (1., 0.)];
        let points = corners.map(|(x, y)| far(x, y)).to_vec();
        let weights = Some(vec![1.0, half, 1.0, half, 1.0, half, 1.0, half, 1.0]);
        let knots = vec![0., 0., 0., 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1., 1., 1.];
        let circle =
            BSplineCurve::new(BSplineBasis::new(2, knots).unwrap(), Dimension::Plane, points, weights).unwrap();
        let found = arc_length(&circle, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap();
        let off = (found.length - std::f64::consts::TAU).abs();
        assert!(off <= found.error && found.error < 1e-7 && !found.converged, "{found:?}");

        let points = [0.0, 1.1e-3, 1.7e-3, 3e-3].map(|x| Vector::new(1000.0 + x, 0.0, 0.0)).to_vec();
        let tiny = BSplineCurve::new(basis(&[0., 0., 0., 0., 1., 1., 1., 1.]), Dimension::Plane, points, None).unwrap();
        let found = arc_length(&tiny, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap();
        assert!((found.length - 3e-3).abs() <= found.error && found.error < 1e-10 && !found.converged, "{found:?}");
    }

    /// One budget for all lengths of a call; and they are the lengths one by one.
    #[test]
    fn many_lengths_at_once() {
        let arc = quarter(3.0);
        assert!(arc_length(&arc, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap().converged);
        let at = [0.75, 0.0, 0.25, 1.0, 0.25];
        let (lengths, whole) = arc_lengths(&arc, &at, DEFAULT_TOLERANCE).unwrap();
        for (t, found) in at.iter().zip(&lengths) {
            let exact = arc_length(&arc, 0.0, *t, DEFAULT_TOLERANCE).unwrap().length;
            assert!((found.length - exact).abs() <= found.error && found.converged, "{t}");
        }
        assert_eq!((whole.length, lengths[2].length), (lengths[3].length, lengths[4].length));
        assert!(arc_lengths(&arc, &[1.5], DEFAULT_TOLERANCE).is_err());
    }

    fn curve(dimension: Dimension, c: &[[f64; 3]]) -> PiecewisePolynomial {
        let c: Vec<Vector> = c.iter().map(|c| Vector::new(c[0], c[1], c[2])).collect();
        PiecewisePolynomial::new(dimension, vec![0.0, 2.0], c.len() - 1, c).unwrap()
    }

    /// (t, t², 2t³/3): curvature and torsion are both 2 / (1 + 2t²)², the length is t + 2t³/3.
    #[test]
    fn a_space_cubic() {
        let cubic = curve(Dimension::Space, &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 2.0 / 3.0]]);
        for t in [0.0f64, 0.5, 1.7] {
            let exact = 2.0 / (1.0 + 2.0 * t * t).powi(2);
            let bending = bending(&cubic, t);
            assert!((bending.curvature.unwrap() - exact).abs() < 1e-15);
            assert!((bending.torsion.unwrap() - exact).abs() < 1e-15);
        }
        let length = arc_length(&cubic, 0.0, 1.5, DEFAULT_TOLERANCE).unwrap();
        assert!((length.length - 3.75).abs() < 1e-14);
        let line = curve(Dimension::Space, &[[0., 0., 0.], [1., 2., 2.]]);
        assert_eq!(bending(&line, 1.0), Bending { curvature: Some(0.0), torsion: None });
        assert_eq!(arc_length(&line, 0.0, 2.0, 1e-12).unwrap().length, 6.0);
        let point = curve(Dimension::Space, &[[1., 1., 1.]]);
        assert_eq!(bending(&point, 1.0), Bending { curvature: None, torsion: None });
        assert_eq!(arc_length(&point, 0.0, 2.0, 1e-12).unwrap().length, 0.0);
    }

    /// A cusp, (t², t³) shifted to t = 1: 2 (13√13 − 8)/27, in spite of the corner of the speed.
    #[test]
    fn a_cusp() {
        let c = [[1., -1., 0.], [-2., 3., 0.], [1., -3., 0.], [0., 1., 0.]];
        let length = arc_length(&curve(Dimension::Plane, &c), 0.0, 2.0, DEFAULT_TOLERANCE).unwrap();
        let exact = 2.0 * (13.0 * 13f64.sqrt() - 8.0) / 27.0;
        assert!((length.length - exact).abs() < 1e-12, "{length:?} {exact}");
    }

    #[test]
    fn a_graph_bends_to_the_left_where_it_is_convex() {
        let parabola = curve(Dimension::Graph, &[[0., 0., 0.], [0., 0., 0.], [1., 0., 0.]]);
        assert_eq!(bending(&parabola, 0.0).curvature, Some(2.0));
        let exact = 17f64.sqrt() + 0.25 * (4.0 + 17f64.sqrt()).ln();
        assert!((arc_length(&parabola, 0.0, 2.0, 1e-12).unwrap().length - exact).abs() < 1e-14);
    }
}
