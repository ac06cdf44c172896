//! The rules that read tangents from the data of a piecewise cubic Hermite curve.
//!
//! In one coordinate: `d[i]` is the secant from node i to node i + 1, `h[i]` its width. Two nodes
//! have one secant, which is the slope at both.

use crate::space::Vector;
use flankfit_numerics::Dd;

/// Source of the tangents at the nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum Tangents {
    /// One derivative by the parameter per node.
    Given(Vec<Vector>),
    /// The mean of the two secants at a node; the one secant at an end.
    FiniteDifference,
    /// The secant between the two neighbours of a node; the one secant at an end.
    CatmullRom,
    /// The slope of the parabola through a node and its neighbours (Bessel); at an end of the
    /// parabola through the last three.
    Parabola,
    /// Never an overshoot: 0 at local extremes of the data, else the weighted harmonic mean of the
    /// secants (Fritsch and Butland 1984), which lies in the region of Fritsch and Carlson; at the
    /// ends three points with their limiter.
    Monotone,
    /// Akima (1970): the mean of the secants, each weighted by how straight the data run on the
    /// other side; two secants more at each end by extrapolation.
    Akima,
    /// The same with weights that also count the size of the secants, so that flat runs stay flat
    /// without a jump of the rule.
    ModifiedAkima,
}

impl Tangents {
    /// Whether the curve is linear in the values, so that errors of measurement are amplified by a
    /// fixed factor.
    pub fn is_linear(&self) -> bool {
        !matches!(self, Tangents::Monotone | Tangents::Akima | Tangents::ModifiedAkima)
    }
}

/// A change of slope below this part of the slopes themselves is rounding of the data, for Akima's
/// rule.
const STRAIGHT: f64 = 16.0 * f64::EPSILON;

/// The secants between neighbouring nodes, coordinate by coordinate.
pub(super) fn secants(nodes: &[f64], values: &[Vector]) -> Vec<[Dd; 3]> {
    let secant = |i: usize| {
        let width = Dd::diff(nodes[i + 1], nodes[i]);
        [0, 1, 2].map(|k| Dd::diff(values[i + 1][k], values[i][k]) / width)
    };
    (0..nodes.len() - 1).map(secant).collect()
}

/// One slope per node, coordinate by coordinate. Given tangents are not this function's: they count
/// as [`Tangents::Parabola`].
pub(super) fn slopes(rule: &Tangents, nodes: &[f64], values: &[Vector]) -> Vec<[Dd; 3]> {
    let widths: Vec<Dd> = nodes.windows(2).map(|x| Dd::diff(x[1], x[0])).collect();
    let secants = secants(nodes, values);
    let mut slopes = vec![[Dd::ZERO; 3]; nodes.len()];
    for k in 0..3 {
        let d: Vec<Dd> = secants.iter().map(|s| s[k]).collect();
        let one = in_one_coordinate(rule, &widths, &d);
        slopes.iter_mut().zip(one).for_each(|(s, m)| s[k] = m);
    }
    slopes
}

fn in_one_coordinate(rule: &Tangents, h: &[Dd], d: &[Dd]) -> Vec<Dd> {
    let last = d.len();
    if last == 1 {
        return vec![d[0]; 2];
    }
    let by = |end: fn(Dd, Dd, Dd, Dd) -> Dd, inner: &dyn Fn(usize) -> Dd| {
        let node = |i: usize| match i {
            0 => end(h[0], h[1], d[0], d[1]),
            i if i == last => end(h[last - 1], h[last - 2], d[last - 1], d[last - 2]),
            i => inner(i),
        };
        (0..=last).map(node).collect::<Vec<Dd>>()
    };
    match rule {
        Tangents::FiniteDifference => by(|_, _, d, _| d, &|i| (d[i - 1] + d[i]).scale_pow2(0.5)),
        Tangents::CatmullRom => by(|_, _, d, _| d, &|i| (d[i - 1] * h[i - 1] + d[i] * h[i]) / (h[i - 1] + h[i])),
        Tangents::Parabola | Tangents::Given(_) => {
            by(parabola_end, &|i| (d[i - 1] * h[i] + d[i] * h[i - 1]) / (h[i - 1] + h[i]))
        }
        Tangents::Monotone => by(monotone_end, &|i| harmonic(h[i - 1], h[i], d[i - 1], d[i])),
        Tangents::Akima => akima(d, |a, b| (b - a).abs()),
        Tangents::ModifiedAkima => akima(d, |a, b| (b - a).abs() + (a + b).abs().scale_pow2(0.5)),
    }
}

/// The slope at the end of the parabola through the end node and the next two; `h` and `d` are of
/// the end span, the others of the next.
fn parabola_end(h: Dd, next_h: Dd, d: Dd, next_d: Dd) -> Dd {
    ((h + h + next_h) * d - h * next_d) / (h + next_h)
}

/// The same, but of the sign of the end secant, and at most three times as steep where the data
/// turn.
fn monotone_end(h: Dd, next_h: Dd, d: Dd, next_d: Dd) -> Dd {
    let slope = parabola_end(h, next_h, d, next_d);
    if sign(slope) != sign(d) {
        Dd::ZERO
    } else if sign(d) != sign(next_d) && slope.abs() > d.abs() * 3.0 {
        d * 3.0
    } else {
        slope
    }
}

/// The harmonic mean of two secants of one sign, the one of the shorter span weighing more.
fn harmonic(h: Dd, next_h: Dd, d: Dd, next_d: Dd) -> Dd {
    if sign(d) * sign(next_d) <= 0 {
        return Dd::ZERO;
    }
    let (left, right) = (next_h + next_h + h, next_h + h + h);
    (left + right) / (left / d + right / next_d)
}

fn sign(x: Dd) -> i8 {
    i8::from(x.hi > 0.0) - i8::from(x.hi < 0.0)
}

/// Akima's slopes, with `change` measuring how much the slope changes from one secant to the next.
fn akima(d: &[Dd], change: impl Fn(Dd, Dd) -> Dd) -> Vec<Dd> {
    let n = d.len();
    let before = d[0] + d[0] - d[1];
    let after = d[n - 1] + d[n - 1] - d[n - 2];
    let mut m = vec![before + before - d[0], before];
    m.extend_from_slice(d);
    m.extend([after, after + after - d[n - 1]]);
    let node = |i: usize| {
        let (left, right) = (change(m[i + 2], m[i + 3]), change(m[i], m[i + 1]));
        let sum = left + right;
        let size = m[i..i + 4].iter().fold(0.0, |s: f64, m| s + m.abs().hi);
        if sum.hi <= STRAIGHT * size {
            return (m[i + 1] + m[i + 2]).scale_pow2(0.5);
        }
        (left * m[i + 1] + right * m[i + 2]) / sum
    };
    (0..=n).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(rule: Tangents, x: &[f64], y: &[f64]) -> Vec<f64> {
        let values: Vec<Vector> = y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect();
        slopes(&rule, x, &values).iter().map(|s| s[0].to_f64()).collect()
    }

    #[test]
    fn rules_by_hand() {
        // secants 2 and −1 over widths 1 and 3
        let (x, y) = ([0.0, 1.0, 4.0], [0.0, 2.0, -1.0]);
        assert_eq!(at(Tangents::FiniteDifference, &x, &y), [2.0, 0.5, -1.0]);
        assert_eq!(at(Tangents::CatmullRom, &x, &y), [2.0, -0.25, -1.0]);
        assert_eq!(at(Tangents::Parabola, &x, &y), [2.75, 1.25, -3.25]);
        assert_eq!(at(Tangents::Monotone, &x, &y), [2.75, 0.0, -3.0]);
        assert_eq!(at(Tangents::Akima, &x[..2], &y[..2]), [2.0, 2.0]);
    }

    /// A corner between two straight runs: the mean of the two, whatever the rounding of the data.
    #[test]
    fn akima_at_a_corner() {
        let x: Vec<f64> = (0..7).map(|i| f64::from(i) * 0.1).collect();
        let y: Vec<f64> = x.iter().map(|x| if *x < 0.3 { 0.7 * x } else { 0.21 - 0.3 * (x - 0.3) }).collect();
        let slopes = at(Tangents::Akima, &x, &y);
        assert!((slopes[3] - 0.2).abs() < 1e-14, "{slopes:?}");
        assert!((slopes[1] - 0.7).abs() < 1e-14 && (slopes[5] + 0.3).abs() < 1e-14);
    }
}
