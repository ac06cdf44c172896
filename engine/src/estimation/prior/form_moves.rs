//! What is known of a single form of the coefficients, which may have moved otherwise than they all
//! did.
//!
//! The posterior has one size of the moves for all coefficients, and so draws back one that moves
//! while the others stand still. Its mean is good on the whole; an interval must hold for each. So
//! intervals are those of a mixture: with the share [`OWN`] the form moves by a size of its own,
//! told by its own estimates at the earlier iterations, else by that of all, told by all of them.
//! Both ways sizes count evenly beforehand, which is towards the large ones when they stand evenly
//! in the logarithm: what seems to stand still may only have moved too little to be told.

use nalgebra::{DMatrix, DVector};

use super::chain::{Branch, Link, weights};

/// The probability beforehand that a form moves by a size of its own.
const OWN: f64 = 0.9;
/// What size 0 counts as beside the others, which count as their own size.
const LEAST: f64 = 0.01;
/// Shares of the whole below which a size is left out.
const NOTHING: f64 = 1e-9;

/// What every form is found from, in units of σ from least squares of the nodes of now.
pub(crate) struct FormMoves {
    sizes: Vec<f64>,
    /// `ln L + ln` of the weight beforehand of each size.
    ln_all: Vec<f64>,
    /// Mean and root `R⁻¹` of the posterior of each size that is likely enough.
    parts: Vec<Part>,
    /// What each earlier iteration says by itself.
    earlier: Vec<Alone>,
}

struct Part {
    weight: f64,
    mean: DVector<f64>,
    root: DMatrix<f64>,
}

struct Alone {
    mean: DVector<f64>,
    root: DMatrix<f64>,
    shift: DVector<f64>,
}

/// Mean and variance of a form.
#[derive(Clone, Copy)]
struct Moments {
    mean: f64,
    variance: f64,
}

impl FormMoves {
    /// `None` where an earlier iteration by itself does not determine every coefficient.
    pub(super) fn new(links: &[Link], branches: &[Branch], sizes: &[f64]) -> Option<Self> {
        let alone = |link: &Link| {
            let rows = &link.rows;
            rows.is_whole().then(|| Alone { mean: rows.mean(), root: rows.inverse(), shift: link.shift.clone() })
        };
        let earlier: Vec<Alone> = links.iter().map(alone).collect::<Option<_>>()?;
        let ln_all: Vec<f64> = branches.iter().zip(sizes).map(|(branch, q)| branch.ln_all + beforehand(*q)).collect();
        let weights = weights(ln_all.iter().copied());
        let parts = branches.iter().zip(weights).filter(|(_, weight)| *weight > NOTHING).map(|(branch, weight)| Part {
            weight,
            mean: branch.posterior.mean(),
            root: branch.posterior.inverse(),
        });
        Some(FormMoves { sizes: sizes.to_vec(), ln_all, parts: parts.collect(), earlier })
    }

    /// How far the middle of the form lies from least squares, and its standard deviation, in σ.
    pub(crate) fn of(&self, form: &[f64]) -> [f64; 2] {
        let length = form.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0) {
            return [0.0; 2];
        }
        let unit: Vec<f64> = form.iter().map(|x| x / length).collect();
        let (alone, ln_alone): (Vec<Moments>, Vec<f64>) = self.by_itself(&unit);
        let ln_own: Vec<f64> = ln_alone.iter().zip(&self.sizes).map(|(l, q)| l + beforehand(*q)).collect();
        let ln_rest = self.ln_all.iter().zip(&ln_alone).map(|(all, own)| all - own);
        let ln_whole = ln_sum(self.sizes.iter().map(|q| beforehand(*q)));
        let odds = ln_sum(ln_own.iter().copied()) + ln_sum(ln_rest) - ln_sum(self.ln_all.iter().copied()) - ln_whole;
        let own = 1.0 / (1.0 + (1.0 - OWN) / OWN * (-odds).exp());
        let together = self.parts.iter().map(|part| ((1.0 - own) * part.weight, part.of(&unit)));
        let parts: Vec<(f64, Moments)> =
            together.chain(weights(ln_own.into_iter()).into_iter().map(|w| own * w).zip(alone)).collect();
        let whole: f64 = parts.iter().map(|(weight, _)| weight).sum();
        let mean = parts.iter().map(|(weight, part)| weight * part.mean).sum::<f64>() / whole;
        let spread = |(weight, part): &(f64, Moments)| weight * (part.variance + (part.mean - mean).powi(2));
        let variance = parts.iter().map(spread).sum::<f64>() / whole;
        [length * mean, length * variance.sqrt()]
    }

    /// What the form's own estimates say with each size of its moves, and the logarithms of their
    /// likelihoods: a Kalman filter of one number.
    fn by_itself(&self, unit: &[f64]) -> (Vec<Moments>, Vec<f64>) {
        let estimates: Vec<(Moments, f64)> =
            self.earlier.iter().map(|one| (seen(&one.mean, &one.root, unit), dot(&one.shift, unit))).collect();
        let Some(((first, moved), rest)) = estimates.split_first() else { return Default::default() };
        // least squares of the nodes of now
        let now = (Moments { mean: 0.0, variance: 1.0 }, 0.0);
        let follow = |&q: &f64| {
            let (mut known, mut shift, mut ln) = (*first, *moved, 0.0);
            for (seen, next) in rest.iter().chain([&now]) {
                let before = known.variance + q * q;
                let (error, sum) = (seen.mean - known.mean - shift, before + seen.variance);
                ln -= 0.5 * (error * error / sum + sum.ln());
                let gain = before / sum;
                known.mean += shift + gain * error;
                known.variance = gain * seen.variance;
                shift = *next;
            }
            (known, ln)
        };
        self.sizes.iter().map(follow).unzip()
    }
}

impl Part {
    fn of(&self, unit: &[f64]) -> Moments {
        seen(&self.mean, &self.root, unit)
    }
}

/// Of a mean and an upper triangular root `R⁻¹`.
fn seen(mean: &DVector<f64>, root: &DMatrix<f64>, unit: &[f64]) -> Moments {
    let along = |column: usize| dot_first(root, column, unit);
    Moments { mean: dot(mean, unit), variance: (0..unit.len()).map(|j| along(j).powi(2)).sum() }
}

fn dot_first(root: &DMatrix<f64>, column: usize, unit: &[f64]) -> f64 {
    root.column(column).iter().take(column + 1).zip(unit).map(|(r, u)| r * u).sum()
}

fn dot(x: &DVector<f64>, y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// The logarithm of what a size counts beforehand.
fn beforehand(size: f64) -> f64 {
    size.max(LEAST).ln()
}

/// `ln Σ exp`.
fn ln_sum(logarithms: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
    most + logarithms.map(|l| (l - most).exp()).sum::<f64>().ln()
}
