//! Intervals of single forms of the coefficients that hold whatever the flank did.
//!
//! The earlier iterations predict a form before the nodes of now are seen, by a mixture of normal
//! distributions: with the share [`OWN`] the form moves by a size of its own, told by its own
//! estimates, else by that of all, and with the share [`STEP`] the last move was a step. Let δ(y)
//! be the mean of the form given least squares y of the nodes of now; it grows with y, so every
//! value θ is δ(c) of one c. The interval holds all θ with
//!
//! ```text
//! |y − c| ≤ q(c − θ),  P(|T + b| ≤ q(b)) = level
//! ```
//!
//! Least squares is distributed about the truth as T, and what is predicted rests on other nodes.
//! So the truth is held with the probability that is said, whatever it is; what was known before
//! only makes the interval shorter where it is right (Pratt, JASA 56, 1961; Yu and Hoff, Biometrika
//! 105, 2018). It always holds least squares and δ(y).

use nalgebra::{DMatrix, DVector};

use super::chain::{Branch, Link, ln_sum, median, steps, weights};
use crate::{
    estimation::inference::Noise,
    numerics::{distribution::Student, root::root},
};

/// The probability beforehand that a form moves by a size of its own.
const OWN: f64 = 0.9;
/// The probability beforehand that its last move was a step.
const STEP: f64 = 0.3;
/// What size 0 counts as beside the others, which count as their own size: what seems to stand
/// still may only have moved too little to be told.
const LEAST: f64 = 0.01;
/// Shares of the whole below which a part is left out.
const NOTHING: f64 = 1e-6;
/// How far from least squares c is looked for, in halves of Student's interval, and in how many
/// steps of it. Beyond it what was known is so far off that the interval is Student's.
const FARTHEST: f64 = 8.0;
const APART: u32 = 32;

/// What every form is found from, in units of σ from least squares of the nodes of now.
pub(crate) struct FormIntervals {
    sizes: Vec<f64>,
    /// The logarithm of what each size counts beforehand and by the jumps before the last.
    ln_of_all: Vec<f64>,
    /// What is predicted with each size that is likely enough.
    predicted: Vec<Option<Known>>,
    /// What each earlier iteration says by itself, with its move to the next; none where one of
    /// them does not determine every coefficient.
    earlier: Vec<(Known, DVector<f64>)>,
}

/// A mean and an upper triangular root `R⁻¹` of the covariance.
struct Known {
    mean: DVector<f64>,
    root: DMatrix<f64>,
}

/// Mean and variance of a form.
#[derive(Clone, Copy)]
struct Moments {
    mean: f64,
    variance: f64,
}

impl FormIntervals {
    pub(super) fn new(links: &[Link], branches: &[Branch], sizes: &[f64]) -> Self {
        let alone = |link: &Link| {
            let known = Known { mean: link.rows.mean(), root: link.rows.inverse() };
            link.rows.is_whole().then(|| (known, link.shift.clone()))
        };
        let ln_of_all: Vec<f64> =
            branches.iter().zip(sizes).map(|(branch, size)| branch.ln_earlier + beforehand(*size)).collect();
        let predicted = |(branch, weight): (&Branch, f64)| {
            (weight > NOTHING).then(|| Known { mean: branch.prior.mean(), root: branch.prior.inverse() })
        };
        FormIntervals {
            sizes: sizes.to_vec(),
            predicted: branches.iter().zip(weights(ln_of_all.iter().copied())).map(predicted).collect(),
            ln_of_all,
            earlier: links.iter().map(alone).collect::<Option<_>>().unwrap_or_default(),
        }
    }

    /// How far the ends of the interval of the form lie from least squares, in σ.
    pub(crate) fn of(&self, form: &[f64], noise: &Noise) -> [f64; 2] {
        let length = form.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0) {
            return [0.0; 2];
        }
        let unit: Vec<f64> = form.iter().map(|x| x / length).collect();
        let predicted = self.prediction(&unit);
        let [low, high] = [-1.0, 1.0].map(|way| predicted.end(way, noise));
        let half = noise.quantile();
        let ends = if low.is_finite() && high.is_finite() { [low, high] } else { [-half, half] };
        ends.map(|end| length * end)
    }

    /// What is known of a form of length 1 before the nodes of now.
    fn prediction(&self, unit: &[f64]) -> Prediction {
        let weight = weights(self.ln_of_all.iter().copied());
        let all = weight.into_iter().zip(self.predicted.iter().map(|one| Some(one.as_ref()?.of(unit))));
        let own = (!self.earlier.is_empty()).then(|| self.by_itself(unit));
        let Some((alone, ln_of_own)) = own else {
            return Prediction::new(all.filter_map(|(weight, part)| Some((weight, part?))).collect());
        };
        let sum = |ln: &[f64]| ln_sum(ln.iter().copied());
        // the likelihoods of the others alone
        let ln_before = self.sizes.iter().map(|size| beforehand(*size));
        let ln_of_rest =
            self.ln_of_all.iter().zip(&ln_of_own).zip(ln_before.clone()).map(|((all, own), b)| all - own + b);
        let odds = sum(&ln_of_own) + ln_sum(ln_of_rest) - sum(&self.ln_of_all) - ln_sum(ln_before);
        let share = 1.0 / (1.0 + (1.0 - OWN) / OWN * (-odds).exp());
        // in the order of the sizes, for the median
        let own =
            weights(ln_of_own.iter().copied()).into_iter().zip(alone).map(|(weight, part)| (share * weight, part));
        let all = all.map(|(weight, part)| Some(((1.0 - share) * weight, part?)));
        let parts = all.zip(own).flat_map(|(all, own)| all.into_iter().chain([own])).collect();
        Prediction::new(parts)
    }

    /// What the form's own estimates predict with each size of its moves, and the logarithms of
    /// what each counts by them: a Kalman filter of one number.
    fn by_itself(&self, unit: &[f64]) -> (Vec<Moments>, Vec<f64>) {
        let estimates: Vec<(Moments, f64)> =
            self.earlier.iter().map(|(known, shift)| (known.of(unit), dot(shift, unit))).collect();
        let Some(((first, moved), rest)) = estimates.split_first() else { return Default::default() };
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
        self.sizes.iter().map(follow).unzip()
    }
}

/// A mixture of normal distributions that predicts a form.
struct Prediction {
    /// The logarithm of the weight over the standard deviation of least squares, of each part.
    parts: Vec<(f64, Moments)>,
}

impl Prediction {
    fn new(parts: Vec<(f64, Moments)>) -> Self {
        let middle = parts[median(parts.iter().map(|(weight, _)| *weight))].1;
        let share = STEP / steps().len() as f64;
        let stepped = steps().map(|s| (share, Moments { variance: middle.variance + s * s, ..middle }));
        let kept = parts.into_iter().filter(|(weight, _)| *weight > NOTHING).map(|(w, part)| ((1.0 - STEP) * w, part));
        let ln = |(weight, part): (f64, Moments)| (weight.ln() - 0.5 * (1.0 + part.variance).ln(), part);
        Prediction { parts: kept.chain(stepped).map(ln).collect() }
    }

    /// δ(c).
    fn mean(&self, c: f64) -> f64 {
        let ln = |(ln, part): &(f64, Moments)| ln - 0.5 * (c - part.mean).powi(2) / (1.0 + part.variance);
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
        // above 0 where c is held; beyond bounds of q only the sign counts
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

fn dot(x: &DVector<f64>, y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prediction(parts: &[(f64, f64, f64)]) -> Prediction {
        Prediction::new(parts.iter().map(|&(w, mean, variance)| (w, Moments { mean, variance })).collect())
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

    /// Nothing known is Student's interval; much known is as short as Pratt's bound allows, 0.85 of
    /// it on average at a truth that is as predicted.
    #[test]
    fn what_is_known_makes_it_shorter() {
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
