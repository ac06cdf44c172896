//! Oscillation of a curve between its points, which residuals do not show.

use super::points::CurvePoints;
use flankfit_geometry::{
    curve::{BSplineCurve, Curve},
    space::Vector,
};
use flankfit_numerics::cancel::Asking;

/// A curve that swings out further than all of the points are apart is no curve near points.
pub const WILD: f64 = 1.0;

/// Places between two neighbouring parameters that are looked at.
const LOOKS: usize = 4;

/// Measure of oscillations between points.
pub(super) struct Swing<'a> {
    /// Distinct parameters of counted points, ascending.
    parameters: &'a [f64],
    /// The longest side of the box around the counted points.
    extent: f64,
}

impl<'a> Swing<'a> {
    /// Makes it from points with `parameters`, distinct and ascending; points of weight 0 do not
    /// count.
    pub(super) fn of(points: &CurvePoints, parameters: &'a [f64]) -> Self {
        let range = |values: &Vec<f64>| {
            let counted = values.iter().enumerate().filter(|(k, _)| points.counts(*k)).map(|(_, value)| *value);
            let (low, high) = counted.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
            // half of each, so that the difference does not overflow
            2.0 * (0.5 * high - 0.5 * low).max(0.0)
        };
        let largest = points.coordinates.iter().flatten().fold(0.0f64, |most, y| most.max(y.abs()));
        let extent = points.coordinates.iter().map(range).fold(f64::EPSILON * largest, f64::max);
        Swing { parameters, extent }
    }

    /// The farthest that the curve leaves the box of its places at two neighbouring parameters,
    /// over the extent of the points; 0 where it never does.
    pub(super) fn out(&self, curve: &BSplineCurve) -> f64 {
        let mut most = 0.0f64;
        let [low, high] = curve.domain();
        let place = |t: f64| curve.value(t.clamp(low, high));
        let Some(first) = self.parameters.first() else { return 0.0 };
        let (mut before, mut here) = (*first, place(*first));
        for &t in self.parameters[1..].iter().asking(1000) {
            let next = place(t);
            let (lower, upper) = (here.inf(&next), here.sup(&next));
            for k in 1..=LOOKS {
                let value = place(before + (t - before) * (k as f64 / (LOOKS + 1) as f64));
                let out: Vector = value - value.sup(&lower).inf(&upper);
                let size = out.amax();
                most = if size.is_finite() { most.max(size) } else { f64::INFINITY };
            }
            (before, here) = (t, next);
        }
        if most > 0.0 { most / self.extent } else { 0.0 }
    }
}
