//! Least rank dispersion with normal scores (van der Waerden).
//!
//! `D = Σ a(R(rₖ)) rₖ`, `a(i) = Φ⁻¹(i/(m + 1))`: as efficient as least squares at normal errors,
//! and more at all others (Chernoff and Savage 1958). The scores of the ends grow with the number
//! of nodes, so a gross error keeps some pull, unlike with Wilcoxon's.
//!
//! D is convex and piecewise linear, but its scores are no sum over pairs, so that its corners
//! cannot be walked along as in [`super::rank`]. It is minimised by a proximal bundle method
//! (Lemaréchal; Kiwiel 1990): the greatest of the planes that touch D at places seen before, plus
//! `|d|²/(2t)`, has its least value at the next place. The predicted descent `t|g|² + ε`, g and ε
//! being the combined slope and error of the planes, bounds what can still be gained near the
//! place; it ends when that is 1e-13 of D.
//!
//! Standard errors: `τ² (XᵀX)⁻¹`, `1/τ = ∫ f²/φ(Φ⁻¹(F))`, which is how fast the slope of D changes
//! (Jurečková 1971): measured by moving the estimate one standard error along each coefficient.
//! The constant is set by the median, as in [`super::rank`].

use super::{
    exact,
    outcome::{Along, Measured, Outcome, Solved},
    rank::{Free, constant},
    rows::{Rows, dot},
    spacing::{sparsity_at_median, tau},
};
use crate::{
    error::FitError,
    result::{LocalSolution, Warning},
};
use flankfit_numerics::{cancel, distribution::normal, order::ordered};

/// Places at most.
const STEPS: usize = 600;
/// Planes kept.
const PLANES: usize = 60;
/// Predicted descent at which it ends, as a share of D.
const STILL: f64 = 1e-13;

pub(super) fn estimate(measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let constant = constant(&rows);
    let free = Free::new(&rows, constant.as_deref());
    let dispersion = Dispersion::new(&free);
    let walk = dispersion.minimise();
    let (x, residuals) = free.levelled(&walk.x, &rows, constant.as_deref());
    let mut warnings = Vec::new();
    if !walk.converged {
        warnings.push(Warning::DispersionStopped);
    }
    let tau = dispersion.tau(&walk.x, n);
    let settled = exact::settled(tau, tau.filter(|_| m > n), &residuals, n, measured.heights.largest, &mut warnings);
    let scale = settled.scale.unwrap_or(0.0);
    let scores = dispersion.scores_of(&residuals);
    let weight = |(a, r): (&f64, &f64)| if *r == 0.0 { 1.0 } else { (scale * (a / r).abs()).min(1.0) };
    let weights = settled.weights.unwrap_or_else(|| scores.iter().zip(&residuals).map(weight).collect());
    let along = constant.filter(|_| settled.dispersion.is_some()).and_then(|direction| {
        let size = sparsity_at_median(&ordered(&residuals).sorted, n)?;
        Some(Along { direction, dispersion: 0.5 * size })
    });
    Ok(Outcome {
        solved: Solved::Step(x),
        converged: walk.converged,
        iterations: walk.steps,
        tolerance_reached: Some(walk.reached),
        scale: settled.scale,
        objective: dot(&scores, &residuals),
        weights,
        dispersion: settled.dispersion,
        along,
        local: LocalSolution::Global,
        warnings,
        ..Outcome::default()
    })
}

struct Dispersion<'a> {
    free: &'a Free<'a>,
    /// Scores of the ranks, ascending.
    scores: Vec<f64>,
}

struct Walk {
    x: Vec<f64>,
    steps: usize,
    converged: bool,
    /// Predicted descent as a share of D.
    reached: f64,
}

impl<'a> Dispersion<'a> {
    fn new(free: &'a Free<'a>) -> Self {
        let m = free.count();
        let scores = (1..=m).map(|i| -normal::upper_quantile(i as f64 / (m + 1) as f64)).collect();
        Dispersion { free, scores }
    }

    /// D and a slope of it.
    fn at(&self, x: &[f64]) -> (f64, Vec<f64>) {
        cancel::checkpoint();
        let r = self.free.residuals(x);
        let mut slope = vec![0.0; self.free.n];
        let mut sum = 0.0;
        let order = ordered(&r);
        for ((&k, r), a) in order.from.iter().zip(&order.sorted).zip(&self.scores) {
            sum += a * r;
            slope.iter_mut().zip(self.free.row(k as usize)).for_each(|(g, q)| *g -= a * q);
        }
        (sum, slope)
    }

    /// The score of each residual.
    fn scores_of(&self, r: &[f64]) -> Vec<f64> {
        let mut scores = vec![0.0; r.len()];
        ordered(r).from.iter().zip(&self.scores).for_each(|(&k, a)| scores[k as usize] = *a);
        scores
    }

    fn minimise(&self) -> Walk {
        let n = self.free.n;
        let mut walk = Walk { x: vec![0.0; n], steps: 0, converged: true, reached: 0.0 };
        let (mut here, slope) = self.at(&walk.x);
        // about the inverse of the curvature
        let mut t = tau(&ordered(&self.free.residuals(&walk.x)).sorted, n).unwrap_or(0.0);
        if n == 0 || !(t > 0.0) || here <= 0.0 {
            return walk;
        }
        let mut bundle = Bundle { slopes: vec![slope], errors: vec![0.0], shares: vec![1.0] };
        walk.converged = false;
        let mut idle = 0;
        while walk.steps < STEPS && !walk.converged {
            walk.steps += 1;
            bundle.settle(t);
            let (slope, error) = bundle.combined();
            let descent = t * dot(&slope, &slope) + error;
            walk.reached = descent / here;
            if descent <= STILL * here {
                walk.converged = true;
                break;
            }
            let step: Vec<f64> = slope.iter().map(|g| -t * g).collect();
            let next: Vec<f64> = walk.x.iter().zip(&step).map(|(x, d)| x + d).collect();
            let (there, slope) = self.at(&next);
            if here - there >= 0.1 * descent {
                bundle.moved(&step, there - here);
                bundle.add(slope, 0.0);
                if here - there > 0.7 * descent && idle == 0 {
                    t *= 1.5;
                }
                (walk.x, here, idle) = (next, there, 0);
            } else {
                let error = here - there + dot(&slope, &step);
                bundle.add(slope, error.max(0.0));
                idle += 1;
                if idle % (2 * n + 2) == 0 {
                    t *= 0.5;
                }
            }
        }
        walk
    }

    /// τ by the change of the slope over a standard error to either side; `None` where the slope
    /// does not change.
    fn tau(&self, x: &[f64], coefficients: usize) -> Option<f64> {
        let (m, n) = (self.free.count(), self.free.n);
        if m <= coefficients + 1 || m < 3 || n == 0 {
            return None;
        }
        let width = tau(&ordered(&self.free.residuals(x)).sorted, coefficients)?;
        let mut change = 0.0;
        for j in 0..n {
            let mut beside = x.to_vec();
            let mut slope = |shift: f64| {
                beside[j] = x[j] + shift;
                self.at(&beside).1[j]
            };
            change += (slope(width) - slope(-width)) / (2.0 * width);
        }
        let found = n as f64 / change * (m as f64 / (m - coefficients) as f64).sqrt();
        (found.is_finite() && found > 0.0).then_some(found)
    }
}

/// Planes that touch D: slope, how far below D they are at the present place, and share in the
/// combination.
struct Bundle {
    slopes: Vec<Vec<f64>>,
    errors: Vec<f64>,
    shares: Vec<f64>,
}

impl Bundle {
    /// The shares of least `t/2 |Σλg|² + Σλe`, by exchange between the two planes that violate the
    /// conditions most.
    fn settle(&mut self, t: f64) {
        let count = self.slopes.len();
        let product = |i: usize, j: usize| t * dot(&self.slopes[i], &self.slopes[j]);
        let gram: Vec<f64> = (0..count * count).map(|at| product(at / count, at % count)).collect();
        let mut gradient: Vec<f64> = (0..count)
            .map(|i| self.errors[i] + (0..count).map(|j| gram[i * count + j] * self.shares[j]).sum::<f64>())
            .collect();
        let size = gradient.iter().map(|g| g.abs()).fold(0.0, f64::max);
        for _ in 0..200 * count {
            let low = (0..count).fold(0, |a, b| if gradient[b] < gradient[a] { b } else { a });
            let worst = (0..count)
                .filter(|&j| self.shares[j] > 0.0)
                .fold(low, |a, b| if gradient[b] > gradient[a] { b } else { a });
            let gap = gradient[worst] - gradient[low];
            if gap <= 1e-15 * size {
                break;
            }
            let bend = gram[low * count + low] + gram[worst * count + worst] - 2.0 * gram[low * count + worst];
            let step = if bend > 0.0 { (gap / bend).min(self.shares[worst]) } else { self.shares[worst] };
            self.shares[low] += step;
            self.shares[worst] = if step == self.shares[worst] { 0.0 } else { self.shares[worst] - step };
            for (i, g) in gradient.iter_mut().enumerate() {
                *g += step * (gram[i * count + low] - gram[i * count + worst]);
            }
        }
    }

    fn combined(&self) -> (Vec<f64>, f64) {
        let mut slope = vec![0.0; self.slopes[0].len()];
        for (g, share) in self.slopes.iter().zip(&self.shares) {
            slope.iter_mut().zip(g).for_each(|(s, g)| *s += share * g);
        }
        (slope, dot(&self.errors, &self.shares))
    }

    /// The place moves by `step`, where D rises by `rise`.
    fn moved(&mut self, step: &[f64], rise: f64) {
        for (error, slope) in self.errors.iter_mut().zip(&self.slopes) {
            *error = (*error + rise - dot(slope, step)).max(0.0);
        }
    }

    /// Another plane; where there are too many, those without a share go, and if all have one they
    /// are put together.
    fn add(&mut self, slope: Vec<f64>, error: f64) {
        if self.slopes.len() >= PLANES {
            let (combined, combined_error) = self.combined();
            let keep: Vec<usize> = (0..self.slopes.len()).filter(|&i| self.shares[i] > 0.0).collect();
            if keep.len() < PLANES - 1 {
                self.slopes = keep.iter().map(|&i| std::mem::take(&mut self.slopes[i])).collect();
                self.errors = keep.iter().map(|&i| self.errors[i]).collect();
                self.shares = keep.iter().map(|&i| self.shares[i]).collect();
            } else {
                (self.slopes, self.errors, self.shares) = (vec![combined], vec![combined_error], vec![1.0]);
            }
        }
        self.slopes.push(slope);
        self.errors.push(error);
        self.shares.push(0.0);
    }
}
