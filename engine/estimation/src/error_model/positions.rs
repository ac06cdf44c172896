//! Least squares where the positions of the nodes are off.
//!
//! With `ρ = σ_x/σ_y`, f the surface and g its gradient, node k has the variance
//! `σ²(1/wₖ + ρ²‖g‖²)` of what is left of its height: an error of the position is one of the
//! height, the steeper the surface the larger.
//!
//! * *Nominal* positions were aimed at and missed: the expected height at the place aimed at is
//!   `f(x)` to first order, and weights `Wₖ = 1/(1/wₖ + ρ²‖g‖²)` are all there is to it (effective
//!   variance).
//! * *Measured* positions were hit and read off wrongly. Weights alone would leave the slopes too
//!   flat: the true positions ξ are estimated with the coefficients so that `Σ w(y − f(ξ))² + ‖x −
//!   ξ‖²/ρ²` is least (orthogonal distance regression). About a guess the best ξ follows node by
//!   node from the coefficients, which leaves weighted least squares with rows at ξ, heights `y −
//!   g·(x − ξ)` and the same W (Boggs, Byrd and Schnabel, SIAM J. Sci. Stat. Comput. 8, 1987). At a
//!   fixed point of the iteration the sum is stationary.

use nalgebra::DMatrix;

use crate::{
    data::Sample,
    design::{Boxes, Design},
    spec::PositionKind,
};
use flankfit_numerics::{cancel::Asking, dot, triangular};

/// Steps and changes of positions, in standard errors, at which the iteration ends.
const SETTLED: f64 = 1e-9;
/// … and over the length of the heights, where nothing is left over.
const ROUNDING: f64 = 1e-13;
const ROUNDS: usize = 2000;
/// … and where a round is long: those of so many products of two numbers, some seconds.
const MOST_PRODUCTS: usize = 3_000_000_000;
/// Rounds that there must be time for.
const FEWEST_ROUNDS: usize = 40;
/// Least relaxation factor of steps that grow.
const SLOWEST: f64 = 1.0 / 64.0;

/// Nodes whose positions are off.
pub(crate) struct Positions<'a> {
    pub design: &'a Design,
    pub sample: &'a Sample<'a>,
    pub kind: PositionKind,
    /// ρ.
    pub ratio: f64,
    /// Box that positions may not leave.
    pub within: Option<Boxes>,
    /// R of plain least squares.
    pub r: DMatrix<f64>,
    /// ‖y‖.
    pub length: f64,
}

/// The problem of weighted least squares that the positions lead to, by counted node.
pub(crate) struct Settled {
    pub places: Vec<[f64; 2]>,
    pub heights: Vec<f64>,
    pub weights: Vec<f64>,
    pub rounds: usize,
    /// The share of positions in the variance, on average.
    pub share: f64,
    /// Greatest move of a position.
    pub largest_shift: f64,
}

/// Row, slopes, weight and residual of a node at its present position.
struct Local {
    row: Vec<f64>,
    gradient: [f64; 2],
    weight: f64,
    left: f64,
}

/// Rounds that there is time for with so many nodes and coefficients; `None` where they would not
/// do.
pub(crate) fn rounds(nodes: usize, coefficients: usize) -> Option<usize> {
    let products = nodes.saturating_mul(coefficients).saturating_mul(coefficients + 20).max(1);
    Some((MOST_PRODUCTS / products).min(ROUNDS)).filter(|rounds| *rounds >= FEWEST_ROUNDS)
}

impl Positions<'_> {
    /// From the coefficients of plain least squares in the working basis; `None` where the
    /// iteration does not settle.
    pub(crate) fn settle(&self, start: &[f64]) -> Option<Settled> {
        let (m, n) = (self.sample.count(), self.design.size());
        let posted: Vec<[f64; 2]> = (0..m).map(|k| self.sample.place(k).into()).collect();
        let (mut c, mut places) = (start.to_vec(), posted.clone());
        let (mut relax, mut before) = (1.0f64, f64::INFINITY);
        for round in 1..=rounds(m, n)? {
            let locals: Vec<Local> = (0..m).asking(100 * n).map(|k| self.local(&c, k, posted[k], places[k])).collect();
            let (step, length, rss) = self.step(&locals)?;
            let free = m.saturating_sub(n).max(1) as f64;
            let enough = SETTLED * (rss / free).sqrt() + ROUNDING * self.length;
            if length > before {
                relax = (0.5 * relax).max(SLOWEST);
            }
            before = length;
            let scaled: Vec<f64> = step.iter().map(|x| relax * x).collect();
            c.iter_mut().zip(&scaled).for_each(|(c, x)| *c += x);
            let moved = match self.kind {
                PositionKind::Nominal => 0.0,
                PositionKind::Measured => self.carry(&mut places, &posted, &locals, &scaled, relax),
            };
            if !(length + moved).is_finite() {
                return None;
            }
            if length <= enough && moved <= enough * self.ratio {
                return self.settled(&c, &posted, places, round);
            }
        }
        None
    }

    fn local(&self, c: &[f64], k: usize, [x, y]: [f64; 2], place: [f64; 2]) -> Local {
        let [row, along_u, along_v] = self.design.tangent(place);
        let gradient = [dot(&along_u, c), dot(&along_v, c)];
        let steep = gradient[0] * gradient[0] + gradient[1] * gradient[1];
        let weight = 1.0 / (1.0 / self.sample.w(k) + self.ratio * self.ratio * steep);
        let off = gradient[0] * (x - place[0]) + gradient[1] * (y - place[1]);
        let left = self.sample.z(k) - dot(&row, c) - off;
        Local { row, gradient, weight, left }
    }

    /// The step of the working coefficients, the change of the fit that it makes, and Σ W r².
    fn step(&self, locals: &[Local]) -> Option<(Vec<f64>, f64, f64)> {
        let n = self.design.size();
        let mut gram = DMatrix::<f64>::zeros(n, n);
        let (mut right, mut squares) = (vec![0.0; n], 0.0);
        for Local { row, weight, left, .. } in locals.iter().asking(2 * n * n) {
            let mut q = row.clone();
            triangular::solve_upper_transposed(&self.r, &mut q);
            squares += weight * left * left;
            for (j, &x) in q.iter().enumerate() {
                right[j] += weight * x * left;
                gram.column_mut(j).iter_mut().zip(&q[..=j]).for_each(|(to, y)| *to += weight * x * y);
            }
        }
        let root = triangular::cholesky(&gram)?;
        triangular::solve_upper_transposed(&root, &mut right);
        let length = right.iter().map(|x| x * x).sum::<f64>();
        triangular::solve_upper(&root, &mut right);
        triangular::solve_upper(&self.r, &mut right);
        Some((right, length.sqrt(), (squares - length).max(0.0)))
    }

    /// Carries the positions to where the sum is least; how far the farthest goes.
    fn carry(&self, places: &mut [[f64; 2]], posted: &[[f64; 2]], locals: &[Local], step: &[f64], relax: f64) -> f64 {
        let mut farthest = 0.0f64;
        for ((place, from), Local { row, gradient, weight, left }) in places.iter_mut().zip(posted).zip(locals) {
            let left = self.ratio * self.ratio * weight * (left - dot(row, step));
            for axis in 0..2 {
                let mut target = from[axis] + gradient[axis] * left;
                if let Some((u, v)) = self.within {
                    let [low, high] = if axis == 0 { u } else { v };
                    target = target.clamp(low, high);
                }
                let moved = relax * (target - place[axis]);
                place[axis] += moved;
                farthest = farthest.max(moved.abs());
            }
        }
        farthest
    }

    fn settled(&self, c: &[f64], posted: &[[f64; 2]], places: Vec<[f64; 2]>, rounds: usize) -> Option<Settled> {
        let m = places.len();
        let (mut heights, mut weights) = (Vec::with_capacity(m), Vec::with_capacity(m));
        let (mut share, mut largest) = (0.0, 0.0f64);
        for k in 0..m {
            let Local { row, weight, left, .. } = self.local(c, k, posted[k], places[k]);
            heights.push(dot(&row, c) + left);
            weights.push(weight);
            share += (1.0 - weight / self.sample.w(k)) / m as f64;
            largest = largest.max((places[k][0] - posted[k][0]).hypot(places[k][1] - posted[k][1]));
        }
        let sound = weights.iter().all(|w| *w > 0.0 && w.is_finite()) && heights.iter().all(|z| z.is_finite());
        sound.then_some(Settled { places, heights, weights, rounds, share, largest_shift: largest })
    }
}
