//! Spline profile filter (ISO 16610-22): linear, natural ends.
//!
//! The filtered heights w make `Σ cell_k (z_k − w_k)² + Σ κ_k h̄_k (w″_k)²` least, w″ being the
//! second divided difference at an inner node and h̄ the mean of its two adjacent spacings, with
//!
//! `κ = (h̄ / (2 sin(π h̄/λc)))⁴`.
//!
//! On equal spacing h this is the standard's `(I + μ Q) w = z` with `μ = 1/(2 sin(π h/λc))⁴`: away
//! from the ends a sine of wavelength λ keeps `1/(1 + (sin(πh/λ)/sin(πh/λc))⁴)` of its amplitude,
//! hence one half at the cut-off whatever the spacing. Elsewhere κ is taken at the local spacing,
//! and tends to the continuous spline's (λc/2π)⁴ as that gets small; a gap wider than λc/2 counts
//! as λc/2 does. Nothing is asked of the ends (natural: w″ = 0 outside them), so a straight line is
//! kept everywhere. Nodes that are missing are no knots and stay missing; repeated measurements of
//! one place are one knot with their mean.
//!
//! Solved by Reinsch's form, `(C⁻¹ + E W⁻¹ Eᵀ) g = E z`, `w = z − W⁻¹ Eᵀ g`, whose matrix has five
//! bands and stays well behaved for a cut-off much longer than the line, where the plain form loses
//! every digit.

use rayon::prelude::*;

use super::lines::{Lines, cells};
use flankfit_numerics::cancel::{self, Asking};

/// A spline filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct SplineFilter {
    pub cutoff: f64,
}

impl SplineFilter {
    /// Filters columns, each with one number for every posted node; numbers of missing nodes stay.
    pub(super) fn apply(&self, lines: &Lines, present: &[bool], columns: &mut [Vec<f64>]) {
        let done: Vec<(Knots, Vec<Vec<f64>>)> = {
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let handle = cancel::current();
            let smoothed = |line| {
                cancel::checkpoint();
                let knots = Knots::new(lines, line, present);
                let system = System::new(&knots.x, self.cutoff);
                let smooth = columns.iter().map(|column| system.smooth(knots.means(column))).collect();
                (knots, smooth)
            };
            (0..lines.count).into_par_iter().map(|line| cancel::carry(handle.as_ref(), || smoothed(line))).collect()
        };
        for (knots, smooth) in done {
            for (column, smooth) in columns.iter_mut().zip(smooth) {
                for (nodes, value) in knots.nodes.iter().zip(smooth) {
                    nodes.iter().for_each(|&node| column[node] = value);
                }
            }
        }
    }
}

/// The different positions of one line at which nodes are there.
struct Knots {
    x: Vec<f64>,
    nodes: Vec<Vec<usize>>,
}

impl Knots {
    fn new(lines: &Lines, line: usize, present: &[bool]) -> Self {
        let mut knots = Knots { x: Vec::new(), nodes: Vec::new() };
        for place in (0..lines.places()).asking(20) {
            let (x, node) = (lines.x[place], lines.node(line, place));
            if !present[node] {
                continue;
            }
            match knots.nodes.last_mut() {
                Some(nodes) if knots.x.last() == Some(&x) => nodes.push(node),
                _ => {
                    knots.x.push(x);
                    knots.nodes.push(vec![node]);
                }
            }
        }
        knots
    }

    fn means(&self, column: &[f64]) -> Vec<f64> {
        let share = |nodes: &Vec<usize>| nodes.iter().map(|&node| column[node] / nodes.len() as f64).sum::<f64>();
        self.nodes.iter().map(share).collect()
    }
}

/// The five bands of one line, factored as L D Lᵀ.
struct System {
    /// 1/spacing, in units of the cut-off.
    slope: Vec<f64>,
    /// 1/W.
    inverse_cell: Vec<f64>,
    pivot: Vec<f64>,
    below: [Vec<f64>; 2],
}

impl System {
    fn new(x: &[f64], cutoff: f64) -> Self {
        let x: Vec<f64> = x.iter().map(|x| x / cutoff).collect();
        let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slope: Vec<f64> = h.iter().map(|h| 1.0 / h).collect();
        let inverse_cell: Vec<f64> = cells(&x).iter().map(|cell| 1.0 / cell).collect();
        let inner = x.len().saturating_sub(2);
        // row k of E: slope_k, −(slope_k + slope_{k+1}), slope_{k+1} at the knots k, k+1, k+2
        let row = |k: usize| [slope[k], -(slope[k] + slope[k + 1]), slope[k + 1]];
        let (mut pivot, mut below) = (vec![0.0; inner], [vec![0.0; inner], vec![0.0; inner]]);
        for k in (0..inner).asking(60) {
            let mean = 0.5 * (h[k] + h[k + 1]);
            let sine = 2.0 * (std::f64::consts::PI * mean.min(0.5)).sin();
            let stiffness = (mean / sine).powi(4) / mean;
            let here = row(k);
            let own: f64 = (0..3).map(|i| here[i] * here[i] * inverse_cell[k + i]).sum();
            let product = |back: usize| {
                let other = row(k - back);
                (0..3 - back).map(|i| here[i] * other[i + back] * inverse_cell[k + i]).sum::<f64>()
            };
            // L of the row: entries two and one to the left
            let far = if k >= 2 { product(2) / pivot[k - 2] } else { 0.0 };
            let near = if k >= 1 {
                let joint = if k >= 2 { far * pivot[k - 2] * below[0][k - 1] } else { 0.0 };
                (product(1) - joint) / pivot[k - 1]
            } else {
                0.0
            };
            below[0][k] = near;
            below[1][k] = far;
            let mut rest = 1.0 / stiffness + own;
            if k >= 1 {
                rest -= near * near * pivot[k - 1];
            }
            if k >= 2 {
                rest -= far * far * pivot[k - 2];
            }
            pivot[k] = rest;
        }
        System { slope, inverse_cell, pivot, below }
    }

    fn smooth(&self, mut z: Vec<f64>) -> Vec<f64> {
        let inner = self.pivot.len();
        let mut g: Vec<f64> =
            (0..inner).map(|k| (z[k + 2] - z[k + 1]) * self.slope[k + 1] - (z[k + 1] - z[k]) * self.slope[k]).collect();
        for k in (1..inner).asking(5) {
            g[k] -= self.below[0][k] * g[k - 1];
            if k >= 2 {
                g[k] -= self.below[1][k] * g[k - 2];
            }
        }
        g.iter_mut().zip(&self.pivot).for_each(|(g, pivot)| *g /= pivot);
        for k in (0..inner).rev().asking(5) {
            if k + 1 < inner {
                g[k] -= self.below[0][k + 1] * g[k + 1];
            }
            if k + 2 < inner {
                g[k] -= self.below[1][k + 2] * g[k + 2];
            }
        }
        for (k, g) in g.iter().enumerate() {
            z[k] -= self.inverse_cell[k] * self.slope[k] * g;
            z[k + 1] += self.inverse_cell[k + 1] * (self.slope[k] + self.slope[k + 1]) * g;
            z[k + 2] -= self.inverse_cell[k + 2] * self.slope[k + 1] * g;
        }
        z
    }
}
