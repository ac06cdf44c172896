//! M-estimators (Eqs. 10–12): least `Σ ρ(rₖ/s)`, `rₖ = √wₖ (zₖ − xₖᵀA)`, by iteratively reweighted
//! least squares.
//!
//! One iteration is: scale of the residuals, then weights `ωₖ = ψ(u)/u` at `u = rₖ/s`, then least
//! squares with the weights `wₖωₖ`, which goes through the same factor as any fit, so that it loses
//! no digits. It ends when no residual and not the scale has moved by more than the tolerance times
//! the scale, or by more than the rounding of the heights.
//!
//! For a convex loss with a fixed scale (or proposal 2) the answer is the only one; a redescending
//! loss has several local solutions, and the answer is the one reached from the start.
//!
//! Exact fit: when more than half of the nodes lie on one surface the MAD falls to 0. The limit of
//! the weights is then 1 on the surface and 0 off it, which is the result, with scale 0 and no
//! standard errors.
//!
//! The share of gross errors may take the place of a tuning constant, given or estimated
//! ([`super::minimax`]); an estimated one is found anew in each iteration.
//!
//! τ by Huber (1981, section 7.6): `K² s² Σψ²/(m − n) / (mean ψ′)² (XᵀX)⁻¹`,
//! `K = 1 + n/m · var ψ′/(mean ψ′)²`; standard errors are wider with few nodes
//! ([`super::few_nodes`]).

use super::{
    exact::{self, EXACT},
    lts, minimax,
    outcome::{Measured, Outcome, Slopes, Solved, Weighting},
    scale::scale,
};
use crate::{
    error::FitError,
    factor::{Factor, Precision, Wanted, residual_pass},
    result::{LocalSolution, Warning},
    spec::{Contamination, Loss, MEstimator, ScaleRule, Start},
};
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
};

pub(super) fn estimate(asked: &MEstimator, measured: &Measured) -> Result<Outcome, FitError> {
    let Measured { linear, sample, heights } = *measured;
    let design = linear.design;
    let (m, n) = (sample.count(), design.size());
    let roots: Vec<f64> = (0..m).map(|k| sample.w(k).sqrt()).collect();
    let precision = if m * n <= 200_000 { Precision::DoubleDouble } else { Precision::Double };
    let residuals_of = |factor: &Factor| -> Option<Vec<f64>> {
        let working = factor.working.as_deref()?;
        let mut values = residual_pass(design, sample, working, precision, Wanted::Values).values;
        values.iter_mut().zip(&roots).for_each(|(r, root)| *r *= root);
        Some(values)
    };
    let solve = |omega: &[f64]| -> Result<(Factor, Vec<f64>), FitError> {
        let weights = measured.posted_weights(omega);
        let factor = Factor::new(design, &sample.reweighted(&weights))?;
        match residuals_of(&factor) {
            Some(residuals) => Ok((factor, residuals)),
            None => Err(too_few(asked, omega, n)),
        }
    };
    let mut residuals = match asked.start {
        Start::LeastSquares => residuals_of(linear.factor).ok_or_else(|| too_few(asked, &vec![1.0; m], n))?,
        Start::LeastTrimmed => solve(&lts::start_weights(measured)?)?.1,
    };
    let rounding = 8.0 * f64::EPSILON * heights.largest;
    let fixed = matches!(asked.scale, ScaleRule::Fixed(_));
    let mut last_scale = None;
    let mut loss = asked.loss;
    let (mut iterations, mut converged, mut reached) = (0, false, f64::INFINITY);
    let mut is_exact = false;
    let mut stand: Option<(Factor, Vec<f64>)> = None;
    while iterations < asked.max_iterations && !converged {
        cancel::checkpoint();
        let s = scale(asked.scale, &residuals, last_scale, n);
        is_exact = !fixed && s <= EXACT * heights.largest;
        let omega: Vec<f64> = if is_exact {
            let on = exact::rounding(heights.largest);
            residuals.iter().map(|r| f64::from(u8::from(r.abs() <= on))).collect()
        } else {
            if asked.contamination == Some(Contamination::Estimated) {
                loss = estimated(&residuals, s);
            }
            residuals.iter().asking(50).map(|r| loss.weight(r / s)).collect()
        };
        let (factor, next) = solve(&omega)?;
        iterations += 1;
        let moved = residuals.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let scaled = last_scale.map_or(if fixed { 0.0 } else { f64::INFINITY }, |last: f64| (s - last).abs());
        let change = moved.max(scaled);
        converged = is_exact || change <= (asked.tolerance * s).max(rounding);
        reached = if s > 0.0 { change / s } else { 0.0 };
        residuals = next;
        last_scale = Some(s);
        stand = Some((factor, omega));
    }
    let Some((factor, omega)) = stand else {
        return Err(Faults::one("estimator.max_iterations", "at least one iteration is needed").into());
    };
    let mut warnings = Vec::new();
    if !converged {
        warnings.push(Warning::WeightsNotConverged { iterations, change_scales: reached });
    }
    let s = if is_exact { 0.0 } else { last_scale.unwrap_or(0.0) };
    let known = asked.contamination != Some(Contamination::Estimated);
    let convex =
        known && asked.loss.is_convex() && matches!(asked.scale, ScaleRule::Fixed(_) | ScaleRule::Proposal2 { .. });
    let ((dispersion, slopes), objective) = if is_exact {
        warnings.push(exact::warning(omega.iter().filter(|w| **w > 0.0).count(), m));
        ((None, None), 0.0)
    } else {
        let s = scale(asked.scale, &residuals, last_scale, n);
        (dispersion(loss, &residuals, s, n), residuals.iter().map(|r| loss.rho(r / s)).sum())
    };
    Ok(Outcome {
        solved: Solved::Weighted(Weighting { factor: Box::new(factor), omega: omega.clone() }),
        converged,
        iterations,
        tolerance_reached: reached.is_finite().then_some(reached),
        scale: Some(s),
        objective,
        weights: omega,
        dispersion,
        slopes,
        start: Some(asked.start),
        minimax: asked.contamination.filter(|_| !is_exact).and_then(|given| minimax::report(given, loss)),
        local: if convex { LocalSolution::Global } else { LocalSolution::FromStart },
        warnings,
        ..Outcome::default()
    })
}

/// Huber's loss against the share of gross errors that residuals of scale s show.
fn estimated(residuals: &[f64], s: f64) -> Loss {
    let u: Vec<f64> = residuals.iter().map(|r| r / s).collect();
    Loss::Huber { k: minimax::likeliest_k(&u) }
}

/// √ of what `(XᵀX)⁻¹` is multiplied with, and the slopes of ψ.
fn dispersion(loss: Loss, residuals: &[f64], s: f64, n: usize) -> (Option<f64>, Option<Slopes>) {
    let m = residuals.len();
    if m <= n {
        return (None, None);
    }
    let squares: f64 = residuals.iter().map(|r| (s * loss.psi(r / s)).powi(2)).sum();
    let slopes = Slopes::new(residuals.iter().map(|r| loss.psi_slope(r / s)), m, n);
    let dispersion = (squares / (m - n) as f64).sqrt() * slopes.k / slopes.mean;
    ((slopes.mean > 0.0 && dispersion.is_finite()).then_some(dispersion), Some(slopes))
}

/// The weights left too few nodes for the coefficients: what the caller has set apart from the
/// usual is at fault, if it is one thing.
fn too_few(asked: &MEstimator, omega: &[f64], n: usize) -> FitError {
    let left = omega.iter().filter(|w| **w > 0.0).count();
    let field = match (matches!(asked.scale, ScaleRule::Fixed(_)), asked.loss.is_usual()) {
        (false, false) => "estimator.tuning",
        (true, true) => "estimator.scale.value",
        _ => "estimator",
    };
    Faults::one(
        field,
        format_args!(
            "only {left} of {} nodes have a weight above 0, which do not determine {n} coefficients: use a larger \
             scale or tuning constant, or the start `least_trimmed_squares`",
            omega.len()
        ),
    )
    .into()
}
