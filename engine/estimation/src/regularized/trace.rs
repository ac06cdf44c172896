//! The ridge trace: the coefficients along k (Hoerl and Kennard), which shows where they settle.

use super::context::Context;
use crate::{
    estimate::Estimate,
    result::RidgeTracePoint,
    selection::{Chosen, Rule},
};

/// Points between the ends.
const POINTS: usize = 60;
/// Lowest k relative to λ₁: below it k has no visible effect, unless the chosen k lies lower still.
const LOW: f64 = 1e-2;
/// Highest k relative to λₙ: above it the estimate is 0.
const HIGH: f64 = 10.0;
/// The low end is no further from the high one than this.
const WIDEST: f64 = 1e-14;

/// k = 0, an even grid on log k, and the chosen k in its place; ascending.
pub(super) fn points(context: &Context, chosen: Option<Chosen>) -> Vec<RidgeTracePoint> {
    let lambda = &context.spectrum.lambda;
    let high = HIGH * context.spectrum.largest();
    let chosen = chosen.map(|chosen| chosen.lambda_star).filter(|k| *k > 0.0 && k.is_finite());
    let mut grid = vec![0.0];
    if high > 0.0 && high.is_finite() {
        let low = lambda.iter().copied().find(|l| *l > 0.0).unwrap_or(high) * LOW;
        let low = low.min(chosen.unwrap_or(low)).max(WIDEST * high).min(high);
        let step = (high / low).ln() / POINTS as f64;
        grid.extend((0..=POINTS).map(|i| low * (step * i as f64).exp()));
    }
    grid.extend(chosen);
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid.into_iter().map(|k| RidgeTracePoint { k, coefficients: coefficients(context, k) }).collect()
}

/// Caller's coefficients of ridge with `k`.
fn coefficients(context: &Context, k: f64) -> Vec<f64> {
    let spectrum = context.spectrum;
    let rule = if k > 0.0 { Rule::Ridge } else { Rule::None };
    let filtered: Vec<_> = spectrum.lambda.iter().enumerate().map(|(i, &lambda)| rule.at(i, lambda, k)).collect();
    Estimate::new(context.columns, spectrum, &filtered, context.least_squares).coefficients
}
