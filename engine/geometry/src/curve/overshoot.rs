//! Overshoot of a curve: between each two neighbours, how far it leaves the range of their values.
//!
//! Coordinates count each for itself. The extremes of a coordinate between two nodes lie where its
//! derivative changes sign; that is looked for in `SAMPLES` parts of every smooth piece and then
//! bisected, so that an extreme is found to rounding.

use super::{Curve, CurveShape, figure::ascending};
use crate::space::Vector;
use flankfit_numerics::root::boundary;

/// Parts of a smooth piece between two nodes in which a change of sign is looked for.
const SAMPLES: usize = 16;

/// Excursions below this part of the largest value are rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The largest excursion of a curve out of the range of the two points around it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Overshoot {
    /// In the unit of the coordinate.
    pub amount: f64,
    /// Relative to the range of this coordinate over all points; absent if that range is 0.
    pub relative: Option<f64>,
    /// The parameter at which it is reached.
    pub at: f64,
    /// 0 for y of a graph, else 0, 1, 2 for x, y, z.
    pub coordinate: usize,
    /// Indices, from 0, of the two points between which it is reached.
    #[cfg_attr(feature = "contract", schema(value_type = Vec<usize>, min_items = 2, max_items = 2))]
    pub between: [usize; 2],
}

/// The largest excursion, compared as part of the range of each coordinate.
pub fn overshoot(shape: &CurveShape, parameters: &[f64], values: &[Vector]) -> Option<Overshoot> {
    let order = ascending(parameters);
    let count = shape.dimension().count();
    let breaks = shape.breaks();
    let range = |k: usize| {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v[k]), h.max(v[k])));
        (high - low, low.abs().max(high.abs()))
    };
    let ranges: Vec<(f64, f64)> = (0..count).map(range).collect();
    let mut largest: Option<(f64, Overshoot)> = None;
    for pair in order.windows(2) {
        let [left, right] = [pair[0], pair[1]];
        for (t, k) in extremes(shape, &breaks, parameters[left], parameters[right], count) {
            let (a, b) = (values[left][k], values[right][k]);
            let value = shape.value(t)[k];
            let amount = (value - a.max(b)).max(a.min(b) - value);
            let (width, size) = ranges[k];
            if !(amount > ROUNDING * size) {
                continue;
            }
            let relative = (width > 0.0).then(|| amount / width).filter(|r| r.is_finite());
            let measure = relative.unwrap_or(f64::MAX);
            if largest.is_none_or(|(most, _)| measure > most) {
                largest = Some((measure, Overshoot { amount, relative, at: t, coordinate: k, between: [left, right] }));
            }
        }
    }
    largest.map(|(_, overshoot)| overshoot)
}

/// Places between `low` and `high` where the derivative of a coordinate changes sign, with that
/// coordinate.
fn extremes(shape: &CurveShape, breaks: &[f64], low: f64, high: f64, count: usize) -> Vec<(f64, usize)> {
    let mut ends = vec![low];
    let (first, last) = (breaks.partition_point(|b| *b <= low), breaks.partition_point(|b| *b < high));
    ends.extend(breaks.get(first..last).unwrap_or_default());
    ends.push(high);
    let mut found = Vec::new();
    for piece in ends.windows(2) {
        let place = |i: usize| piece[0] + (piece[1] - piece[0]) * (i as f64 / SAMPLES as f64);
        let mut before = (piece[0], shape.jet(piece[0])[1]);
        for i in 1..=SAMPLES {
            // the end itself belongs to the next piece
            let t = if i == SAMPLES { piece[1].next_down() } else { place(i) };
            let slope = shape.jet(t)[1];
            for k in 0..count {
                if slope[k] == 0.0 {
                    found.push((t, k));
                } else if before.1[k] * slope[k] < 0.0 {
                    let [_, turned] = boundary([before.0, t], 0.0, |t| shape.jet(t)[1][k] * before.1[k] > 0.0);
                    found.push((turned, k));
                }
            }
            before = (t, slope);
        }
        // a corner at a break may be an extreme as well
        if piece[1] < high {
            found.extend((0..count).map(|k| (piece[1], k)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Method, Points, Tangents, through};

    fn of(x: &[f64], y: &[f64], method: Method) -> Option<Overshoot> {
        through(&Points::Graph { x: x.to_vec(), y: y.to_vec() }, &method).unwrap().stability.overshoot
    }

    /// The parabola x (1 − x) through (−1, −2), (0, 0), (1, 0) swings to 1/4 between the last two.
    #[test]
    fn of_a_parabola() {
        for x in [[-1.0, 0.0, 1.0], [1.0, -1.0, 0.0]] {
            let y = x.map(|x| x * (1.0 - x));
            let over = of(&x, &y, Method::Lagrange).unwrap();
            assert!((over.amount - 0.25).abs() < 1e-15 && (over.at - 0.5).abs() < 1e-8);
            assert_eq!(over.relative.map(|r| (r * 8.0).round()), Some(1.0));
            assert_eq!(over.between.map(|i| x[i]), [0.0, 1.0]);
        }
    }

    #[test]
    fn a_monotone_curve_has_none() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0, 10.0], [0.0, 0.0, 1.0, 5.0, 5.0]);
        assert_eq!(of(&x, &y, Method::CubicHermite(Tangents::Monotone)), None);
        assert!(of(&x, &y, Method::CubicHermite(Tangents::CatmullRom)).is_some());
    }
}
