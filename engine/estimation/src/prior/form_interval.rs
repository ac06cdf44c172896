//! Intervals of single forms of the coefficients that hold whatever the flank did, for a known σ
//! (docs/explanation/prior.md).
//!
//! Before least squares y of a form is seen, the form is predicted from the earlier iterations and
//! from the part of the present nodes orthogonal to it, by a mixture of normal distributions. With
//! the share [`OWN`] the form moves by a size of its own, estimated from its own values, else by
//! that of all; with the share [`ALONE`] it stepped by itself in the last move, and with [`WHOLE`]
//! the flank did. Let δ(y) be the mean of the form given y; it grows with y, so every value θ is
//! δ(c) of one c. The interval holds all θ with
//!
//! ```text
//! |y − c| ≤ q(c − θ),  P(|T + b| ≤ q(b)) = level
//! ```
//!
//! Least squares is distributed about the truth as T, and what is predicted rests on nodes and
//! directions whose errors are independent of it. So the truth is held with the probability that is
//! said, whatever it is; what was known before only makes the interval shorter where it is right
//! (Pratt, JASA 56, 1961; Yu and Hoff, Biometrika 105, 2018). It always holds least squares and
//! δ(y).

use nalgebra::{DMatrix, DVector};

use super::chain::{Branch, Link, ln_sum, median, steps, weights};
use crate::inference::Noise;
use flankfit_numerics::{distribution::Student, length, root::root};

/// The probability beforehand that a form moves by a size of its own.
const OWN: f64 = 0.9;
/// Prior shares of a step in the last move, of the form alone and of the flank, over all sizes of
/// [`steps`].
const ALONE: f64 = 0.15;
const WHOLE: f64 = 0.15;
/// Sizes of steps of the form alone in addition to [`steps`], after which the value is hardly drawn
/// back; each has the weight of one of these. They matter only where nothing else is likely.
const FAR: [f64; 3] = [1e6, 1e9, 1e12];
/// Weight of size 0, where the others have their own size as weight: coefficients that seem
/// constant may only have moved too little to be noticed.
const LEAST: f64 = 0.01;
/// Shares of the whole below which a part is left out.
const NOTHING: f64 = 1e-6;
/// Range from least squares in which c is searched, in halves of Student's interval, and steps in
/// it. Outside it earlier knowledge is so far off that the interval is Student's.
const FARTHEST: f64 = 8.0;
const APART: u32 = 32;

/// Predictions from which every form is computed, in units of σ from least squares of the present
/// nodes.
pub(crate) struct FormIntervals {
    /// σ, of all iterations together.
    sigma: f64,
    sizes: Vec<f64>,
    /// The logarithm of what each size counts beforehand and by the jumps before the last.
    ln_of_all: Vec<f64>,
    /// Predictions for each size of moves, and for a step of the flank of each size.
    moved: Vec<Outlook>,
    stepped: Vec<Outlook>,
    /// Information of each earlier iteration by itself, with its move to the next; empty if one of
    /// them does not determine every coefficient.
    earlier: Vec<(Known, DVector<f64>)>,
}

/// A mean and an upper triangular root `R⁻¹` of the covariance.
struct Known {
    mean: DVector<f64>,
    root: DMatrix<f64>,
}

/// Prediction of a branch.
struct Outlook {
    /// With the nodes of now.
    posterior: Known,
    /// The logarithm of how likely these are.
    ln: f64,
}

/// Mean and variance of a form.
#[derive(Clone, Copy)]
struct Moments {
    mean: f64,
    variance: f64,
}

impl FormIntervals {
    pub(super) fn new(sigma: f64, links: &[Link], branches: &[Branch], sizes: &[f64], stepped: &[Branch]) -> Self {
        let alone = |link: &Link| {
            let known = Known { mean: link.rows.mean(), root: link.rows.inverse() };
            link.rows.is_whole().then(|| (known, link.shift.clone()))
        };
        FormIntervals {
            sigma,
            sizes: sizes.to_vec(),
            ln_of_all: branches.iter().zip(sizes).map(|(branch, size)| branch.ln_earlier + beforehand(*size)).collect(),
            moved: branches.iter().map(Outlook::new).collect(),
            stepped: stepped.iter().map(Outlook::new).collect(),
            earlier: links.iter().map(alone).collect::<Option<_>>().unwrap_or_default(),
        }
    }

    /// Distances of the ends of the form's interval from least squares, in the σ of `noise`. That
    /// noise is to be of the present nodes alone: the prediction may be off by any σ, the error of
    /// least squares may not.
    pub(crate) fn of(&self, form: &[f64], noise: &Noise) -> [f64; 2] {
        let length = length(form);
        if !(length > 0.0) {
            return [0.0; 2];
        }
        let unit: Vec<f64> = form.iter().map(|x| x / length).collect();
        let predicted = self.prediction(&unit).in_units(noise.sigma / self.sigma);
        let [low, high] = [-1.0, 1.0].map(|way| predicted.end(way, noise));
        let half = noise.quantile();
        let ends = if low.is_finite() && high.is_finite() { [low, high] } else { [-half, half] };
        ends.map(|end| length * end)
    }

    /// Prediction of a form of length 1 before its own least squares.
    fn prediction(&self, unit: &[f64]) -> Prediction {
        let (parts, ln_without): (Vec<Moments>, Vec<f64>) = self.moved.iter().map(|one| one.without(unit)).unzip();
        let ln_of_all: Vec<f64> = self.ln_of_all.iter().zip(&ln_without).map(|(ln, without)| ln + without).collect();
        let ln_without = sum(&ln_of_all) - sum(&self.ln_of_all);
        let all = weights(ln_of_all.iter().copied()).into_iter().zip(parts);
        let parts = match self.by_itself(unit) {
            None => all.collect(),
            Some((alone, ln_of_own)) => {
                let share = self.share_of_own(&ln_of_own);
                let own = weights(ln_of_own.iter().copied()).into_iter().zip(alone);
                // in the order of the sizes, for the median
                let both = all.zip(own);
                both.flat_map(|((w, all), (v, own))| [((1.0 - share) * w, all), (share * v, own)]).collect()
            }
        };
        let stepped = self.stepped.iter().map(|one| one.without(unit));
        Prediction::new(parts, stepped.map(|(part, ln)| (ln - ln_without, part)).collect())
    }

    /// The probability that the form moves by a size of its own, by the earlier iterations.
    fn share_of_own(&self, ln_of_own: &[f64]) -> f64 {
        let ln_before = self.sizes.iter().map(|size| beforehand(*size));
        // the likelihoods of the others alone
        let ln_of_rest =
            self.ln_of_all.iter().zip(ln_of_own).zip(ln_before.clone()).map(|((all, own), b)| all - own + b);
        let odds = sum(ln_of_own) + ln_sum(ln_of_rest) - sum(&self.ln_of_all) - ln_sum(ln_before);
        1.0 / (1.0 + (1.0 - OWN) / OWN * (-odds).exp())
    }

    /// Predictions of the form's own estimates for each size of its moves, and the logarithms of
    /// their weights: a Kalman filter of one number. `None` if an iteration does not determine it.
    fn by_itself(&self, unit: &[f64]) -> Option<(Vec<Moments>, Vec<f64>)> {
        let estimates: Vec<(Moments, f64)> =
            self.earlier.iter().map(|(known, shift)| (known.of(unit), dot(shift, unit))).collect();
        let ((first, moved), rest) = estimates.split_first()?;
        let follow = |&q: &f64| {
            let (mut known, mut shift, mut ln) = (*first, *moved, beforehand(q));
            for (seen, next) in rest {
                let before = known.variance + q * q;
                let (error, sum) = (seen.mean - known.mean - shift, before + seen.variance);
                ln -= 0.5 * (error * error / sum + sum.ln());
                let gain = before / sum;
                known = Moments { mean: known.mean + shift + gain * error, variance: gain * seen.variance };
                shift = *next;
            }
            (Moments { mean: known.mean + shift, variance: known.variance + q * q }, ln)
        };
        Some(self.sizes.iter().map(follow).unzip())
    }
}

/// A mixture of normal distributions that predicts a form.
struct Prediction {
    /// The logarithm of the weight of each part.
    parts: Vec<(f64, Moments)>,
}

impl Prediction {
    /// The same in another unit of σ.
    fn in_units(self, unit: f64) -> Self {
        let change = |(ln, part): (f64, Moments)| {
            (ln, Moments { mean: part.mean / unit, variance: part.variance / (unit * unit) })
        };
        Prediction { parts: self.parts.into_iter().map(change).collect() }
    }

    /// Parts with weights that add up to 1, and what is predicted where the flank stepped as a
    /// whole, with the logarithms of how much likelier that makes what is seen.
    fn new(parts: Vec<(f64, Moments)>, stepped: Vec<(f64, Moments)>) -> Self {
        let middle = parts[median(parts.iter().map(|(weight, _)| *weight))].1;
        let each = 1.0 / steps().len() as f64;
        let alone =
            steps().chain(FAR).map(|s| ((ALONE * each).ln(), Moments { variance: middle.variance + s * s, ..middle }));
        let whole: Vec<(f64, Moments)> =
            stepped.into_iter().map(|(ln, part)| ((WHOLE * each).ln() + ln, part)).collect();
        // above any step that the flank is allowed
        let beyond = whole.iter().max_by(|a, b| a.0.total_cmp(&b.0)).copied();
        let beyond = beyond.into_iter().flat_map(|(ln, part)| {
            FAR.map(|s| (ln + (ALONE * each).ln(), Moments { variance: part.variance + s * s, ..part }))
        });
        let still = parts
            .into_iter()
            .filter(|(weight, _)| *weight > NOTHING)
            .map(|(weight, part)| (((1.0 - ALONE - WHOLE) * weight).ln(), part));
        Prediction { parts: still.chain(alone).chain(whole.iter().copied()).chain(beyond).collect() }
    }

    /// δ(c).
    fn mean(&self, c: f64) -> f64 {
        let ln = |(ln, part): &(f64, Moments)| {
            let variance = 1.0 + part.variance;
            ln - 0.5 * ((c - part.mean).powi(2) / variance + variance.ln())
        };
        let most = self.parts.iter().map(ln).fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut mean) = (0.0, 0.0);
        for one in &self.parts {
            let (weight, part) = ((ln(one) - most).exp(), &one.1);
            sum += weight;
            mean += weight * (part.mean + part.variance / (1.0 + part.variance) * (c - part.mean));
        }
        mean / sum
    }

    /// The end of the interval that lies below (−1) or above (+1) least squares, 0; infinite where
    /// it is not found.
    fn end(&self, way: f64, noise: &Noise) -> f64 {
        let student: &Student = &noise.student;
        let two_sided = noise.quantile();
        // above 0 where c is held; outside the bounds of q only the sign counts
        let held = |distance: f64| {
            let c = way * distance;
            let aside = (c - self.mean(c)).abs();
            if distance > aside + two_sided {
                return -noise.miss;
            }
            student.upper_tail(distance - aside) + student.upper_tail(distance + aside) - noise.miss
        };
        let place = |k: u32| FARTHEST * two_sided * f64::from(k) / f64::from(APART);
        let mut outer = (place(APART), held(place(APART)));
        if !(outer.1 < 0.0) {
            return f64::INFINITY;
        }
        for inner in (0..APART).rev().map(place) {
            let inner = (inner, held(inner));
            if inner.1 >= 0.0 {
                let found = root([inner, outer], |x| 1e-13 * x, held);
                return self.mean(way * found.unwrap_or(inner.0));
            }
            outer = inner;
        }
        f64::INFINITY
    }
}

impl Outlook {
    fn new(branch: &Branch) -> Self {
        let posterior = Known { mean: branch.posterior.mean(), root: branch.posterior.inverse() };
        Outlook { posterior, ln: branch.ln_all - branch.ln_earlier }
    }

    /// Moments of the form of length 1 by all but its own least squares, and the logarithm of the
    /// likelihood of the part orthogonal to it. With its posterior mean p and variance v they
    /// follow from how least squares, 0 with variance 1, was combined with them.
    fn without(&self, unit: &[f64]) -> (Moments, f64) {
        /// Rounding error of 1 − v, relative to v.
        const ROUNDING: f64 = 1e-12;
        let posterior = self.posterior.of(unit);
        let left = (1.0 - posterior.variance).max(ROUNDING);
        let moments = Moments { mean: posterior.mean / left, variance: posterior.variance / left };
        (moments, self.ln + 0.5 * (posterior.mean * moments.mean - left.ln()))
    }
}

impl Known {
    fn of(&self, unit: &[f64]) -> Moments {
        let along = |column: usize| -> f64 {
            self.root.column(column).iter().take(column + 1).zip(unit).map(|(r, u)| r * u).sum()
        };
        Moments { mean: dot(&self.mean, unit), variance: (0..unit.len()).map(|j| along(j).powi(2)).sum() }
    }
}

/// The logarithm of what a size counts beforehand.
fn beforehand(size: f64) -> f64 {
    size.max(LEAST).ln()
}

/// `ln Σ exp`.
fn sum(ln: &[f64]) -> f64 {
    ln_sum(ln.iter().copied())
}

fn dot(x: &DVector<f64>, y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prediction(parts: &[(f64, f64, f64)]) -> Prediction {
        Prediction::new(parts.iter().map(|&(w, mean, variance)| (w, Moments { mean, variance })).collect(), Vec::new())
    }

    /// The truth is held with the probability that is said wherever it lies: by integration over
    /// least squares, for predictions near and far.
    #[test]
    fn every_truth_is_held() {
        for level in [0.8, 0.95, 0.999] {
            let noise = Noise::known(1.0, level);
            for (mean, variance) in [(0.0, 0.05), (0.0, 1.0), (0.0, 400.0)] {
                for truth in [0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 100.0, 1e4] {
                    let (steps, wide) = (1200, 6.0);
                    let mut held = 0.0;
                    for k in 0..=steps {
                        let z = wide * (2.0 * f64::from(k) / f64::from(steps) - 1.0);
                        // from least squares at 0 the truth is at −z
                        let found = prediction(&[(1.0, mean - truth - z, variance)]);
                        let ends = [-1.0, 1.0].map(|way| found.end(way, &noise));
                        let inside = ends[0] <= -z && -z <= ends[1];
                        held += f64::from(u8::from(inside)) * (-0.5 * z * z).exp();
                    }
                    held *= 2.0 * wide / f64::from(steps) / (2.0 * std::f64::consts::PI).sqrt();
                    // the step of the integration takes or adds one ordinate at each end
                    assert!((-0.005..0.02).contains(&(held - level)), "{level} {variance} {truth}: {held}");
                }
            }
        }
    }

    /// Without prior knowledge the interval is Student's; with much it is as short as Pratt's bound
    /// allows, 0.85 of it on average at a truth that is as predicted.
    #[test]
    fn prior_knowledge_shortens_the_interval() {
        let noise = Noise::known(1.0, 0.95);
        let far = prediction(&[(1.0, 0.0, 1e12)]);
        assert!((far.end(1.0, &noise) - noise.quantile()).abs() < 1e-3);
        let near = prediction(&[(1.0, 0.0, 0.01)]);
        let [low, high] = [-1.0, 1.0].map(|way| near.end(way, &noise));
        assert!((low + high).abs() < 1e-12);
        assert!((high / noise.quantile()) < 0.86, "{high}");
    }

    /// Both least squares and the mean of what is known lie inside.
    #[test]
    fn it_holds_its_means() {
        let noise = Noise::estimated(1.0, 12.0, 0.95);
        for mean in [-40.0, -7.0, -3.0, -1.0, 0.0, 0.5, 2.0, 4.0, 9.0, 300.0] {
            for variance in [0.02, 0.3, 2.0, 50.0] {
                let found = prediction(&[(0.5, mean, variance), (0.5, mean + 0.3, 3.0 * variance)]);
                let [low, high] = [-1.0, 1.0].map(|way| found.end(way, &noise));
                let middle = found.mean(0.0);
                assert!(low < 0.0 && high > 0.0 && low < middle && middle < high, "{mean} {variance}: {low} {high}");
            }
        }
    }
}
