//! The predicted mean squared error, corrected for λ* having been chosen by the nodes that it is
//! predicted from.
//!
//! `predicted_mse` takes λ* as given and is too small, since it is the least of many. How much is
//! found by simulation (parametric bootstrap): t takes the place of the truth,
//! `a* = t + σ̂ λ^{−½} N(0,1)` with `σ*² = σ̂² χ²_ν/ν` are measured again, λ* is chosen anew by the
//! same rule, and
//!
//! `corrected = predicted_mse · Σ‖f*a* − t‖² / Σ predicted_mse*`
//!
//! Product and quotient hang on the same σ̂²: where it is too large by chance, so is the quotient,
//! and the mean of the product is not the product of the means (with three degrees of freedom 1.34
//! times the error, and 1.18 at most as it is done here). For every g,
//!
//! `E[σ² g(σ̂²)] = E[σ̂² ∫₀¹ g(w σ̂²) dw^{ν/2}]`
//!
//! (integrate the density of χ² by parts), so that the quotient is the mean of those simulated at
//! [`LEVELS`] equal shares of this distribution of w, with t held.
//!
//! with t = (1 − v/‖fa‖²)₊ fa, v being the variance of fa (James and Stein): the regularised
//! estimate still has what noise the filter lets pass, and with it for a truth the quotient would
//! be up to a tenth farther from the true one. The sums go over [`DRAWS`] draws. The answer is at
//! least v, which no choice takes away: where a rule lets pass what others would damp, the sums are
//! those of the few draws that lie far off. The seed is fixed: the same nodes give the same figure.
//! So an error of the draws would be that of every fit, and errors have heavy tails: along each
//! direction the draws are a Latin hypercube, one in each equal share of the normal distribution
//! (McKay, Beckman and Conover, Technometrics 21, 1979), and so are those of χ²; their variance and
//! mean are made those of the distributions. Each draw counts away from 0 as the coefficient does,
//! so that neither the sign of the heights nor that of an eigenvector changes anything.
//!
//! With few degrees of freedom t, drawn towards 0 by a wrong σ̂, leaves too little. There Stein's
//! unbiased estimate of the error, `Σ (1−f)²a² + σ̂²/λ (2 ∂(fa)/∂a − 1)` with derivatives through
//! the choice of λ* (Stein, Annals of Statistics 9, 1981), has the share (2/ν)², the square of the
//! relative variance of σ̂², and at most half: alone it scatters too widely, and is negative where
//! little is left.

use nalgebra::DVector;

use super::{context::Context, oblique::Oblique};
use crate::{
    randomization::normal::Normals,
    selection::{
        Rule, Spectral,
        filters::{self, SelectedFilter},
    },
    spec::{Criterion, Parameter},
};
use flankfit_numerics::{
    cancel::Asking,
    distribution::{chi_squared, normal},
};

/// Draws of the simulation, and how many there are where each takes long: of so many directions.
const DRAWS: usize = 240;
const FEWER_DRAWS: usize = 60;
const MANY_DIRECTIONS: usize = 50;
/// At how many noises the quotient is simulated.
const LEVELS: usize = 4;
const SEED: u64 = 0x5eed;
/// Beyond so many degrees of freedom χ² is the cube of a normal number (Wilson and Hilferty).
const FEW: usize = 100;
/// The share of Stein's estimate at most, and that below which it is left out.
const MOST_OF_STEIN: f64 = 0.5;
const LEAST_OF_STEIN: f64 = 0.01;
/// The step of its derivatives in standard errors: λ* may jump, which is an error too.
const STEP: f64 = 0.3;

/// Noise from which σ is drawn: its variance, and its degrees of freedom.
#[derive(Clone, Copy)]
struct Noise {
    variance: f64,
    given: bool,
    freedom: usize,
}

impl Noise {
    fn of(context: &Context) -> Option<Self> {
        let variance = context.variance?;
        Some(Noise { variance, given: context.spec.noise_sigma.is_some(), freedom: context.degrees_of_freedom })
    }

    /// σ̂² times w at equal shares of its distribution.
    fn levels(&self) -> Vec<Self> {
        if self.given || self.freedom == 0 {
            return vec![*self];
        }
        let exponent = 2.0 / self.freedom as f64;
        let at = |level: usize| libm::pow((level as f64 + 0.5) / LEVELS as f64, exponent);
        (0..LEVELS).map(|level| Noise { variance: at(level) * self.variance, ..*self }).collect()
    }

    /// χ²/ν at `draws` equal shares of its distribution, ascending, with mean 1.
    fn shares(&self, draws: usize) -> Vec<f64> {
        let nu = self.freedom as f64;
        let spread = 2.0 / (9.0 * nu);
        let at = |rank: usize| match self.freedom {
            0 => 1.0,
            few if few <= FEW => chi_squared::upper_quantile(1.0 - (rank as f64 + 0.5) / draws as f64, nu) / nu,
            _ => (1.0 - spread + spread.sqrt() * middle(rank, draws)).powi(3),
        };
        let found: Vec<f64> = (0..draws).map(at).collect();
        let mean = found.iter().sum::<f64>() / draws as f64;
        found.iter().map(|x| x / mean).collect()
    }

    /// σ*² and RSS* where χ²/ν is `share`.
    fn at(&self, share: f64) -> [f64; 2] {
        let drawn = self.variance * share;
        [if self.given { self.variance } else { drawn }, drawn * self.freedom as f64]
    }

    /// The share of Stein's estimate.
    fn share_of_stein(&self) -> f64 {
        if self.given || self.freedom == 0 {
            return 0.0;
        }
        let share = (2.0 / self.freedom as f64).powi(2).min(MOST_OF_STEIN);
        if share < LEAST_OF_STEIN { 0.0 } else { share }
    }
}

/// The middle of an equal share of the normal distribution.
fn middle(rank: usize, draws: usize) -> f64 {
    -normal::upper_quantile((rank as f64 + 0.5) / draws as f64)
}

/// The ranks of `draws` draws along direction `stream`, in an order of its own.
fn order(stream: usize, draws: usize) -> Vec<usize> {
    let lots = Normals::new(SEED, stream as u64).take(draws);
    let mut order: Vec<usize> = (0..draws).collect();
    order.sort_by(|&a, &b| lots[a].total_cmp(&lots[b]));
    order
}

/// Normal numbers along `size` directions: those of each direction are the middles of equal shares
/// of the distribution, scaled to variance 1, in the orders of the streams from `first` on.
fn hypercube(first: usize, size: usize, draws: usize) -> Vec<Vec<f64>> {
    let middles: Vec<f64> = (0..draws).map(|rank| middle(rank, draws)).collect();
    let deviation = (middles.iter().map(|z| z * z).sum::<f64>() / draws as f64).sqrt();
    let mut rows = vec![vec![0.0; size]; draws];
    for i in 0..size {
        for (draw, middle) in order(first + i, draws).into_iter().zip(&middles) {
            rows[draw][i] = middle / deviation;
        }
    }
    rows
}

/// Share of an estimate with this squared length that exceeds its noise, from 0 to 1.
fn share_above_noise(variance: f64, square: f64) -> f64 {
    if square > variance { 1.0 - variance / square } else { 0.0 }
}

/// `z`, counted away from 0 as `a` is.
fn along(a: f64, z: f64) -> f64 {
    if a < 0.0 { -z } else { z }
}

/// Returns `predicted` times the mean of `Σ errors / Σ predictions` over the noises, at least
/// `least`. The sums are over draws of `again`, which computes both from one normal number for each
/// of `size` directions, the variance that they are drawn with, σ*² and RSS*.
fn corrected(
    [predicted, least]: [f64; 2],
    noise: &Noise,
    (size, work): (usize, usize),
    again: impl Fn(&[f64], f64, [f64; 2]) -> Option<(f64, f64)>,
) -> Option<f64> {
    let levels = noise.levels();
    let draws = (if size > MANY_DIRECTIONS { FEWER_DRAWS } else { DRAWS }) / levels.len();
    let mut quotients = 0.0;
    for (k, level) in levels.iter().enumerate() {
        let first = k * (size + 1);
        let mut shares = vec![0.0; draws];
        order(first + size, draws).into_iter().zip(level.shares(draws)).for_each(|(draw, share)| shares[draw] = share);
        let (mut errors, mut predictions) = (0.0, 0.0);
        for (normals, share) in hypercube(first, size, draws).iter().zip(shares).asking(work) {
            let (error, prediction) = again(normals, level.variance, level.at(share))?;
            errors += error;
            predictions += prediction;
        }
        quotients += errors / predictions;
    }
    Some((predicted * quotients / levels.len() as f64).max(least)).filter(|corrected| corrected.is_finite())
}

/// Parameter by which λ was chosen; `None` if the choice uses single nodes.
fn parameter(criterion: Option<Criterion>, fixed: bool, value: f64) -> Option<Parameter> {
    match criterion {
        _ if fixed => Some(Parameter::Fixed(value)),
        Some(criterion) if criterion.is_nodewise() => None,
        Some(criterion) => Some(Parameter::Criterion(criterion)),
        None => None,
    }
}

/// Corrects the prediction of a filter on the eigenvectors, `rule` at the selected parameter.
pub(super) fn of_filter(context: &Context, problem: &Spectral, rule: Rule, selected: &SelectedFilter) -> Option<f64> {
    let (lambda, a) = (problem.lambda, &context.spectrum.a);
    let (noise, value) = (Noise::of(context)?, selected.parameter());
    let predicted = problem.sums(rule, value).mse[0];
    if rule == Rule::None {
        // least squares chooses nothing
        return Some(predicted);
    }
    let asked = parameter(selected.selection.criterion, selected.selection.fixed, value)?;
    let passed = |(i, l): (usize, &f64)| if *l > 0.0 { rule.at(i, *l, value).factor.powi(2) / l } else { 0.0 };
    let least = noise.variance * lambda.iter().enumerate().map(passed).sum::<f64>();
    let filtered: Vec<f64> = (0..a.len()).map(|i| rule.at(i, lambda[i], value).factor * a[i]).collect();
    let share = share_above_noise(least, filtered.iter().map(|x| x * x).sum());
    let truth: Vec<f64> = filtered.iter().map(|x| share * x).collect();
    let again = |drawn: &[f64], [variance, rss]: [f64; 2]| {
        let sigma = context.spec.noise_sigma;
        let again =
            Spectral::new(lambda, drawn, Some(variance), rss, problem.count, problem.unpenalised).with_sigma(sigma);
        let value = filters::choose(&again, rule, drawn, asked)?;
        Some((value, again.sums(rule, value).mse[0]))
    };
    let simulated = corrected([predicted, least], &noise, (a.len(), 2000 * a.len()), |normals, level, found| {
        let drawn: Vec<f64> = lambda
            .iter()
            .zip(truth.iter().zip(a))
            .zip(normals)
            .map(|((&l, (t, a)), z)| if l > 0.0 { t + (level / l).sqrt() * along(*a, *z) } else { 0.0 })
            .collect();
        let (value, prediction) = again(&drawn, found)?;
        let error = (0..a.len()).map(|i| (rule.at(i, lambda[i], value).factor * drawn[i] - truth[i]).powi(2)).sum();
        Some((error, prediction))
    })?;
    let share = noise.share_of_stein();
    if share == 0.0 {
        return Some(simulated);
    }
    let answered = |i: usize, aside: f64| {
        let mut moved = a.clone();
        moved[i] += aside;
        let (value, _) = again(&moved, [noise.variance, problem.rss])?;
        Some(rule.at(i, lambda[i], value).factor * moved[i])
    };
    let mut stein = 0.0;
    for i in (0..a.len()).filter(|&i| lambda[i] > 0.0).asking(4000 * a.len()) {
        let (removed, spread) = (rule.at(i, lambda[i], value).removed * a[i], noise.variance / lambda[i]);
        let aside = STEP * spread.sqrt();
        let slope = (answered(i, aside)? - answered(i, -aside)?) / (2.0 * aside);
        stein += removed * removed + spread * (2.0 * slope - 1.0);
    }
    Some((1.0 - share) * simulated + share * stein.max(least)).filter(|corrected| corrected.is_finite())
}

/// Coefficients at most for which λ of a penalty is chosen again so many times.
const MOST_OBLIQUE: usize = 200;

/// Corrects the prediction of a penalty along oblique directions at `lambda`, which `choose` finds
/// anew for other heights.
pub(super) fn of_penalty(
    context: &Context,
    oblique: &Oblique,
    lambda: f64,
    asked: (Option<Criterion>, bool),
    choose: impl Fn(&Oblique, f64, f64, Parameter) -> Option<f64>,
) -> Option<f64> {
    let noise = Noise::of(context)?;
    let asked = parameter(asked.0, asked.1, lambda)?;
    let size = oblique.delta.len();
    if size > MOST_OBLIQUE {
        return None;
    }
    let (predicted, _) = oblique.mse(lambda)?;
    let passed = |i: usize| {
        let along = DVector::from_fn(size, |k, _| if k == i { oblique.factor(i, lambda) } else { 0.0 });
        oblique.along(&along).norm_squared()
    };
    let least = noise.variance * (oblique.silent..size).asking(size * size).map(passed).sum::<f64>();
    let filtered = DVector::from_fn(size, |i, _| oblique.factor(i, lambda) * oblique.a[i]);
    let share = share_above_noise(least, oblique.along(&filtered).norm_squared());
    let truth: Vec<f64> = filtered.iter().map(|x| share * x).collect();
    corrected([predicted, least], &noise, (size, 400 * size * size), |normals, level, [variance, rss]| {
        // along these directions least squares has the variance σ²
        let drawn: Vec<f64> = truth
            .iter()
            .zip(&oblique.a)
            .enumerate()
            .map(|(i, (t, a))| if i < oblique.silent { 0.0 } else { t + level.sqrt() * along(*a, normals[i]) })
            .collect();
        let again = oblique.with(drawn.clone(), Some(variance));
        let value = choose(&again, variance, rss, asked)?;
        let error = DVector::from_fn(size, |i, _| again.factor(i, value) * drawn[i] - truth[i]);
        Some((oblique.along(&error).norm_squared(), again.mse(value)?.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every direction has each share of the normal distribution once, in an order of its own.
    #[test]
    fn a_latin_hypercube() {
        let rows = hypercube(7, 3, 60);
        let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
        assert!(column(0) != column(1) && column(1) != column(2));
        for i in 0..3 {
            let mut sorted = column(i);
            assert!((sorted.iter().map(|z| z * z).sum::<f64>() / 60.0 - 1.0).abs() < 1e-12);
            sorted.sort_by(f64::total_cmp);
            let scale = sorted[59] / -normal::upper_quantile(59.5 / 60.0);
            for (k, z) in sorted.iter().enumerate() {
                let tail = 1.0 - (k as f64 + 0.5) / 60.0;
                assert!((normal::upper_tail(*z / scale) - tail).abs() < 1e-12, "{k}: {z}");
            }
        }
    }

    /// The mean of σ̂² and of what is simulated at its levels is σ² times the mean of that at σ̂²,
    /// which the product at σ̂² itself is far from.
    #[test]
    fn levels_part_product_and_quotient() {
        let grows = |variance: f64| variance / (1.0 + variance);
        for (freedom, together) in [(1, 1.8), (3, 1.25), (10, 1.07)] {
            let all = Noise { variance: 1.0, given: false, freedom };
            let shares = all.shares(20_000);
            let mean = |of: &dyn Fn(f64) -> f64| shares.iter().map(|share| of(*share)).sum::<f64>() / 20_000.0;
            let meant = mean(&grows);
            let levels = |share: f64| {
                let levels = Noise { variance: share, ..all }.levels();
                share * levels.iter().map(|level| grows(level.variance)).sum::<f64>() / levels.len() as f64
            };
            let (found, naive) = (mean(&levels) / meant, mean(&|share| share * grows(share)) / meant);
            assert!((found - 1.0).abs() < 0.02, "{freedom}: {found}");
            assert!(naive > together, "{freedom}: {naive}");
        }
        let noise = Noise { variance: 2.0, given: true, freedom: 3 };
        assert_eq!(noise.levels().iter().map(|level| level.variance).collect::<Vec<f64>>(), [2.0]);
    }

    /// Moments of χ²/ν: mean 1, variance 2/ν but for what the outermost shares lose.
    #[test]
    fn shares_of_the_noise() {
        for freedom in [1, 3, 40, 100, 101, 5000] {
            let noise = Noise { variance: 1.0, given: false, freedom };
            let shares = noise.shares(240);
            let moment = |power: i32| shares.iter().map(|x| (x - 1.0).powi(power)).sum::<f64>() / 240.0;
            assert!(moment(1).abs() < 1e-12, "{freedom}");
            let variance = moment(2) * freedom as f64 / 2.0;
            assert!((0.85..1.01).contains(&variance), "{freedom}: {variance}");
            assert!(shares.is_sorted() && shares[0] > 0.0);
        }
        let alone = Noise { variance: 2.0, given: false, freedom: 0 };
        assert_eq!((alone.at(alone.shares(60)[7]), alone.share_of_stein()), ([2.0, 0.0], 0.0));
    }
}
