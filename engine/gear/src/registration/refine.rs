//! Damped least squares from a place of a search.

use nalgebra::{DMatrix, DVector};

use super::search::{CAP, Candidate, Search};
use crate::deviation::foot::normal;
use flankfit_numerics::{cancel, quantiles::median};

const MOST_STEPS: usize = 25;
/// Least eigenvalue, over the greatest, of a direction that refinement moves along (columns of unit
/// length): what is weaker is the business of the fit and its regularisation.
const LEAST_EIGENVALUE: f64 = 1e-3;

impl Search<'_> {
    /// Damped least squares from coefficients, every point at the nearest flank after each step.
    pub(super) fn refined(&self, from: Vec<f64>) -> Candidate {
        let mut place = Candidate { cost: self.cost(&from), p: from };
        for _ in 0..MOST_STEPS {
            cancel::checkpoint();
            let Some(step) = self.step(&place.p) else { break };
            let mut factor = 1.0;
            let better = (0..4).find_map(|_| {
                let p: Vec<f64> = place.p.iter().zip(&step).map(|(p, s)| p + factor * s).collect();
                factor *= 0.5;
                let sane = self.pose(&p).is_sane();
                let cost = if sane { self.cost(&p) } else { f64::INFINITY };
                (cost < place.cost).then_some(Candidate { p, cost })
            });
            let Some(better) = better else { break };
            let done = better.cost > place.cost * (1.0 - 1e-9);
            place = better;
            if done {
                break;
            }
        }
        place
    }

    /// Mean square of distances; those of points without a foot count as the farthest.
    pub(super) fn cost(&self, p: &[f64]) -> f64 {
        let undoing = self.pose(p).undoing();
        // where the flank is known, the way to it is never too far
        let cap = if self.named { self.gear.base_radius() } else { CAP * self.module() };
        let each = self.points.iter().map(|touch| {
            let distance = self.nearest(&undoing, touch).map_or(cap, |foot| foot.distance.abs().min(cap));
            distance * distance
        });
        each.sum::<f64>() / self.points.len().max(1) as f64
    }

    /// The step of least squares in which far points count less (Huber at twice the scale); `None`
    /// where no point determines one.
    fn step(&self, p: &[f64]) -> Option<Vec<f64>> {
        let (columns, undoing) = (&self.freedom.columns, self.pose(p).undoing());
        let (mut rows, mut distances) = (Vec::new(), Vec::new());
        for touch in &self.points {
            let Some(foot) = self.nearest(&undoing, touch) else { continue };
            let normal = normal(self.gear, foot.tooth, foot.side, foot.roll_length, foot.z);
            let other = undoing.columns(&touch.point, &normal);
            rows.push(columns.iter().map(|c| self.freedom.entry(*c, foot.side, &other, 0.0)).collect::<Vec<f64>>());
            distances.push(1e3 * foot.distance);
        }
        let scale = 1.4826 * median(&mut distances.iter().map(|d| d.abs()).collect::<Vec<f64>>());
        let n = columns.len();
        let (mut square, mut right) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
        for (row, d) in rows.iter().zip(&distances) {
            let weight = if d.abs() > 2.0 * scale { 2.0 * scale / d.abs() } else { 1.0 };
            for i in 0..n {
                right[i] += weight * row[i] * d;
                for j in 0..n {
                    square[(i, j)] += weight * row[i] * row[j];
                }
            }
        }
        let lengths: Vec<f64> = (0..n).map(|i| square[(i, i)].sqrt()).collect();
        if !lengths.iter().all(|length| *length > 0.0 && length.is_finite()) {
            return None;
        }
        for i in 0..n {
            right[i] /= lengths[i];
            for j in 0..n {
                square[(i, j)] /= lengths[i] * lengths[j];
            }
        }
        let eigen = square.symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let mut step = vec![0.0; n];
        for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > LEAST_EIGENVALUE * most) {
            let along = eigen.eigenvectors.column(k).dot(&right) / value;
            for i in 0..n {
                step[i] += along * eigen.eigenvectors[(i, k)] / lengths[i];
            }
        }
        Some(step)
    }
}
