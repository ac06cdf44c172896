//! Maximum likelihood for errors of Student's, Laplace's and the generalised normal distribution,
//! `rₖ = √wₖ (zₖ − xₖᵀA)`.
//!
//! | errors | coefficients at a given shape | scale |
//! |---|---|---|
//! | Student, ν | reweighting by (ν + 1)/(ν + u²), u = r/s (EM) | s² = Σωr²/Σω (PX-EM) |
//! | generalised normal, p | least Σ abs(r)^p ([`super::lp`]) | a^p = p Σ abs(r)^p/m |
//! | Laplace | p = 1 | b = Σ abs(r)/m |
//!
//! A shape that is not given has the greatest profile likelihood: a scan of its range, then the
//! root of the derivative near the best place. (By the envelope theorem that is the derivative at
//! fixed coefficients and scale.) Its standard error is from the Fisher information of scale and
//! shape (Lange, Little and Taylor 1989; for the generalised normal from the moments of T =
//! (|r|/a)^p, which has the gamma distribution of shape 1/p); at an end of the range there is none.
//! Shape and scale are separated from the coefficients by symmetry, so that estimating them costs
//! the coefficients nothing in the limit. With few nodes it does: coefficients move with the
//! exponent, and the likeliest one is among those that make the residuals look least spread. τ² of
//! an estimated exponent is therefore a mean over the exponents, weighed by their profile
//! likelihood and even in their logarithm, of τ² and of how far the coefficients lie from those of
//! the likeliest one (the law of total variance).
//!
//! Standard errors of coefficients: `τ² (XᵀX)⁻¹` with `τ² = E ψ²/(E ψ′)²`, the limit whatever the
//! errors are distributed like. (The inverse of the Fisher information is not: with normal
//! errors it makes the standard errors of Laplace's estimate a third too small.)

use std::f64::consts::PI;

use super::{
    exact, least_absolute, lp,
    outcome::{Measured, Outcome, Slopes, Solved},
    rows::{Rows, weighted_solution},
    scale::{NORMAL_QUARTILE, median_abs},
};
use crate::{
    error::FitError,
    result::{LikelihoodReport, LocalSolution, Warning},
    spec::Distribution,
};
use flankfit_numerics::{
    cancel::{self, Asking},
    distribution::gamma::{digamma, trigamma},
    root::root,
};

/// Reweightings for one ν.
const STEPS: usize = 2_000;
/// They end when nothing moves by more than this many scales.
const STILL: f64 = 1e-13;
/// Places at which the profile is looked at.
const PLACES: usize = 12;
/// Least estimated ν, over n/(m − n), below which the likelihood has no bound.
const BOUNDED: f64 = 4.0;

pub(super) fn estimate(distribution: Distribution, measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let start = match distribution {
        Distribution::Student { .. } => least_absolute::at(0.5, &rows)?.vertex.x,
        Distribution::Laplace | Distribution::GeneralizedNormal { .. } => Vec::new(),
    };
    let problem = Problem { rows: &rows, largest: measured.heights.largest, start };
    let (m, n) = (rows.count(), rows.n);
    let (shape, range) = match distribution {
        Distribution::Student { freedom } => (freedom, freedom_range(m, n)),
        Distribution::Laplace => (Some(1.0), Distribution::EXPONENT),
        Distribution::GeneralizedNormal { exponent } => (exponent, Distribution::EXPONENT),
    };
    let at = |shape: f64| match distribution {
        Distribution::Student { .. } => problem.student(shape),
        _ => problem.generalized(shape),
    };
    let tau = |shape: f64, found: &AtShape| match distribution {
        Distribution::Student { .. } => student_tau(shape, &found.residuals, found.scale, n),
        _ => generalized_tau(shape, found, n),
    };
    let (shape, found, inside, tau) = match shape {
        Some(shape) => {
            let found = at(shape)?;
            let tau = tau(shape, &found);
            (shape, found, false, tau)
        }
        None => likeliest(range, distribution, n, at, tau)?,
    };
    let count = m as f64;
    let jacobian: f64 = (0..m).map(|k| 0.5 * libm::log(measured.sample.w(k))).sum();
    let tau = tau.filter(|_| m > n);
    let bound = at_bound(distribution, shape, range);
    let weights = weights(distribution, shape, &found);
    let is_student = matches!(distribution, Distribution::Student { .. });
    let slopes = is_student.then(|| student_slopes(shape, &found.residuals, found.scale, n));
    let mut warnings = found.warnings;
    let settled = exact::settled(Some(found.scale), tau, &found.residuals, n, problem.largest, &mut warnings);
    let weights = settled.weights.unwrap_or(weights);
    warnings.extend(bound.filter(|_| settled.dispersion.is_some()));
    let known = settled.dispersion.is_some();
    Ok(Outcome {
        solved: Solved::Step(found.x),
        converged: found.converged,
        iterations: found.iterations,
        scale: settled.scale,
        // an exact fit has no likelihood
        objective: if known { -(found.log_likelihood + jacobian) } else { 0.0 },
        weights,
        dispersion: settled.dispersion,
        slopes,
        local: if found.convex { LocalSolution::Global } else { LocalSolution::FromStart },
        likelihood: known.then(|| LikelihoodReport {
            shape: (distribution != Distribution::Laplace).then_some(shape),
            shape_std_error: (inside && m > n).then(|| (found.shape_variance / count).sqrt()),
            log_likelihood: found.log_likelihood + jacobian,
        }),
        warnings,
        ..Outcome::default()
    })
}

/// ν that can be found. Where the coefficients leave few nodes free a small ν makes the n nodes
/// that they fit exactly likelier than all others: at n/(m − n) without bound.
fn freedom_range(m: usize, n: usize) -> [f64; 2] {
    let [low, high] = Distribution::FREEDOM;
    let free = m.saturating_sub(n).max(1) as f64;
    [low.max(BOUNDED * n as f64 / free).min(high), high]
}

/// An estimated shape at an end of its range, but ν at its upper end: there errors are normal.
fn at_bound(distribution: Distribution, shape: f64, [low, high]: [f64; 2]) -> Option<Warning> {
    match distribution {
        Distribution::Student { freedom: None } => {
            (low < high && shape <= low).then_some(Warning::FreedomAtBound { degrees_of_freedom: shape })
        }
        Distribution::GeneralizedNormal { exponent: None } => {
            (shape <= low || shape >= high).then_some(Warning::ExponentAtBound { exponent: shape })
        }
        _ => None,
    }
}

/// Final factor of each node's weight.
fn weights(distribution: Distribution, shape: f64, found: &AtShape) -> Vec<f64> {
    let r = &found.residuals;
    if let Distribution::Student { .. } = distribution {
        return r.iter().map(|r| shape / (shape + (r / found.scale).powi(2))).collect();
    }
    let scale = median_abs(r) / NORMAL_QUARTILE;
    r.iter().asking(50).map(|r| libm::pow((r.abs() / scale).max(1.0), shape.min(2.0) - 2.0)).collect()
}

/// The estimate at one shape.
struct AtShape {
    x: Vec<f64>,
    residuals: Vec<f64>,
    scale: f64,
    /// 1/f(0), of least absolute deviations.
    sparsity: Option<f64>,
    log_likelihood: f64,
    /// Derivative of the profile likelihood by the shape, divided by m.
    slope: f64,
    /// m times the asymptotic variance of an estimated shape.
    shape_variance: f64,
    convex: bool,
    converged: bool,
    iterations: usize,
    warnings: Vec<Warning>,
}

/// The shape of greatest likelihood, the estimate there, whether it lies inside the range, and τ.
fn likeliest(
    [low, high]: [f64; 2],
    distribution: Distribution,
    n: usize,
    at: impl Fn(f64) -> Result<AtShape, FitError>,
    tau: impl Fn(f64, &AtShape) -> Option<f64>,
) -> Result<(f64, AtShape, bool, Option<f64>), FitError> {
    let place = |i: usize| low * libm::pow(high / low, i as f64 / (PLACES - 1) as f64);
    let mut best = 0;
    let scan: Vec<AtShape> = (0..PLACES).map(|i| at(place(i))).collect::<Result<_, _>>()?;
    for (i, found) in scan.iter().enumerate() {
        if found.log_likelihood > scan[best].log_likelihood {
            best = i;
        }
    }
    let sides = [best.saturating_sub(1), (best + 1).min(PLACES - 1)];
    let ends = sides.map(|i| (place(i), scan[i].slope));
    let slope = |shape: f64| at(shape).map_or(f64::NAN, |found| found.slope);
    let inside = ends[0].1 > 0.0 && ends[1].1 < 0.0;
    let shape =
        if inside { root(ends, |shape| 1e-12 * shape, slope).unwrap_or_else(|| place(best)) } else { place(best) };
    let found = at(shape)?;
    let mut own = tau(shape, &found);
    if matches!(distribution, Distribution::GeneralizedNormal { .. }) {
        let parts = scan.iter().enumerate().map(|(i, other)| (place(i), other));
        own = own.map(|own| total_variance(parts, &found, n, tau).map_or(own, f64::sqrt));
    }
    Ok((shape, found, inside, own))
}

/// Mean over the scan, weighed by likelihood, of τ² and of the squared way from `found` in each of
/// the n directions; `None` where nothing of it is known.
fn total_variance<'a>(
    scan: impl Iterator<Item = (f64, &'a AtShape)>,
    found: &AtShape,
    n: usize,
    tau: impl Fn(f64, &AtShape) -> Option<f64>,
) -> Option<f64> {
    let (mut weights, mut sum) = (0.0, 0.0);
    for (shape, other) in scan {
        let weight = libm::exp(other.log_likelihood - found.log_likelihood);
        if !(weight > 0.0 && weight.is_finite()) {
            continue;
        }
        let Some(tau) = tau(shape, other) else { continue };
        let away: f64 = other.x.iter().zip(&found.x).map(|(a, b)| (a - b).powi(2)).sum();
        weights += weight;
        sum += weight * (tau * tau + away / n as f64);
    }
    Some(sum / weights).filter(|variance| *variance > 0.0 && variance.is_finite())
}

struct Problem<'a> {
    rows: &'a Rows,
    /// The largest height.
    largest: f64,
    /// Least absolute deviations, from where reweighting starts.
    start: Vec<f64>,
}

impl Problem<'_> {
    fn mean(&self, values: impl Iterator<Item = f64>) -> f64 {
        values.sum::<f64>() / self.rows.count() as f64
    }

    fn student(&self, nu: f64) -> Result<AtShape, FitError> {
        let Rows { n, q, b } = self.rows;
        let count = self.rows.count() as f64;
        let mut x = self.start.clone();
        let mut r = self.rows.residuals(&x);
        let mut s = match median_abs(&r) / NORMAL_QUARTILE {
            0.0 => self.mean(r.iter().map(|r| r.abs())),
            mad => mad,
        };
        let (mut iterations, mut converged) = (0, s <= exact::EXACT * self.largest);
        let mut reached = 0.0;
        let omega = |r: &[f64], s: f64| -> Vec<f64> {
            r.iter().asking(10).map(|r| (nu + 1.0) / (nu + (r / s).powi(2))).collect()
        };
        while iterations < STEPS && !converged {
            cancel::checkpoint();
            iterations += 1;
            let weights = omega(&r, s);
            let Some(next) = weighted_solution(*n, q, &weights, b) else { break };
            let residuals = self.rows.residuals(&next);
            let squares: f64 = residuals.iter().zip(&weights).map(|(r, w)| w * r * r).sum();
            let scale = (squares / weights.iter().sum::<f64>()).sqrt();
            let moved = r.iter().zip(&residuals).map(|(a, b)| (a - b).abs()).fold((scale - s).abs(), f64::max);
            (x, r, s, reached) = (next, residuals, scale, moved / scale);
            converged =
                reached <= STILL || moved <= 8.0 * f64::EPSILON * self.largest || s <= exact::EXACT * self.largest;
        }
        let u2: Vec<f64> = r.iter().map(|r| (r / s).powi(2)).collect();
        let constant = libm::lgamma(0.5 * (nu + 1.0)) - libm::lgamma(0.5 * nu) - 0.5 * libm::log(nu * PI);
        let logs = self.mean(u2.iter().asking(20).map(|u2| libm::log1p(u2 / nu)));
        let pulls = self.mean(u2.iter().map(|u2| (nu + 1.0) * u2 / (nu * (nu + u2))));
        let slope = 0.5 * (digamma(0.5 * (nu + 1.0)) - digamma(0.5 * nu) - 1.0 / nu - logs + pulls);
        // Fisher information of s and ν at s = 1
        let of_scale = 2.0 * nu / (nu + 3.0);
        let mixed = -2.0 / ((nu + 1.0) * (nu + 3.0));
        let of_shape = 0.25
            * (trigamma(0.5 * nu) - trigamma(0.5 * (nu + 1.0)) - 2.0 * (nu + 5.0) / (nu * (nu + 1.0) * (nu + 3.0)));
        let warnings = if converged {
            Vec::new()
        } else {
            vec![Warning::WeightsNotConverged { iterations, change_scales: reached }]
        };
        Ok(AtShape {
            log_likelihood: count * (constant - libm::log(s) - 0.5 * (nu + 1.0) * logs),
            slope,
            shape_variance: 1.0 / (of_shape - mixed * mixed / of_scale),
            sparsity: None,
            scale: s,
            x,
            residuals: r,
            convex: false,
            converged,
            iterations,
            warnings,
        })
    }

    fn generalized(&self, p: f64) -> Result<AtShape, FitError> {
        let count = self.rows.count() as f64;
        let (x, r, iterations, converged, warnings, sparsity) = if p == 1.0 {
            let fit = least_absolute::at(0.5, self.rows)?;
            let warnings = fit.warnings();
            (fit.vertex.x, fit.residuals, fit.vertex.steps, fit.vertex.optimal, warnings, fit.sparsity)
        } else {
            let walk = lp::minimise(p, self.rows, self.largest);
            let warnings = walk.warnings();
            (walk.x, walk.residuals, walk.iterations, walk.converged, warnings, None)
        };
        let largest = r.iter().map(|r| r.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let powers: Vec<f64> = r.iter().asking(50).map(|r| libm::pow(r.abs() / largest, p)).collect();
        let share = self.mean(powers.iter().copied());
        let a = largest * libm::pow(p * share, 1.0 / p);
        let alpha = 1.0 / p;
        // T ln T of T = (|r|/a)^p
        let entropy = self.mean(powers.iter().asking(20).map(|power| {
            let t = power / (p * share);
            if t > 0.0 { t * libm::log(t) } else { 0.0 }
        }));
        let constant = libm::log(0.5 * p) - libm::lgamma(alpha);
        // moments of T, gamma of shape α
        let (first, second) = (digamma(alpha + 1.0), digamma(alpha + 2.0));
        let of_entropy = alpha * (alpha + 1.0) * (trigamma(alpha + 2.0) + second * second) - (alpha * first).powi(2);
        let mixed = alpha * (alpha + 1.0) * second - alpha * alpha * first;
        Ok(AtShape {
            log_likelihood: count * (constant - libm::log(a) - alpha),
            slope: alpha + digamma(alpha) * alpha * alpha - entropy / p,
            // Var(T ln T)/p² less the square of −Cov(T, T ln T)/a over p/a²
            shape_variance: 1.0 / (of_entropy / (p * p) - mixed * mixed / p),
            sparsity,
            scale: a,
            x,
            residuals: r,
            convex: true,
            converged,
            iterations,
            warnings,
        })
    }
}

/// τ of the estimate at one exponent.
fn generalized_tau(p: f64, found: &AtShape, n: usize) -> Option<f64> {
    if p == 1.0 {
        return found.sparsity.map(|sparsity| 0.5 * sparsity);
    }
    let r = &found.residuals;
    lp::dispersion(p, r, r.len(), n, median_abs(r) / NORMAL_QUARTILE)
}

/// τ of Student's estimate, by Huber's formula for M-estimators (1981, section 7.6).
fn student_tau(nu: f64, r: &[f64], s: f64, n: usize) -> Option<f64> {
    let m = r.len();
    if m <= n {
        return None;
    }
    let squares: f64 = r.iter().map(|r| r / s).map(|u| ((nu + 1.0) * u / (nu + u * u)).powi(2)).sum();
    let slopes = student_slopes(nu, r, s, n);
    let tau = s * (squares / (m - n) as f64).sqrt() * slopes.k / slopes.mean;
    (slopes.mean > 0.0 && tau.is_finite()).then_some(tau)
}

/// Slopes of ψ, which has the slope (ν + 1)/ν at 0.
fn student_slopes(nu: f64, r: &[f64], s: f64, n: usize) -> Slopes {
    let slope = |u: f64| (nu + 1.0) * (nu - u * u) / (nu + u * u).powi(2);
    Slopes::new(r.iter().map(|r| slope(r / s)), r.len(), n)
}
