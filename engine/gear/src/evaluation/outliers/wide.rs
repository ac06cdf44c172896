//! Places of dust that are longer than medians of blocks tell: smears, fibres, chips that the probe
//! rides on.
//!
//! A polynomial of order 4, fitted so that far samples do not count (Tukey's weights after some
//! steps of least absolute values), leaves residuals. A run of them above [`super::THRESHOLD`]
//! scales is suspected where it begins and ends abruptly, and where the trace next to it is back
//! near the polynomial: waves and reliefs do neither.

use nalgebra::{SMatrix, SVector};

use super::{FEWEST_BESIDE, FINEST, Run, SKIRT, THRESHOLD, block, is_abrupt, spread};
use flankfit_numerics::cancel::{self, Asking};

/// Coefficients of the polynomial.
const TERMS: usize = 5;
/// Most samples that the polynomial is fitted to.
const MOST_FITTED: usize = 500;
const STEPS: usize = 12;
/// Steps of least absolute values among them.
const ABSOLUTE: usize = 6;
/// Tukey's constant, in scales.
const TUKEY: f64 = 4.685;
/// The longest place is one in so many samples of the trace.
const LONGEST: usize = 7;
/// A place begins and ends within one in so many samples of the trace.
const ABRUPT: usize = 40;
/// Beside it the trace is this much lower, over its height.
const BACK: f64 = 0.25;

/// The long places of a trace.
pub(super) fn outliers(at: &[f64], deviation: &[f64]) -> Vec<Run> {
    let n = at.len();
    let Some(residual) = residuals(at, deviation) else { return Vec::new() };
    let [_, scale] = spread(&residual);
    let scale = scale.max(FINEST);
    let both: Vec<[f64; 2]> = residual.iter().zip(deviation).map(|(r, d)| [*r, *d]).collect();
    // shorter ones stand out of medians of blocks
    let shortest = block(n) / 4;
    let mut runs: Vec<Run> = Vec::new();
    for (i, r) in residual.iter().enumerate().filter(|(_, r)| r.abs() > THRESHOLD * scale) {
        match runs.last_mut() {
            // one sample between may be a chance
            Some(run) if i <= run.to + 1 && run.height * r > 0.0 => {
                run.to = i + 1;
                run.height = if r.abs() > run.height.abs() { *r } else { run.height };
            }
            _ => runs.push(Run { from: i, to: i + 1, height: *r, burr: false }),
        }
    }
    for run in &mut runs {
        let skirt = |i: usize| residual[i] * run.height.signum() > SKIRT * scale;
        while run.from > 0 && skirt(run.from - 1) {
            run.from -= 1;
        }
        while run.to < n && skirt(run.to) {
            run.to += 1;
        }
    }
    // skirts of neighbours may meet
    runs.dedup_by(|next, run| {
        let meet = next.from < run.to;
        if meet {
            run.to = run.to.max(next.to);
            run.height = if next.height.abs() > run.height.abs() { next.height } else { run.height };
        }
        meet
    });
    runs.retain(|run| (shortest.max(2)..=n / LONGEST).contains(&(run.to - run.from)) && is_isolated(&both, run));
    runs
}

/// Whether a run of residuals, each with its deviation, begins and ends abruptly, with the trace
/// back next to it.
fn is_isolated(both: &[[f64; 2]], run: &Run) -> bool {
    let n = both.len();
    let (from, to, within) = (run.from, run.to, (n / ABRUPT).max(3));
    let beside = ((to - from) / 2).max(FEWEST_BESIDE);
    let back = |near: &[[f64; 2]]| {
        let near: Vec<f64> = near.iter().map(|[residual, _]| *residual).collect();
        near.len() >= FEWEST_BESIDE && spread(&near)[0].abs() < BACK * run.height.abs()
    };
    let inside = || both[from..to].iter().copied();
    let (lower, upper) = (&both[from.saturating_sub(beside)..from], &both[to..(to + beside).min(n)]);
    back(lower)
        && back(upper)
        && is_abrupt(inside(), lower.iter().rev().copied(), run.height, within)
        && is_abrupt(inside().rev(), upper.iter().copied(), run.height, within)
}

/// About the polynomial; `None` where samples lie at too few places.
fn residuals(at: &[f64], deviation: &[f64]) -> Option<Vec<f64>> {
    let n = at.len();
    let (low, high) = (at[0], at[n - 1]);
    let basis = |x: f64| -> SVector<f64, TERMS> {
        let u = (2.0 * x - low - high) / (high - low);
        // Legendre's, which condition well
        let mut p = [1.0, u, 0.0, 0.0, 0.0];
        for k in 2..TERMS {
            p[k] = ((2 * k - 1) as f64 * u * p[k - 1] - (k - 1) as f64 * p[k - 2]) / k as f64;
        }
        SVector::from(p)
    };
    let stride = n.div_ceil(MOST_FITTED);
    let rows: Vec<(SVector<f64, TERMS>, f64)> = (0..n).step_by(stride).map(|i| (basis(at[i]), deviation[i])).collect();
    let mut coefficients = SVector::<f64, TERMS>::zeros();
    let mut weight = vec![1.0; rows.len()];
    for step in 0..=STEPS {
        cancel::checkpoint();
        let mut square = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right = SVector::<f64, TERMS>::zeros();
        for ((row, d), w) in rows.iter().zip(&weight) {
            square += row * row.transpose() * *w;
            right += row * (w * d);
        }
        coefficients = square.cholesky()?.solve(&right);
        let left: Vec<f64> = rows.iter().map(|(row, d)| d - row.dot(&coefficients)).collect();
        let scale = spread(&left)[1].max(FINEST);
        for (w, r) in weight.iter_mut().zip(&left) {
            let far = r.abs() / scale;
            *w = if step < ABSOLUTE { 1.0 / far.max(0.1) } else { (1.0 - (far / TUKEY).powi(2)).max(0.0).powi(2) };
        }
    }
    Some(at.iter().zip(deviation).asking(10).map(|(x, d)| d - basis(*x).dot(&coefficients)).collect())
}
