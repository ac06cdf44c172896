//! L-estimators: regression quantiles β(τ) combined, `rₖ(τ) = √wₖ (zₖ − xₖᵀβ(τ))`.
//!
//! * *Trimmed*: least squares of the nodes with rₖ(α) ≥ 0 ≥ rₖ(1 − α), so that those on the two
//!   surfaces stay (Koenker and Bassett 1978; Ruppert and Carroll 1980).
//! * *Winsorized*: least squares of all nodes, the heights of those outside being moved to the
//!   nearer of the two surfaces (Welsh 1987).
//! * *Quantiles*: `Σ wᵢ β(τᵢ)`, Σw = 1 (Koenker and Bassett 1978, theorem 4.2).
//!
//! Standard errors: covariance `τ² (XᵀX)⁻¹` with τ² the variance of the influence of one error, as
//! in the problem of location:
//! * trimmed: `(1 − 2α)⁻² (E c² − (E c)²)`, c the error clamped to the two quantiles ξ₁, ξ₂ (of
//!   Ruppert and Carroll, equation 2.7, by residuals of the estimate);
//! * winsorized: the variance of `c + α(α − [e < ξ₁])/f(ξ₁) + α(1 − α − [e < ξ₂])/f(ξ₂)`;
//! * quantiles: `Σᵢⱼ wᵢwⱼ (min(τᵢ, τⱼ) − τᵢτⱼ)/(f(ξᵢ)f(ξⱼ))`.
//!
//! The densities f are those of [`super::least_absolute`]; sums are over m − n.

use super::{
    exact,
    least_absolute::{self, QuantileFit},
    outcome::{Measured, Outcome, Solved, Weighting},
    rows::{Rows, weighted_solution},
};
use crate::{error::FitError, factor::Factor, result::LocalSolution, spec::LEstimator};
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
};

pub(super) fn estimate(asked: &LEstimator, measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    match asked {
        LEstimator::Trimmed { share } => trimmed(*share, &rows, measured),
        LEstimator::Winsorized { share } => winsorized(*share, &rows, measured),
        LEstimator::Quantiles(weights) => combined(weights.pairs(), &rows, measured),
    }
}

/// Regression quantiles, with what they must be known by together.
struct Quantiles {
    fits: Vec<QuantileFit>,
    steps: usize,
    converged: bool,
    unique: bool,
    certificate: f64,
}

impl Quantiles {
    fn new(taus: impl Iterator<Item = f64>, rows: &Rows) -> Result<Self, FitError> {
        let fits: Vec<QuantileFit> = taus.map(|tau| least_absolute::at(tau, rows)).collect::<Result<_, _>>()?;
        Ok(Quantiles {
            steps: fits.iter().map(|fit| fit.vertex.steps).sum(),
            converged: fits.iter().all(|fit| fit.vertex.optimal),
            unique: fits.iter().all(|fit| fit.vertex.unique),
            certificate: fits.iter().map(|fit| fit.vertex.certificate()).fold(0.0, f64::max),
            fits,
        })
    }

    /// An outcome with what the quantiles say of themselves.
    fn outcome(&self) -> Outcome {
        Outcome {
            converged: self.converged,
            iterations: self.steps,
            certificate: Some(self.certificate),
            unique: Some(self.unique),
            local: LocalSolution::Global,
            warnings: self.fits.iter().flat_map(QuantileFit::warnings).fold(Vec::new(), |mut seen, warning| {
                if !seen.contains(&warning) {
                    seen.push(warning);
                }
                seen
            }),
            ..Outcome::default()
        }
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// √ of the mean square about the mean of influences, over m − n.
fn spread(influence: &[f64], n: usize) -> Option<f64> {
    let m = influence.len();
    if m <= n {
        return None;
    }
    let middle = mean(influence.iter().copied());
    Some((influence.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / (m - n) as f64).sqrt())
}

/// Residuals of an estimate clamped to where the two quantile surfaces lie about it on average.
fn clamped(residuals: &[f64], [low, high]: [&QuantileFit; 2]) -> Vec<f64> {
    let gap = |fit: &QuantileFit| mean(residuals.iter().zip(&fit.residuals).map(|(r, q)| r - q));
    let (from, to) = (gap(low), gap(high));
    let (from, to) = (from.min(to), to.max(from));
    residuals.iter().map(|r| r.clamp(from, to)).collect()
}

/// Share of each node below a quantile surface: 0 or 1, and for those on it the remainder of τ m,
/// so that heights of the other sign give the same for 1 − τ.
fn below(fit: &QuantileFit) -> Vec<f64> {
    let mut on: Vec<bool> = fit.residuals.iter().map(|r| *r == 0.0).collect();
    fit.vertex.basis.iter().for_each(|&k| on[k] = true);
    let count = |wanted: &dyn Fn(usize) -> bool| (0..on.len()).filter(|&k| wanted(k)).count() as f64;
    let under = count(&|k| !on[k] && fit.residuals[k] < 0.0);
    let share = ((fit.tau * on.len() as f64 - under) / count(&|k| on[k]).max(1.0)).clamp(0.0, 1.0);
    let of = |k: usize| if on[k] { share } else { f64::from(u8::from(fit.residuals[k] < 0.0)) };
    (0..on.len()).asking(10).map(of).collect()
}

fn trimmed(share: f64, rows: &Rows, measured: &Measured) -> Result<Outcome, FitError> {
    let Measured { linear, sample, heights } = *measured;
    let (m, n) = (rows.count(), rows.n);
    let quantiles = Quantiles::new([share, 1.0 - share].into_iter(), rows)?;
    let [low, high] = [&quantiles.fits[0], &quantiles.fits[1]];
    // rounding must not drop nodes of an exact fit
    let edge = exact::rounding(heights.largest);
    let omega: Vec<f64> = low
        .residuals
        .iter()
        .zip(&high.residuals)
        .map(|(l, h)| f64::from(u8::from(*l >= -edge && *h <= edge)))
        .collect();
    let kept = omega.iter().filter(|w| **w > 0.0).count();
    let too_few = || {
        Faults::one(
            "estimator.share",
            format_args!(
                "the {kept} nodes of the least trimmed sum do not determine {n} coefficients: raise the coverage"
            ),
        )
    };
    let factor = Factor::new(linear.design, &sample.reweighted(&measured.posted_weights(&omega)))?;
    let step = weighted_solution(n, &rows.q, &omega, &rows.b).filter(|_| factor.working.is_some());
    let Some(step) = step else { return Err(too_few().into()) };
    let residuals = rows.residuals(&step);
    // gross errors that stay, because a surface goes through them, count in full
    let clamped = clamped(&residuals, [low, high]);
    let influence: Vec<f64> =
        residuals.iter().zip(clamped).zip(&omega).map(|((r, c), w)| if *w > 0.0 { *r } else { c }).collect();
    let scale = spread(&influence, n).map(|s| s / (1.0 - 2.0 * share));
    let mut outcome = quantiles.outcome();
    let settled = exact::settled(scale, scale.filter(|_| m > n), &residuals, n, heights.largest, &mut outcome.warnings);
    Ok(Outcome {
        solved: Solved::Weighted(Weighting { factor: Box::new(factor), omega: omega.clone() }),
        scale: settled.scale,
        dispersion: settled.dispersion,
        objective: residuals.iter().zip(&omega).map(|(r, w)| w * r * r).sum(),
        weights: omega,
        subset_size: Some(kept),
        ..outcome
    })
}

fn winsorized(share: f64, rows: &Rows, measured: &Measured) -> Result<Outcome, FitError> {
    let (m, n) = (rows.count(), rows.n);
    let quantiles = Quantiles::new([share, 1.0 - share].into_iter(), rows)?;
    let [low, high] = [&quantiles.fits[0], &quantiles.fits[1]];
    // what is taken off the heights, so that those outside lie on the nearer surface
    let excess: Vec<f64> = low.residuals.iter().zip(&high.residuals).map(|(l, h)| l.min(0.0) + h.max(0.0)).collect();
    let mut step = vec![0.0; n];
    for ((q, b), e) in rows.q.chunks_exact(n).zip(&rows.b).zip(&excess).asking(n) {
        step.iter_mut().zip(q).for_each(|(x, q)| *x += q * (b - e));
    }
    let residuals = rows.residuals(&step);
    let inside = clamped(&residuals, [low, high]);
    let influence = low.sparsity.zip(high.sparsity).map(|(s1, s2)| -> Vec<f64> {
        let (under_low, under_high) = (below(low), below(high));
        let move_of = |k: usize| share * (share - under_low[k]) * s1 + share * (1.0 - share - under_high[k]) * s2;
        // a gross error that stays, because a surface goes through it, counts in full
        let counted = |k: usize| if excess[k] == 0.0 { residuals[k] } else { inside[k] };
        (0..m).map(|k| counted(k) + move_of(k)).collect()
    });
    let scale = influence.as_ref().and_then(|influence| spread(influence, n));
    let mut outcome = quantiles.outcome();
    let largest = measured.heights.largest;
    let settled = exact::settled(scale, scale.filter(|_| m > n), &residuals, n, largest, &mut outcome.warnings);
    let weight = |(r, c): (&f64, &f64)| if *r == 0.0 { 1.0 } else { (c / r).clamp(0.0, 1.0) };
    let objective = residuals.iter().zip(&excess).map(|(r, e)| (r - e).powi(2)).sum();
    Ok(Outcome {
        solved: Solved::Step(step),
        scale: settled.scale,
        dispersion: settled.dispersion,
        objective,
        weights: settled.weights.unwrap_or_else(|| residuals.iter().zip(&inside).map(weight).collect()),
        ..outcome
    })
}

fn combined(pairs: &[[f64; 2]], rows: &Rows, measured: &Measured) -> Result<Outcome, FitError> {
    let (m, n) = (rows.count(), rows.n);
    let quantiles = Quantiles::new(pairs.iter().map(|pair| pair[0]), rows)?;
    let weighted = || quantiles.fits.iter().zip(pairs);
    let mut step = vec![0.0; n];
    for (fit, [_, weight]) in weighted() {
        step.iter_mut().zip(&fit.vertex.x).for_each(|(x, q)| *x += weight * q);
    }
    let residuals = rows.residuals(&step);
    // wᵢ/f(ξᵢ)
    let lengths: Option<Vec<f64>> = weighted().map(|(fit, [_, weight])| Some(weight * fit.sparsity?)).collect();
    let variance = lengths.as_ref().map(|lengths| -> f64 {
        let term = |i: usize, j: usize| {
            let (a, b) = (pairs[i][0], pairs[j][0]);
            lengths[i] * lengths[j] * (a.min(b) - a * b)
        };
        (0..pairs.len()).flat_map(|i| (0..pairs.len()).map(move |j| (i, j))).map(|(i, j)| term(i, j)).sum()
    });
    let scale = variance.map(f64::sqrt);
    let mut outcome = quantiles.outcome();
    let largest = measured.heights.largest;
    let settled = exact::settled(scale, scale.filter(|_| m > n), &residuals, n, largest, &mut outcome.warnings);
    let under: Vec<Vec<f64>> = quantiles.fits.iter().map(below).collect();
    let influence = |k: usize| -> f64 {
        cancel::checkpoint();
        let of = |((length, fit), under): ((&f64, &QuantileFit), &Vec<f64>)| length * (fit.tau - under[k]);
        lengths.iter().flatten().zip(&quantiles.fits).zip(&under).map(of).sum()
    };
    let weight = |k: usize| if residuals[k] == 0.0 { 1.0 } else { (influence(k) / residuals[k]).abs().min(1.0) };
    let objective = weighted().map(|(fit, [_, weight])| weight * fit.sum()).sum();
    Ok(Outcome {
        solved: Solved::Step(step),
        scale: settled.scale,
        dispersion: settled.dispersion,
        objective,
        weights: settled.weights.unwrap_or_else(|| (0..m).map(weight).collect()),
        ..outcome
    })
}
