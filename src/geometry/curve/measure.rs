//! Curvature, torsion and arc length: what follows from the jet of any curve.
//!
//! A graph is measured as the plane curve (x, y(x)): x and y count in one unit.

use super::{Curve, CurveFault};

/// The relative error that an arc length is computed to, if nobody asks for another.
pub const DEFAULT_TOLERANCE: f64 = 1e-12;

/// How often a smooth piece is halved at most.
const DEEPEST: u32 = 40;

/// How a curve bends at one place. None where the curve stands still, so that it has no direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bending {
    /// Per unit of length: of a graph or plane curve above 0 where it turns left, of a space curve never below 0.
    pub curvature: Option<f64>,
    /// Per unit of length, of a space curve that is not straight there.
    pub torsion: Option<f64>,
}

/// Curvature and torsion at `t`.
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
    pub length: f64,
    pub error: f64,
}

/// The length of the curve from `from` to `to` (below 0 where `to` lies before `from`), by Gauss–Kronrod quadrature of 7 and 15 points
/// per smooth piece, halved until the estimated error is below `tolerance` times the length. Refused outside of the domain.
pub fn arc_length(curve: &(impl Curve + ?Sized), from: f64, to: f64, tolerance: f64) -> Result<ArcLength, CurveFault> {
    let [low, high] = curve.domain();
    if let Some(value) = [from, to].into_iter().find(|t| !(low <= *t && *t <= high)) {
        return Err(CurveFault::OutOfDomain { value, low, high });
    }
    let (start, end) = (from.min(to), from.max(to));
    let mut places = vec![start];
    places.extend(curve.breaks().into_iter().filter(|b| start < *b && *b < end));
    places.push(end);
    let rough: Vec<Estimate> = places.windows(2).map(|p| estimate(curve, p[0], p[1])).collect();
    let total: f64 = rough.iter().map(|e| e.value).sum();
    // every piece may err as much as its share of the parameter
    let allowed = tolerance.max(4.0 * f64::EPSILON) * total / (end - start);
    let mut sum = ArcLength { length: 0.0, error: 0.0 };
    for (piece, rough) in places.windows(2).zip(rough) {
        let mut waiting = vec![(piece[0], piece[1], rough, 0)];
        while let Some((a, b, here, depth)) = waiting.pop() {
            let middle = 0.5 * a + 0.5 * b;
            let done = here.error <= allowed * (b - a) || here.error <= 8.0 * f64::EPSILON * here.value;
            if done || depth == DEEPEST || !(a < middle && middle < b) {
                sum.length += here.value;
                sum.error += here.error;
            } else {
                waiting.push((middle, b, estimate(curve, middle, b), depth + 1));
                waiting.push((a, middle, estimate(curve, a, middle), depth + 1));
            }
        }
    }
    // the sum rounds as well
    sum.error += 2.0 * f64::EPSILON * sum.length;
    sum.length *= (to - from).signum();
    Ok(sum)
}

struct Estimate {
    value: f64,
    error: f64,
}

/// Places and weights of 15 points on [-1, 1] for the places ≥ 0, and the weights of the 7 of them that are Gauss's.
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

/// The integral of the speed over one part of a smooth piece. The error is estimated as in QUADPACK: the difference of the two rules,
/// raised to the power that their orders differ by.
fn estimate(curve: &(impl Curve + ?Sized), low: f64, high: f64) -> Estimate {
    let (center, half) = (0.5 * low + 0.5 * high, 0.5 * (high - low));
    let speed = |t: f64| curve.place(t)[1].norm();
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
    Estimate { value: kronrod * half, error: error * half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::BSplineBasis;
    use crate::geometry::curve::{BSplineCurve, PiecewisePolynomial};
    use crate::geometry::space::{Dimension, Vector};

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
