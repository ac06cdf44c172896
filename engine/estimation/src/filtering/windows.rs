//! Weighted polynomials under the windows of a Gaussian filter, four lines side by side.
//!
//! All lines share their positions, so the weighting function is computed once for a window and
//! serves every line; only the weights of the nodes differ. With the moments `Sⱼ = Σ p tʲ`, t
//! counted from the middle of the window in units of its width, the filtered height is `Σ p (c₀ +
//! c₁t + c₂t²) z`, which is the value at t = 0 of the parabola of least squares.

use std::ops::Range;

use super::lines::Lines;
use crate::spec::Order;
use flankfit_numerics::{
    lanes::{F64x4, LANES, Lanes},
    with_fma,
};

/// Pairs of places whose weights are kept from one round to the next.
const KEPT: usize = 1_000_000;
/// Share of a sum of squares that must be left where polynomials of lower order are taken out, for
/// differences of moments to have their digits.
const LEAST_SHARE: f64 = 1e-3;
/// Sum of weights below which their powers may vanish.
const LEAST_TOTAL: f64 = 1e-150;

/// One number for each place of several lines, four lines at a time.
pub(super) struct Numbers {
    places: usize,
    lanes: Vec<F64x4>,
}

impl Numbers {
    /// Collects what `of` says of every node of these lines.
    pub(super) fn new(lines: &Lines, which: &[usize], of: impl Fn(usize) -> f64) -> Self {
        let places = lines.places();
        let mut all = vec![F64x4::ZERO; places * which.len().div_ceil(LANES)];
        for (four, group) in which.chunks(LANES).zip(all.chunks_exact_mut(places.max(1))) {
            for (lane, &line) in four.iter().enumerate() {
                group.iter_mut().enumerate().for_each(|(place, to)| to.set(lane, of(lines.node(line, place))));
            }
        }
        Numbers { places, lanes: all }
    }

    /// Places under a window on four lines.
    pub(super) fn under(&self, group: usize, window: &Range<usize>) -> &[F64x4] {
        &self.lanes[group * self.places..][window.clone()]
    }
}

/// The window about each place.
pub(super) struct Windows {
    /// Places under it.
    pub under: Vec<Range<usize>>,
    /// The weighting function, where it is kept.
    kept: Option<Vec<Vec<f64>>>,
}

/// Weights of a window's places: positions counted from its middle, weighting function times cell,
/// and that times powers of the position.
pub(super) struct Window {
    pub t: Vec<f64>,
    pub s: Vec<f64>,
    powers: Vec<[f64; 5]>,
}

impl Windows {
    /// Windows of half the width `reach·width`. What repeats is kept if it is not too much.
    pub(super) fn new(lines: &Lines, width: f64, reach: f64, repeated: bool) -> Self {
        let x = &lines.x;
        let half = reach * width;
        let under: Vec<Range<usize>> = x
            .iter()
            .map(|middle| x.partition_point(|&at| at < middle - half)..x.partition_point(|&at| at <= middle + half))
            .collect();
        let pairs: usize = under.iter().map(ExactSizeIterator::len).sum();
        let mut windows = Windows { under, kept: None };
        if repeated && pairs <= KEPT {
            windows.kept = Some((0..x.len()).map(|k| windows.weights(lines, width, k)).collect());
        }
        windows
    }

    fn weights(&self, lines: &Lines, width: f64, k: usize) -> Vec<f64> {
        let under = self.under[k].clone();
        let t = |x: &f64| (x - lines.x[k]) / width;
        lines.x[under.clone()]
            .iter()
            .map(t)
            .zip(&lines.cell[under])
            .map(|(t, cell)| (-std::f64::consts::PI * t * t).exp() * cell)
            .collect()
    }

    /// The window about place `k`.
    pub(super) fn window(&self, lines: &Lines, width: f64, k: usize) -> Window {
        let t: Vec<f64> = lines.x[self.under[k].clone()].iter().map(|x| (x - lines.x[k]) / width).collect();
        let s = self.kept.as_ref().map_or_else(|| self.weights(lines, width, k), |kept| kept[k].clone());
        let powers = s
            .iter()
            .zip(&t)
            .map(|(&s, &t)| {
                let (first, second) = (s * t, s * t * t);
                [s, first, second, second * t, second * t * t]
            })
            .collect();
        Window { t, s, powers }
    }
}

impl Window {
    /// Puts the factors of the numbers of four lines under the window into `row`. Returns in which
    /// lanes the nodes determine the order well enough.
    pub(super) fn rows(&self, order: Order, delta: &[F64x4], row: &mut [F64x4]) -> [bool; LANES] {
        let moments = moments(&self.powers, delta);
        let mut sound = [false; LANES];
        let mut c = [F64x4::ZERO; 3];
        for (lane, sound) in sound.iter_mut().enumerate() {
            if let Some(polynomial) = polynomial(order, moments.map(|s| s.get(lane))) {
                *sound = true;
                c.iter_mut().zip(polynomial).for_each(|(to, c)| to.set(lane, c));
            }
        }
        multiply(&self.powers, delta, &c, row);
        sound
    }
}

/// Coefficients c₀, c₁, c₂ from the moments, if these determine them.
fn polynomial(order: Order, s: [f64; 5]) -> Option<[f64; 3]> {
    let total = s[0];
    if !(total > LEAST_TOTAL) {
        return None;
    }
    if order == Order::Zero {
        return Some([1.0 / total, 0.0, 0.0]);
    }
    let mean = s[1] / total;
    let second = s[2] - mean * s[1];
    let third = s[3] - mean * (3.0 * s[2] - 2.0 * mean * s[1]);
    let central = s[4] - mean * (4.0 * s[3] - mean * (6.0 * s[2] - 3.0 * mean * s[1]));
    // the norm of square(t) = (t − mean)² − skew (t − mean) − second/total
    let skew = third / second;
    let fourth = central - skew * third - second * second / total;
    if !(second > LEAST_SHARE * s[2] && fourth > LEAST_SHARE * s[4]) {
        return None;
    }
    let square = [mean * (mean + skew) - second / total, -2.0 * mean - skew, 1.0];
    let share = square[0] / fourth;
    let slope = mean / second;
    Some([1.0 / total + slope * mean + share * square[0], share * square[1] - slope, share])
}

with_fma! {
    /// `Σ s tʲ δ`, j = 0…4.
    fn moments(powers: &[[f64; 5]], delta: &[F64x4]) -> [F64x4; 5] {
        let mut sums = [[F64x4::ZERO; 5]; 2];
        let (pairs, deltas) = (powers.chunks_exact(2), delta.chunks_exact(2));
        let last = pairs.remainder().first().zip(deltas.remainder().first());
        for (powers, delta) in pairs.zip(deltas) {
            for (half, sums) in sums.iter_mut().enumerate() {
                for (sum, &power) in sums.iter_mut().zip(&powers[half]) {
                    *sum = delta[half].mul_add(F64x4::splat(power), *sum);
                }
            }
        }
        let [mut even, odd] = sums;
        if let Some((powers, delta)) = last {
            for (sum, &power) in even.iter_mut().zip(powers) {
                *sum = delta.mul_add(F64x4::splat(power), *sum);
            }
        }
        std::array::from_fn(|j| even[j] + odd[j])
    }

    /// `row = (c₀ + c₁t + c₂t²) s δ`.
    fn multiply(powers: &[[f64; 5]], delta: &[F64x4], c: &[F64x4; 3], row: &mut [F64x4]) {
        for ((to, power), delta) in row.iter_mut().zip(powers).zip(delta) {
            let sum = c[0] * power[0];
            let sum = c[1].mul_add(F64x4::splat(power[1]), sum);
            *to = c[2].mul_add(F64x4::splat(power[2]), sum) * *delta;
        }
    }

    /// `Σ row · numbers`.
    pub(super) fn sum_of_products(row: &[F64x4], numbers: &[F64x4]) -> F64x4 {
        let mut sums = [F64x4::ZERO; 4];
        let (fours, others) = (row.chunks_exact(4), numbers.chunks_exact(4));
        let rest = fours.remainder().iter().zip(others.remainder());
        let rest = rest.fold(F64x4::ZERO, |sum, (a, b)| a.mul_add(*b, sum));
        for (a, b) in fours.zip(others) {
            for k in 0..4 {
                sums[k] = a[k].mul_add(b[k], sums[k]);
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola is reproduced by the moments of any weights that determine it.
    #[test]
    fn the_polynomial_keeps_parabolas() {
        let t = [-0.3, -0.1, 0.05, 0.4, 0.7];
        let p = [0.2, 1.0, 0.5, 0.25, 0.125];
        let moments: [f64; 5] =
            std::array::from_fn(|j| p.iter().zip(t).map(|(p, t): (&f64, f64)| p * t.powi(j as i32)).sum());
        let c = polynomial(Order::Two, moments).unwrap();
        for (power, value) in [(0, 1.0), (1, 0.0), (2, 0.0)] {
            let sum: f64 = p.iter().zip(t).map(|(p, t)| p * (c[0] + c[1] * t + c[2] * t * t) * t.powi(power)).sum();
            assert!((sum - value).abs() < 1e-13, "{power} {sum}");
        }
        // two places do not hold one
        let two: [f64; 5] = std::array::from_fn(|j| 0.1f64.powi(j as i32) + 0.2f64.powi(j as i32));
        assert_eq!(polynomial(Order::Two, two), None);
        assert_eq!(polynomial(Order::Zero, two), Some([0.5, 0.0, 0.0]));
        assert_eq!(polynomial(Order::Zero, [0.0; 5]), None);
    }
}
