//! Changes that are multiples of what the control can set.
//!
//! Settings are rounded one after the other, the coarsest step first (the step that changes the
//! flank most); after each the others are fitted anew to what the rounded ones leave, within their
//! limits, so that finer steps make up for coarser ones (Babai's nearest plane). At last each
//! rounded setting may go one step on where that leaves less. Rounding each setting by itself would
//! spoil settings that undo each other.

use super::{
    limits::{fit_free, positions},
    problem::{Correction, Setting},
};
use flankfit_estimation::FitError;
use flankfit_numerics::cancel::{self, Asking};

/// The changes within `change`, which is within the limits, of the settings `used` with
/// increments rounded; `None` where none has one.
pub(super) fn rounded(correction: &Correction, used: &[usize], change: &[f64]) -> Result<Option<Vec<f64>>, FitError> {
    let settings = &correction.spec().settings;
    let n = change.len();
    let mut pinned: Vec<Option<f64>> = (0..n).map(|j| (!used.contains(&j)).then_some(change[j])).collect();
    let mut stepped: Vec<(usize, f64)> = used.iter().filter_map(|&j| Some((j, settings[j].increment?))).collect();
    if stepped.is_empty() {
        return Ok(None);
    }
    let effect = |(j, increment): &(usize, f64)| {
        let square = |&k: &usize| correction.weight(k) * correction.row(k)[*j].powi(2);
        increment * correction.counted().iter().map(square).sum::<f64>().sqrt()
    };
    stepped.sort_by(|a, b| effect(b).total_cmp(&effect(a)));
    let mut point = change.to_vec();
    for &(j, increment) in &stepped {
        point[j] = nearest(&settings[j], increment, point[j]);
        pinned[j] = Some(point[j]);
        let free: Vec<usize> = (0..n).filter(|&i| pinned[i].is_none()).collect();
        if free.is_empty() {
            break;
        }
        let fitted = fit_free(correction, &free, &point)?;
        for (&i, coefficient) in free.iter().zip(&fitted.result.coefficients) {
            point[i] = coefficient.value;
        }
        point = positions(correction, &point, &pinned)?.change;
    }
    step_on(correction, &stepped, &mut point);
    Ok(Some(point))
}

fn nearest(setting: &Setting, increment: f64, change: f64) -> f64 {
    let [least, most] = setting.steps().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    Setting::multiple((change / increment).round().max(least).min(most), increment)
}

/// One step more or less of each setting, as long as that leaves less.
fn step_on(correction: &Correction, stepped: &[(usize, f64)], point: &mut [f64]) {
    let settings = &correction.spec().settings;
    let mut waiting: Vec<(usize, f64)> = stepped.to_vec();
    let mut quadratic = Quadratic::at(correction, point);
    loop {
        cancel::checkpoint();
        let mut best: Option<(f64, usize, f64)> = None;
        for (place, &(j, increment)) in waiting.iter().enumerate() {
            for step in [-1.0, 1.0] {
                let to = nearest(&settings[j], increment, point[j] + step * increment);
                let less = -quadratic.more(j, to - point[j]);
                if less > best.map_or(1e-12 * quadratic.left, |(most, ..)| most) {
                    best = Some((less, place, to));
                }
            }
        }
        let Some((_, place, to)) = best else { return };
        let (j, _) = waiting.swap_remove(place);
        quadratic.step(j, to - point[j]);
        point[j] = to;
    }
}

/// Σ w (d + JΔ − t)² about a point: value, half its gradient, and JᵀWJ.
struct Quadratic {
    left: f64,
    slope: Vec<f64>,
    gram: Vec<f64>,
}

impl Quadratic {
    fn at(correction: &Correction, point: &[f64]) -> Self {
        let n = point.len();
        let (mut left, mut slope, mut gram) = (0.0, vec![0.0; n], vec![0.0; n * n]);
        for &k in correction.counted().iter().asking(n * n) {
            let (w, row, here) = (correction.weight(k), correction.row(k), correction.left_at(k, point));
            left += w * here * here;
            for (i, x) in row.iter().enumerate() {
                slope[i] += w * x * here;
                for (sum, y) in gram[i * n..(i + 1) * n].iter_mut().zip(row) {
                    *sum += w * x * y;
                }
            }
        }
        Quadratic { left, slope, gram }
    }

    /// How much more is left when setting j goes on by `step`.
    fn more(&self, j: usize, step: f64) -> f64 {
        step * (2.0 * self.slope[j] + step * self.gram[j * self.slope.len() + j])
    }

    fn step(&mut self, j: usize, step: f64) {
        let n = self.slope.len();
        self.left += self.more(j, step);
        self.slope.iter_mut().zip(&self.gram[j * n..(j + 1) * n]).for_each(|(slope, x)| *slope += step * x);
    }
}
