//! The area of a surface: ∬ |S_u × S_v| by Gauss–Legendre rules on the rectangles between its
//! breaks, the worst of which are split until their estimated errors add up to the tolerance.

use super::Surface;
use flankfit_numerics::{cancel, quadrature::gauss_legendre, sum2};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Points per axis of the rule that counts and of the one it is compared with.
const FINE: usize = 9;
const COARSE: usize = 6;
/// Rectangles at most, in addition to those that the breaks make.
const MOST: usize = 4096;

/// An area with what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// The area, in the square of the coordinates' unit.
    pub area: f64,
    /// The sum of the differences of two rules: usually far above the true error.
    pub error_estimate: f64,
    /// Whether that is within the tolerance asked for.
    pub converged: bool,
}

/// A rectangle with its integral; the one with the largest error is the greatest.
struct Cell {
    u: [f64; 2],
    v: [f64; 2],
    area: f64,
    error: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        // equal errors: the place decides, so that the order is always the same
        let key = |c: &Cell| [c.error, c.u[0], c.v[0]];
        key(self).iter().zip(key(other)).map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    }
}

/// Nodes and weights on [-1, 1].
type Rule = Vec<(f64, f64)>;

/// The area of the surface's place in space, to `tolerance` (relative to the area) if 4096 further
/// rectangles suffice.
///
/// ```
/// use flankfit_geometry::{
///     space::{Dimension, Vector},
///     surface::{BezierSurface, area::area},
/// };
///
/// // z = u over the unit square: a plane at 45°, √2 large.
/// let heights = [0.0, 0.0, 1.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
/// let unit = [[0.0, 1.0]; 2];
/// let plane = BezierSurface::new([2, 2], unit, Dimension::Graph, heights, None)?;
/// assert!((area(&plane, 1e-12).area - 2_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn area(surface: &dyn Surface, tolerance: f64) -> Area {
    let rule = |n| -> Rule { gauss_legendre(n).into_iter().map(|(x, w)| (x.to_f64(), w.to_f64())).collect() };
    let rules = [rule(FINE), rule(COARSE)];
    let [us, vs] = surface.breaks();
    let mut heap: BinaryHeap<Cell> = us
        .windows(2)
        .flat_map(|u| vs.windows(2).map(move |v| ([u[0], u[1]], [v[0], v[1]])))
        .map(|(u, v)| cell(surface, &rules, u, v))
        .collect();
    let most = heap.len() + MOST;
    loop {
        let (areas, errors): (Vec<f64>, Vec<f64>) = heap.iter().map(|c| (c.area, c.error)).unzip();
        let (area, error_estimate) = (sum2(&areas).to_f64(), sum2(&errors).to_f64());
        let converged = error_estimate <= tolerance * area;
        if converged || heap.len() >= most {
            return Area { area, error_estimate, converged };
        }
        // all that are worse than their share, so that sums are not made anew for each
        let share = tolerance * area / heap.len() as f64;
        let mut splits = Vec::new();
        while heap.len() + 4 * splits.len() < most {
            match heap.pop() {
                Some(worst) if worst.error > share || splits.is_empty() => splits.push(worst),
                Some(good) => {
                    heap.push(good);
                    break;
                }
                None => break,
            }
        }
        for worst in splits {
            let ([a, b], [c, d]) = (worst.u, worst.v);
            let (m, n) = (0.5 * a + 0.5 * b, 0.5 * c + 0.5 * d);
            for (u, v) in [([a, m], [c, n]), ([a, m], [n, d]), ([m, b], [c, n]), ([m, b], [n, d])] {
                heap.push(cell(surface, &rules, u, v));
            }
        }
    }
}

fn cell(surface: &dyn Surface, rules: &[Rule; 2], u: [f64; 2], v: [f64; 2]) -> Cell {
    cancel::checkpoint();
    let [fine, coarse] = rules.each_ref().map(|rule| integral(surface, rule, u, v));
    // what rounding does to the sum is no error that a split would lower
    let noise = 4.0 * f64::EPSILON * fine;
    Cell { u, v, area: fine, error: ((fine - coarse).abs() - noise).max(0.0) }
}

fn integral(surface: &dyn Surface, rule: &Rule, [a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    let (half_u, half_v) = (0.5 * (b - a), 0.5 * (d - c));
    let (mid_u, mid_v) = (0.5 * a + 0.5 * b, 0.5 * c + 0.5 * d);
    let mut sum = 0.0;
    for (x, wx) in rule {
        let mut line = 0.0;
        for (y, wy) in rule {
            let jet = surface.place(mid_u + half_u * x, mid_v + half_v * y);
            line += wy * jet.u.cross(&jet.v).norm();
        }
        sum += wx * line;
    }
    sum * half_u * half_v
}
