//! Gaussian profile filters: linear (ISO 16610-21) and robust (ISO 16610-31).
//!
//! The weighting function is `s(x) = exp(−π (x/(γ λc))²)`. Each present node l has for node k the
//! weight `p = s(x_l − x_k) · cell_l · δ_l`, cell being the length of axis that belongs to the node
//! (so spacing may be unequal) and δ its robustness weight (1 in the linear filter). The filtered
//! height is the value at x_k of the polynomial of order 0 or 2 that fits the heights best with
//! weights p.
//!
//! | | order | γ | a sine of wavelength λ keeps |
//! |---|---|---|---|
//! | linear | 0 | √(ln 2/π) = 0.4697 | exp(−π γ² (λc/λ)²) |
//! | robust, order 0 | 0 | the same | the same, where δ = 1 |
//! | robust, order 2 | 2 | 0.7309, from (1 + πγ²) exp(−πγ²) = 1/2 | (1 + q) exp(−q), q = πγ²(λc/λ)² |
//!
//! so that a wave of the cut-off length λc is halved. *Ends and missing nodes:* weights are
//! normalised by the sum of those that are there (order 0: a constant is kept everywhere; order 2:
//! a parabola is). A node that is missing stays missing. The function is cut off where it falls
//! below 2⁻⁵³, far outside the standard's least width. Where the nodes under the window do not
//! determine order 2, a lower one is taken.
//!
//! *Robust:* δ = (1 − (r/c)²)² for |r| < c, else 0 (Tukey's biweight), r the distance of a node
//! from its filtered height, c = 4.4478 times the median |r| of the line. Repeated for each line
//! until no height moves by more than [`TOLERANCE`]·c, or [`ROUNDS`] times. On short lines scale
//! and weights may chase each other for ever; so from round [`SETTLING`] on c may only fall.

use rayon::prelude::*;

use super::{
    lines::Lines,
    windows::{Numbers, Window, Windows, sum_of_products},
};
use crate::spec::Order;
use flankfit_numerics::{
    cancel::{self, Asking},
    lanes::{F64x4, LANES},
    quantiles::median,
};

/// √(ln 2/π).
const GAMMA_0: f64 = 0.469_718_639_349_825_7;
/// √(q/π) with (1 + q) exp(−q) = 1/2.
const GAMMA_2: f64 = 0.730_913_428_094_675_9;
/// √(53 ln 2/π): farther than so many γλc the weighting function is below 2⁻⁵³.
const REACH: f64 = 3.420;
/// 3/Φ⁻¹(0.75): three standard deviations in medians of |r|.
const TUKEY: f64 = 4.447_806_655_516_806;
/// Movement of the heights, in units of c, that ends the iteration.
pub(super) const TOLERANCE: f64 = 1e-6;
/// Rounds after which it ends in any case.
pub(super) const ROUNDS: usize = 200;
/// Rounds after which the scale of a line does not grow any more.
const SETTLING: usize = 10;
/// Share of the widest possible norm below which an order is not determined by the nodes.
const UNDETERMINED: f64 = 1e-10;

/// A linear filter, or a robust one with its weights as they came out.
#[derive(Clone, Debug)]
pub(super) struct GaussianFilter {
    width: f64,
    order: Order,
}

/// Final state of the iteration of a robust filter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Robust {
    /// δ of every posted node; 1 where it is missing.
    pub delta: Vec<f64>,
    /// Rounds of the line that took the most.
    pub rounds: usize,
    /// Lines whose heights still moved when the rounds were used up.
    pub unfinished: usize,
}

impl GaussianFilter {
    pub(super) fn new(cutoff: f64, order: Order) -> Self {
        let gamma = match order {
            Order::Zero => GAMMA_0,
            Order::Two => GAMMA_2,
        };
        GaussianFilter { width: gamma * cutoff, order }
    }

    /// Pairs of places under a window, all windows of one line together.
    pub(super) fn pairs(&self, lines: &Lines) -> usize {
        let (mut low, mut high, mut pairs) = (0, 0, 0usize);
        let (x, reach) = (&lines.x, REACH * self.width);
        for k in 0..x.len() {
            while x[low] < x[k] - reach {
                low += 1;
            }
            while high < x.len() && x[high] <= x[k] + reach {
                high += 1;
            }
            pairs = pairs.saturating_add(high - low);
        }
        pairs
    }

    /// Filters columns, each with one number for every posted node; numbers of missing nodes stay.
    pub(super) fn apply(&self, lines: &Lines, present: &[bool], delta: Option<&[f64]>, columns: &mut [Vec<f64>]) {
        let everything: Vec<usize> = (0..lines.count).collect();
        let done = {
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let windows = self.windows(lines, false);
            self.values(&windows, lines, &everything, present, delta, &columns)
        };
        let width = columns.len().max(1);
        for (place, values) in done.iter().enumerate() {
            for (line, values) in values.chunks_exact(width).enumerate() {
                let node = lines.node(line, place);
                if present[node] {
                    columns.iter_mut().zip(values).for_each(|(column, value)| column[node] = *value);
                }
            }
        }
    }

    /// Filtered heights, with the weights that the robust iteration ends with.
    pub(super) fn robust(&self, lines: &Lines, present: &[bool], z: &[f64]) -> (Vec<f64>, Robust) {
        let mut heights = z.to_vec();
        let mut delta = vec![1.0; z.len()];
        let mut open: Vec<usize> = (0..lines.count).collect();
        let mut rounds = 0;
        let mut scale = vec![f64::INFINITY; lines.count];
        let windows = self.windows(lines, true);
        loop {
            cancel::checkpoint();
            let done = self.values(&windows, lines, &open, present, Some(&delta), &[z]);
            rounds += 1;
            let still = std::mem::take(&mut open);
            for (at, &line) in still.iter().enumerate().asking(20 * lines.places()) {
                let there: Vec<(usize, usize)> = (0..lines.places())
                    .map(|place| (place, lines.node(line, place)))
                    .filter(|&(_, node)| present[node])
                    .collect();
                let (mut moved, mut largest) = (0.0f64, 0.0f64);
                for &(place, node) in &there {
                    let value = done[place][at];
                    moved = moved.max((value - heights[node]).abs());
                    largest = largest.max(z[node].abs());
                    heights[node] = value;
                }
                let mut distances: Vec<f64> = there.iter().map(|&(_, node)| (z[node] - heights[node]).abs()).collect();
                let mut c = TUKEY * median(&mut distances);
                if rounds > SETTLING {
                    c = c.min(scale[line]);
                }
                scale[line] = c;
                // at least half of the nodes lie on the filtered line but for rounding: there is
                // nothing left to weigh
                if !(c > 1e-13 * largest) || (rounds > 1 && moved <= TOLERANCE * c) {
                    continue;
                }
                open.push(line);
                if rounds < ROUNDS {
                    for &(_, node) in &there {
                        delta[node] = biweight((z[node] - heights[node]) / c);
                    }
                }
            }
            if open.is_empty() || rounds == ROUNDS {
                return (heights, Robust { delta, rounds, unfinished: open.len() });
            }
        }
    }

    fn windows(&self, lines: &Lines, repeated: bool) -> Windows {
        Windows::new(lines, self.width, REACH, repeated)
    }

    /// For every place, line by line, the filtered numbers of all columns.
    fn values(
        &self,
        windows: &Windows,
        lines: &Lines,
        which: &[usize],
        present: &[bool],
        delta: Option<&[f64]>,
        columns: &[&[f64]],
    ) -> Vec<Vec<f64>> {
        let handle = cancel::current();
        let there = |node: usize, value: f64| if present[node] { value } else { 0.0 };
        let weight = |node: usize| there(node, delta.map_or(1.0, |delta| delta[node]));
        let weights = Numbers::new(lines, which, weight);
        let numbers: Vec<Numbers> =
            columns.iter().map(|column| Numbers::new(lines, which, |node| there(node, column[node]))).collect();
        let place = |k: usize| {
            cancel::checkpoint();
            let (window, under) = (windows.window(lines, self.width, k), &windows.under[k]);
            let mut row = vec![F64x4::ZERO; under.len()];
            let mut out = vec![0.0; which.len() * columns.len()];
            let cost = 4 * (under.len() + 1) * (columns.len() + 8);
            let groups = which.chunks(LANES).zip(out.chunks_mut(LANES * columns.len().max(1)));
            for (group, (four, out)) in groups.enumerate().asking(cost) {
                let sound = window.rows(self.order, weights.under(group, under), &mut row);
                for (at, numbers) in numbers.iter().enumerate() {
                    let sums = sum_of_products(&row, numbers.under(group, under)).to_array();
                    out.iter_mut().skip(at).step_by(columns.len()).zip(sums).for_each(|(to, sum)| *to = sum);
                }
                for ((&line, out), _) in
                    four.iter().zip(out.chunks_mut(columns.len().max(1))).zip(sound).filter(|(_, sound)| !sound)
                {
                    let nodes: Vec<usize> = under.clone().map(|place| lines.node(line, place)).collect();
                    let row = self.row(&window, &nodes, present, weight);
                    for (to, column) in out.iter_mut().zip(columns) {
                        *to = row.iter().zip(&nodes).map(|(p, &node)| p * there(node, column[node])).sum();
                    }
                }
            }
            out
        };
        (0..lines.places())
            .into_par_iter()
            .with_min_len(8)
            .map(|k| cancel::carry(handle.as_ref(), || place(k)))
            .collect()
    }

    /// Factors of the numbers of `nodes`, if their weights hardly determine the order.
    fn row(&self, window: &Window, nodes: &[usize], present: &[bool], weight: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut p: Vec<f64> = window.s.iter().zip(nodes).map(|(s, &node)| s * weight(node)).collect();
        // where every node under the window was given up, they all count again
        if p.iter().sum::<f64>() <= f64::MIN_POSITIVE {
            p = window.s.iter().zip(nodes).map(|(s, &node)| if present[node] { *s } else { 0.0 }).collect();
        }
        if p.iter().any(|p| *p > 0.0) {
            into_row(&mut p, &window.t, self.order);
        }
        p
    }
}

fn biweight(r: f64) -> f64 {
    let square = r * r;
    if square < 1.0 { (1.0 - square) * (1.0 - square) } else { 0.0 }
}

/// From weights p to the row by which heights are multiplied: `p_l Σ_r P_r(0) P_r(t_l)/‖P_r‖²` over
/// the polynomials that are orthogonal under p, up to the order that the nodes determine.
fn into_row(p: &mut [f64], t: &[f64], order: Order) {
    let total: f64 = p.iter().sum();
    let flat = |p: &mut [f64]| p.iter_mut().for_each(|p| *p /= total);
    if order == Order::Zero {
        return flat(p);
    }
    let widest = p.iter().zip(t).filter(|(p, _)| **p > 0.0).map(|(_, t)| t * t).fold(0.0, f64::max);
    let sum = |f: &dyn Fn(f64) -> f64| p.iter().zip(t).map(|(p, t)| p * f(*t)).sum::<f64>();
    let mean = sum(&|t| t) / total;
    let second = sum(&|t| (t - mean) * (t - mean));
    if second <= UNDETERMINED * widest * total {
        return flat(p);
    }
    let third = sum(&|t| (t - mean).powi(3));
    let square = |t: f64| (t - mean) * (t - mean) - third / second * (t - mean) - second / total;
    let fourth = sum(&|t| square(t) * square(t));
    let curved = fourth > UNDETERMINED * widest * widest * total;
    let at_0 = if curved { square(0.0) / fourth } else { 0.0 };
    for (p, &t) in p.iter_mut().zip(t) {
        *p *= 1.0 / total - mean * (t - mean) / second + at_0 * square(t);
    }
}
