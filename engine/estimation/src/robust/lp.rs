//! Least `Σ |rₖ|^p` for 1 < p ≤ 2, `rₖ = √wₖ (zₖ − xₖᵀA)`. (p = 1 is [`super::least_absolute`], p =
//! 2 least squares.)
//!
//! ρ = |r|^p, ψ = p |r|^(p−1) sign r, weight |r|^(p−2), in powers of the unit of the heights. ρ has
//! no second derivative at 0, so `(r² + ε²)^{p/2}` is minimised by Newton's method with halved
//! steps (the function is convex and smooth, so this converges from anywhere), and ε falls step by
//! step to the rounding of the heights.
//!
//! Standard errors: `E ψ²/(E ψ′)² (XᵀX)⁻¹` with `ψ² ∝ |r|^{2p−2}`, `ψ′ ∝ (p−1)|r|^{p−2}` (Nyquist
//! 1983; Gonin and Money 1989).

use super::{
    exact,
    outcome::{Measured, Outcome, Solved},
    rows::{Rows, dot, weighted_solution},
    scale::{NORMAL_QUARTILE, median_abs},
};
use crate::{
    error::FitError,
    result::{LocalSolution, Warning},
};
use flankfit_numerics::cancel::{self, Asking};

/// Newton steps for one ε.
const STEPS: usize = 60;
/// Share of the sum below which its rounding hides whether a step was good.
const FINE: f64 = 1e-10;
/// A last step that moves no residual by more than this share of the largest counts as none.
const STILL: f64 = 1e-10;
/// From here on residuals do not follow ε all the way down: one value need not be settled before
/// the next.
const EASY: f64 = 1.1;

/// ε falls by this factor; the slower the nearer p is to 1, where tiny residuals follow it all the
/// way down.
fn fall(p: f64) -> f64 {
    match p {
        _ if p < EASY => 0.75,
        _ if p < 1.4 => 0.5,
        _ => 0.25,
    }
}

/// The coefficients of least sum, as a step from least squares.
pub(super) struct Walk {
    pub x: Vec<f64>,
    pub residuals: Vec<f64>,
    pub iterations: usize,
    pub converged: bool,
    /// The last change of residuals, relative to the largest.
    reached: f64,
}

impl Walk {
    pub(super) fn warnings(&self) -> Vec<Warning> {
        let (iterations, reached) = (self.iterations, self.reached);
        (!self.converged)
            .then_some(Warning::NewtonNotConverged { iterations, relative_change: reached })
            .into_iter()
            .collect()
    }
}

/// Least `Σ |r|^p` for p > 1; `highest` is the largest height.
pub(super) fn minimise(p: f64, rows: &Rows, highest: f64) -> Walk {
    let n = rows.n;
    let largest = rows.b.iter().map(|b| b.abs()).fold(0.0, f64::max);
    let floor = (f64::EPSILON * highest).max(1e-14 * largest).max(f64::MIN_POSITIVE);
    let mut x = vec![0.0; n];
    let mut r = rows.b.clone();
    // above p = 2 the second derivative is smooth
    let mut epsilon = if p > 2.0 { floor } else { median_abs(&r).max(floor) };
    let (mut iterations, mut reached, mut converged) = (0, 0.0, true);
    if largest > f64::EPSILON * highest && p != 2.0 {
        loop {
            let smoothed = |r: &[f64]| Smoothed::new(p, epsilon / largest, largest, r);
            let mut here = smoothed(&r);
            let mut last = f64::INFINITY;
            converged = false;
            let passing = p >= EASY && epsilon > floor;
            for _ in 0..STEPS {
                cancel::checkpoint();
                iterations += 1;
                let Some((step, decrement)) = here.newton(rows, &r) else { break };
                // near the solution the sum has no digits left to compare steps: Newton's own
                // measure continues to fall
                let fine = decrement <= FINE * here.sum;
                if decrement <= 1e-30 * here.sum || fine && decrement > 0.25 * last {
                    converged = fine;
                    break;
                }
                last = if fine { decrement } else { f64::INFINITY };
                let along: Vec<f64> = rows.q.chunks_exact(n).asking(n).map(|q| dot(q, &step)).collect();
                let mut length = 1.0;
                let mut next = moved(&r, &along, length);
                let settled = fine && passing;
                let mut there = if settled { None } else { Some(smoothed(&next)) };
                while let Some(found) = &there
                    && !fine
                    && length > 1e-12
                    && found.sum >= here.sum - 1e-4 * length * decrement
                {
                    length *= 0.5;
                    next = moved(&r, &along, length);
                    there = Some(smoothed(&next));
                }
                reached = length * along.iter().map(|a| a.abs()).fold(0.0, f64::max) / largest;
                r = next;
                x.iter_mut().zip(&step).for_each(|(x, d)| *x += length * d);
                match there {
                    Some(found) => here = found,
                    None => break,
                }
            }
            // for p near 1 tiny residuals carry whole duals: there it ends when nothing moves any
            // more
            converged |= reached <= STILL;
            r = rows.residuals(&x);
            if epsilon <= floor {
                break;
            }
            epsilon = (epsilon * fall(p)).max(floor);
        }
    }
    Walk { x, residuals: r, iterations, converged, reached }
}

pub(super) fn estimate(p: f64, measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let walk = minimise(p, &rows, measured.heights.largest);
    let r = &walk.residuals;
    let scale = median_abs(r) / NORMAL_QUARTILE;
    let mut warnings = walk.warnings();
    let tau = dispersion(p, r, m, n, scale);
    let settled = exact::settled(Some(scale), tau, r, n, measured.heights.largest, &mut warnings);
    let weight = |r: &f64| (r.abs() / scale).max(1.0).powf(p - 2.0);
    let weights = settled.weights.unwrap_or_else(|| r.iter().asking(50).map(weight).collect());
    Ok(Outcome {
        warnings,
        converged: walk.converged,
        iterations: walk.iterations,
        tolerance_reached: Some(walk.reached),
        scale: settled.scale,
        objective: r.iter().asking(50).map(|r| r.abs().powf(p)).sum(),
        weights,
        dispersion: settled.dispersion,
        local: LocalSolution::Global,
        solved: Solved::Step(walk.x),
        ..Outcome::default()
    })
}

fn moved(r: &[f64], along: &[f64], length: f64) -> Vec<f64> {
    r.iter().zip(along).map(|(r, a)| r - length * a).collect()
}

/// The smoothed sum at one place, in heights divided by `largest`.
struct Smoothed {
    p: f64,
    /// ε.
    epsilon: f64,
    largest: f64,
    /// `(r² + ε²)^{(p−2)/2}` of each residual: all that takes a power.
    powers: Vec<f64>,
    sum: f64,
}

impl Smoothed {
    fn new(p: f64, epsilon: f64, largest: f64, r: &[f64]) -> Self {
        let squared = |r: f64| (r / largest).powi(2) + epsilon * epsilon;
        let half = 0.5 * (p - 2.0);
        let powers: Vec<f64> = r.iter().asking(50).map(|&r| squared(r).powf(half)).collect();
        let sum = powers.iter().zip(r).map(|(power, &r)| power * squared(r)).sum();
        Smoothed { p, epsilon, largest, powers, sum }
    }

    /// Newton's step, and what it promises to gain (doubled).
    fn newton(&self, rows: &Rows, r: &[f64]) -> Option<(Vec<f64>, f64)> {
        let Smoothed { p, epsilon, largest, .. } = *self;
        let square = epsilon * epsilon;
        let share = |u: f64| 1.0 + (p - 2.0) * (u * u / (u * u + square));
        let curvature: Vec<f64> =
            r.iter().zip(&self.powers).asking(20).map(|(r, power)| p * power * share(r / largest)).collect();
        let target: Vec<f64> = r.iter().asking(20).map(|r| r / share(r / largest)).collect();
        let step = weighted_solution(rows.n, &rows.q, &curvature, &target)?;
        let decrement = rows
            .q
            .chunks_exact(rows.n)
            .zip(&curvature)
            .asking(rows.n)
            .map(|(q, h)| {
                let along = dot(q, &step) / largest;
                h * along * along
            })
            .sum();
        Some((step, decrement))
    }
}

/// τ. The mean of `|r|^{p−2}` hangs on the smallest residuals and has no variance for p ≤ 1.5, so
/// below the k-th smallest, δ, the density is taken as even: there the mean is `δ^{p−2}/(p−1)`.
/// Near p = 1 n residuals are 0 by the fit itself and do not count. For p > 2 few residuals make
/// the mean, and the fit follows them: there Huber's factor for few nodes (1981, section 7.6)
/// widens τ.
pub(super) fn dispersion(p: f64, r: &[f64], m: usize, n: usize, scale: f64) -> Option<f64> {
    if m <= n || scale <= 0.0 {
        return None;
    }
    let mut sizes: Vec<f64> = r.iter().map(|r| r.abs()).collect();
    sizes.sort_by(cancel::comparing(f64::total_cmp));
    let k = (n + (m as f64).sqrt().ceil() as usize).min(m);
    let (near, far) = sizes.split_at(k);
    let edge = near[k - 1];
    let inside = (k as f64 - n as f64 * (2.0 - p).max(0.0)) * edge.powf(p - 2.0);
    let slope = (inside + (p - 1.0) * far.iter().asking(50).map(|r| r.powf(p - 2.0)).sum::<f64>()) / m as f64;
    let squares = sizes.iter().asking(50).map(|r| r.powf(2.0 * p - 2.0)).sum::<f64>() / (m - n) as f64;
    let correction = if p > 2.0 {
        let slopes = || sizes.iter().asking(50).map(|r| r.powf(p - 2.0));
        let mean = slopes().sum::<f64>() / m as f64;
        let variance = slopes().map(|x| (x - mean).powi(2)).sum::<f64>() / m as f64;
        1.0 + n as f64 / m as f64 * variance / (mean * mean)
    } else {
        1.0
    };
    let dispersion = squares.sqrt() / slope * correction;
    (dispersion.is_finite() && dispersion > 0.0).then_some(dispersion)
}
