//! The choice of λ* (Eq. 49 and other criteria).
//!
//! Least condition has a closed form. Every other criterion is a sum over the spectrum, searched on
//! ln λ*: a grid finds *all* local minima (there may be several, and the eigenvalues are kinks),
//! the sign change of the derivative refines each, and the best one wins; of equals the smallest
//! λ*, which biases least.

use std::ops::Range;

use super::{
    filter::Rule,
    likelihood::Likelihood,
    spectral::{Spectral, Sums, SumsAtFour},
};
use crate::spec::{Criterion, Scheme};
use flankfit_numerics::{lanes::LANES, minimize::minimum, root::root};

/// Grid points for each factor of e between the ends of the search.
const DENSITY: f64 = 2.5;
/// Most grid cells between two eigenvalues.
const MOST: f64 = 400.0;
/// Further grid points, at these distances in ln λ* behind the place where a direction joins.
const JOINING: [f64; 3] = [1e-4, 3e-3, 6e-2];
/// Relative accuracy of λ* where a derivative changes sign, and where only heights are compared.
const ROOT: f64 = 1e-14;
const PEAK: f64 = 1e-8;
/// Relative difference below which values of a criterion count as equal.
const LEVEL: f64 = 1e-12;
/// A peak of the curvature seen on the grid is refined when it is at least this large against the
/// largest.
const WORTH_REFINING: f64 = 0.25;

/// Choice of a criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chosen {
    pub lambda_star: f64,
    /// All minimisers, where they form a plateau.
    pub interval: Option<[f64; 2]>,
    pub place: Place,
}

/// Position of the selected parameter in the search range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Inside the range, or no range is searched.
    Inside,
    /// At an end of the range: the criterion still falls or is level there.
    Limit,
    /// At the upper end of the range: the discrepancy is not reached.
    Missed,
}

impl Place {
    /// Returns the position of the minimum `best`, given the values at both ends.
    pub(crate) fn of(best: f64, ends: [f64; 2]) -> Self {
        let is_best = |end: f64| end <= best + LEVEL * best.abs();
        if ends.into_iter().any(is_best) { Place::Limit } else { Place::Inside }
    }
}

/// Reason why a criterion has no choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unavailable {
    /// No σ: as many coefficients as nodes and no `noise_sigma`.
    NoSigma,
    /// Least condition has no minimiser for ridge: the condition falls for ever.
    NoMinimiser,
}

/// Range in which λ* is searched: [λ₁, λₙ], and for penalties [1e-8 λ₁, 1e4 λₙ].
pub(crate) fn range(problem: &Spectral, rule: Rule) -> [f64; 2] {
    let low = problem.lambda.iter().copied().find(|l| *l > 0.0).unwrap_or(1.0);
    let high = problem.lambda.last().copied().unwrap_or(1.0).max(low);
    if rule.is_penalty() { [1e-8 * low, 1e4 * high] } else { [low, high] }
}

/// λ* by least condition, closed form (mathematics in docs/explanation/mathematics.md): for `1 ≤ L
/// < n` the low end of the plateau [b, a], or a.
pub(super) fn least_condition(lambda: &[f64], scheme: Scheme, count: usize) -> Chosen {
    let largest = lambda[lambda.len() - 1];
    let (low, high) = match scheme {
        Scheme::Exact => (lambda[count], largest),
        Scheme::FirstOrder => {
            let meet = |x: f64, y: f64| 2.0 * (x.sqrt() * y.sqrt()) - x;
            let a = meet(lambda[0], largest);
            let k = lambda[..count].iter().filter(|l| **l <= a).count().max(1);
            (meet(lambda[k - 1], lambda[k]), a)
        }
    };
    if low <= high {
        Chosen { lambda_star: low, interval: Some([low, high]), place: Place::Inside }
    } else {
        Chosen { lambda_star: high, interval: None, place: Place::Inside }
    }
}

/// Sums over a grid on ln λ*, shared by all criteria. Between two regularised eigenvalues every
/// criterion is smooth; at them its slope jumps, so each stretch has a grid of its own, its ends
/// seen from inside.
pub(crate) struct Search<'a> {
    problem: &'a Spectral<'a>,
    rule: Rule,
    stretches: Vec<Stretch>,
}

struct Stretch {
    touched: Range<usize>,
    /// ln λ* of the grid.
    places: Vec<f64>,
    /// The sums there, four places side by side.
    sums: Vec<SumsAtFour>,
}

impl<'a> Search<'a> {
    /// Lays the grids.
    pub(crate) fn new(problem: &'a Spectral<'a>, rule: Rule) -> Self {
        let stretches = problem
            .stretches(rule, range(problem, rule))
            .into_iter()
            .map(|([low, high], touched)| {
                let cells = ((high - low) * DENSITY).ceil().clamp(1.0, MOST) as usize;
                // the curvature may peak close behind the place where a direction joins
                let near = JOINING.iter().map(|d| low + d).filter(|x| *x < low + (high - low) / cells as f64);
                let even = (1..=cells).map(|i| low + (high - low) * (i as f64 / cells as f64));
                let places: Vec<f64> = std::iter::once(low).chain(near).chain(even).collect();
                let at = |four: &[f64]| {
                    let x: [f64; LANES] = std::array::from_fn(|k| four[k.min(four.len() - 1)]);
                    problem.sums_at_four(rule, x.map(f64::exp), touched.clone())
                };
                let sums = places.chunks(LANES).map(at).collect();
                Stretch { touched, places, sums }
            })
            .collect();
        Search { problem, rule, stretches }
    }

    /// The sums at place `k` of the grid.
    #[inline(always)]
    fn of_grid(&self, stretch: &Stretch, k: usize) -> Sums {
        self.problem.sums_of(&stretch.sums[k / LANES], k % LANES, stretch.touched.end)
    }

    /// The sums at ln λ* = x.
    #[inline(always)]
    fn sums(&self, stretch: &Stretch, x: f64) -> Sums {
        self.problem.sums_touching(self.rule, x.exp(), stretch.touched.clone())
    }

    /// Returns λ* from its logarithm. The range of spectral schemes is their whole parameter range,
    /// not a limit of the search.
    fn chosen(&self, (x, place): (f64, Place)) -> Chosen {
        let place = if self.rule.is_penalty() { place } else { Place::Inside };
        Chosen { lambda_star: x.exp(), interval: None, place }
    }

    /// Returns the parameter that `criterion` selects.
    pub(crate) fn choose(&self, criterion: Criterion) -> Result<Chosen, Unavailable> {
        let chosen = |found| Ok(self.chosen(found));
        let freedom = self.problem.count > self.problem.lambda.len() + self.problem.unpenalised;
        match (criterion, self.rule) {
            (Criterion::MinCondition, Rule::Spectral { scheme, count }) if count > 0 => {
                Ok(least_condition(self.problem.lambda, scheme, count))
            }
            (Criterion::MinCondition, _) => Err(Unavailable::NoMinimiser),
            (Criterion::MinMse, _) => match self.problem.variance {
                None => Err(Unavailable::NoSigma),
                Some(_) => chosen(self.minimise(|s| s.mse[0], |s| s.mse[1])),
            },
            (Criterion::Gcv, _) if !freedom && self.problem.variance.is_none() => Err(Unavailable::NoSigma),
            (Criterion::Gcv, _) => chosen(self.minimise(|s| self.gcv(s), |s| self.gcv_slope(s))),
            (Criterion::LCurve, _) => chosen(self.corner()),
            // closed forms, which need no search
            (Criterion::Hkb | Criterion::Hkb1975 | Criterion::LawlessWang | Criterion::Optimal, _) => {
                Err(Unavailable::NoMinimiser)
            }
            (Criterion::Sure, _) => {
                match self.problem.variance {
                    None => Err(Unavailable::NoSigma),
                    Some(variance) => chosen(self.minimise(
                        |s| s.rss[0] + 2.0 * variance * s.trace[0],
                        |s| s.rss[1] + 2.0 * variance * s.trace[1],
                    )),
                }
            }
            (Criterion::Reml, _) => self.likeliest().map_or(Err(Unavailable::NoSigma), chosen),
            // need the nodes
            (Criterion::Press | Criterion::BlockedCv, _) => Err(Unavailable::NoMinimiser),
            (Criterion::Discrepancy, _) => match self.problem.variance {
                None => Err(Unavailable::NoSigma),
                Some(variance) => Ok(self.discrepancy(self.problem.count as f64 * variance)),
            },
        }
    }

    /// `‖Y − X Â_B‖² / (1 − Σfᵢ/m)²`; infinite where nothing is left in the denominator.
    pub(crate) fn gcv(&self, sums: &Sums) -> f64 {
        let left = 1.0 - sums.trace[0] / self.problem.count as f64;
        if left > 1e-14 { sums.rss[0] / (left * left) } else { f64::INFINITY }
    }

    fn gcv_slope(&self, sums: &Sums) -> f64 {
        let m = self.problem.count as f64;
        sums.rss[1] * (1.0 - sums.trace[0] / m) + 2.0 * sums.rss[0] * sums.trace[1] / m
    }

    /// The best of all local minima; `slope` need only have the derivative's sign.
    fn minimise(&self, value: impl Fn(&Sums) -> f64, slope: impl Fn(&Sums) -> f64) -> (f64, Place) {
        let (mut best, mut at) = (f64::INFINITY, self.stretches[0].places[0]);
        let mut ends = Ends::default();
        let mut heights = Vec::new();
        for stretch in &self.stretches {
            heights.clear();
            heights.extend((0..stretch.places.len()).map(|k| value(&self.of_grid(stretch, k))));
            ends.see(&heights);
            for (k, bracket) in peaks(&heights, |here, there| here <= there) {
                let end = |k: usize| (stretch.places[k], slope(&self.of_grid(stretch, k)));
                let refined = sign_change(end(bracket.0), end(bracket.1), |x| slope(&self.sums(stretch, x)));
                let there = refined.map(|x| (x, value(&self.sums(stretch, x))));
                for (x, height) in std::iter::once((stretch.places[k], heights[k])).chain(there) {
                    // a gain below rounding is no gain: prefer the smaller λ*
                    if height < best - 1e-15 * best.abs() || (best == f64::INFINITY && height.is_finite()) {
                        (best, at) = (height, x);
                    }
                }
            }
        }
        (at, ends.place(best))
    }

    /// Place of greatest restricted likelihood; `None` if the likelihood is constant.
    fn likeliest(&self) -> Option<(f64, Place)> {
        let stretch = self.stretches.last()?;
        let likelihood = Likelihood::new(self.problem, self.rule, stretch.touched.clone())?;
        let found: Vec<(f64, f64)> = stretch.places.iter().map(|x| likelihood.at(*x)).collect();
        let heights: Vec<f64> = found.iter().map(|(height, _)| *height).collect();
        let (mut best, mut at) = (f64::INFINITY, self.stretches[0].places[0]);
        for (k, bracket) in peaks(&heights, |here, there| here <= there) {
            let end = |k: usize| (stretch.places[k], found[k].1);
            let refined = sign_change(end(bracket.0), end(bracket.1), |x| likelihood.at(x).1);
            let there = refined.map(|x| (x, likelihood.at(x).0));
            for (x, height) in std::iter::once((stretch.places[k], heights[k])).chain(there) {
                if height < best {
                    (best, at) = (height, x);
                }
            }
        }
        let mut ends = Ends::default();
        ends.see(&heights);
        Some((at, ends.place(best)))
    }

    /// The least value of what the nodes say of λ*: of `value` at `1 − fᵢ` of every direction.
    pub(crate) fn least_of_nodes(&self, value: impl Fn(&[f64]) -> f64) -> Chosen {
        let at = |stretch: &Stretch, x: f64| {
            let removed: Vec<f64> = (0..self.problem.lambda.len())
                .map(|i| match stretch.touched.contains(&i) {
                    true => self.rule.at(i, self.problem.lambda[i], x.exp()).removed,
                    false => 0.0,
                })
                .collect();
            value(&removed)
        };
        let (mut best, mut place) = (f64::INFINITY, self.stretches[0].places[0]);
        let mut seen = Ends::default();
        for stretch in &self.stretches {
            let heights: Vec<f64> = stretch.places.iter().map(|x| at(stretch, *x)).collect();
            seen.see(&heights);
            for (k, bracket) in peaks(&heights, |here, there| here <= there) {
                let ends = [stretch.places[bracket.0], stretch.places[bracket.1]];
                let (x, height) = minimum(ends, (stretch.places[k], heights[k]), PEAK, |x| at(stretch, x));
                // a gain below rounding is no gain: prefer the smaller λ*
                if height < best - 1e-13 * best.abs() || (best == f64::INFINITY && height.is_finite()) {
                    (best, place) = (height, x);
                }
            }
        }
        self.chosen((place, seen.place(best)))
    }

    /// The place of greatest curvature of (log ‖Y − XÂ_B‖, log ‖Â_B‖).
    fn corner(&self) -> (f64, Place) {
        let curvatures =
            |s: &Stretch| (0..s.places.len()).map(|k| curvature(&self.of_grid(s, k))).collect::<Vec<f64>>();
        let heights: Vec<Vec<f64>> = self.stretches.iter().map(curvatures).collect();
        let largest = heights.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mut best, mut at) = (f64::NEG_INFINITY, self.stretches[0].places[0]);
        for (stretch, heights) in self.stretches.iter().zip(&heights) {
            for (k, bracket) in peaks(heights, |here, there| here >= there) {
                if heights[k] < WORTH_REFINING * largest {
                    continue;
                }
                let place = |k: usize| stretch.places[k];
                let middle = (place(k), -heights[k]);
                let (x, height) =
                    minimum([place(bracket.0), place(bracket.1)], middle, PEAK, |x| -curvature(&self.sums(stretch, x)));
                if -height > best {
                    (best, at) = (-height, x);
                }
            }
        }
        let mut ends = Ends::default();
        heights.iter().for_each(|heights| ends.see(&heights.iter().map(|height| -height).collect::<Vec<f64>>()));
        (at, ends.place(-best))
    }

    fn discrepancy(&self, target: f64) -> Chosen {
        let answer = |x: f64, place| Chosen { lambda_star: x.exp(), interval: None, place };
        let rss = |stretch: &Stretch, k: usize| self.of_grid(stretch, k).rss[0];
        let first = &self.stretches[0];
        if rss(first, 0) >= target {
            return answer(first.places[0], Place::Inside);
        }
        for stretch in &self.stretches {
            if let Some(k) = (1..stretch.places.len()).find(|k| rss(stretch, *k) >= target) {
                let end = |k: usize| (stretch.places[k], rss(stretch, k) - target);
                let x = sign_change(end(k - 1), end(k), |x| self.sums(stretch, x).rss[0] - target);
                return answer(x.unwrap_or(stretch.places[k]), Place::Inside);
            }
        }
        answer(range(self.problem, self.rule)[1].ln(), Place::Missed)
    }
}

/// Values of a criterion at the ends of its grid, which is scanned interval by interval.
#[derive(Default)]
struct Ends {
    first: Option<f64>,
    last: f64,
}

impl Ends {
    fn see(&mut self, heights: &[f64]) {
        self.first = self.first.or(heights.first().copied());
        self.last = heights.last().copied().unwrap_or(self.last);
    }

    fn place(&self, best: f64) -> Place {
        Place::of(best, [self.first.unwrap_or(f64::INFINITY), self.last])
    }
}

/// Grid points at least as good as their neighbours, with the neighbours' numbers.
fn peaks(heights: &[f64], good: impl Fn(f64, f64) -> bool) -> impl Iterator<Item = (usize, (usize, usize))> {
    let last = heights.len() - 1;
    (0..=last).map(move |k| (k, (k.saturating_sub(1), (k + 1).min(last)))).filter(move |&(k, (before, after))| {
        heights[k].is_finite() && good(heights[k], heights[before]) && good(heights[k], heights[after])
    })
}

/// Curvature of the L-curve, positive at its corner; −∞ where the curve has no velocity.
fn curvature(sums: &Sums) -> f64 {
    let half_log = |y: &[f64; 3]| {
        let (first, second) = (y[1] / y[0], y[2] / y[0]);
        (0.5 * first, 0.5 * (second - first * first))
    };
    let ((x1, x2), (y1, y2)) = (half_log(&sums.rss), half_log(&sums.norm));
    let speed = x1 * x1 + y1 * y1;
    let curvature = (x1 * y2 - x2 * y1) / (speed * speed.sqrt());
    if curvature.is_finite() { curvature } else { f64::NEG_INFINITY }
}

/// Place at which `f` turns from negative to positive between the ends (places with their values),
/// if it does.
fn sign_change(falls: (f64, f64), rises: (f64, f64), f: impl Fn(f64) -> f64) -> Option<f64> {
    if !(falls.1 < 0.0 && rises.1 > 0.0) {
        return None;
    }
    root([falls, rises], |x| ROOT * x.abs().max(1.0), f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn condition(lambda: &[f64], scheme: Scheme, count: usize, at: f64) -> f64 {
        let rule = Rule::Spectral { scheme, count };
        let problem = Spectral::new(lambda, lambda, None, 0.0, 9, 0);
        problem.condition(rule, at).unwrap()
    }

    proptest! {
        /// No λ* on a fine grid beats the closed form, and the whole plateau is as good.
        #[test]
        fn nothing_beats_the_closed_form(
            logs in proptest::collection::vec(-12.0f64..0.0, 2..8),
            count in 1usize..7,
            exact: bool,
        ) {
            let mut lambda: Vec<f64> = logs.iter().map(|x| 10f64.powf(*x)).collect();
            lambda.sort_by(f64::total_cmp);
            let count = count.min(lambda.len() - 1);
            let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
            let chosen = least_condition(&lambda, scheme, count);
            let best = condition(&lambda, scheme, count, chosen.lambda_star);
            if let Some([low, high]) = chosen.interval {
                for s in 0..=20 {
                    let at = low * (high / low).powf(s as f64 / 20.0);
                    prop_assert!((condition(&lambda, scheme, count, at) / best - 1.0).abs() < 1e-9);
                }
            }
            let (first, last) = (lambda[0], lambda[lambda.len() - 1]);
            for s in 0..=2000 {
                let at = first * (last / first).powf(s as f64 / 2000.0);
                prop_assert!(condition(&lambda, scheme, count, at) >= best * (1.0 - 1e-9));
            }
        }
    }
}
