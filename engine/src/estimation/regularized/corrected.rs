//! The predicted mean squared error, corrected for λ* having been chosen by the nodes that it is
//! predicted from.
//!
//! `predicted_mse` takes λ* as given and is too small, since it is the least of many. How much is
//! found by simulation (parametric bootstrap): the regularised estimate fa takes the place of the
//! truth, `a* = fa + σ̂ λ^{−½} N(0,1)` with `σ*² = σ̂² χ²_ν/ν` are measured again, λ* is chosen
//! anew by the same rule, and
//!
//! `corrected = predicted_mse · Σ‖f*a* − fa‖² / Σ predicted_mse*`
//!
//! over [`DRAWS`] draws, and at least the variance of fa, which no choice takes away: where a rule
//! lets pass what others would damp, the sums are those of the few draws that lie far off. The seed
//! is fixed: the same nodes give the same figure. So an error of the draws would be that of every
//! fit, and errors have heavy tails: along each direction the draws are a Latin hypercube, one in
//! each sixtieth of the normal distribution (McKay, Beckman and Conover, Technometrics 21, 1979).

use nalgebra::DVector;

use super::{context::Context, oblique::Oblique};
use crate::{
    estimation::{
        randomization::normal::Normals,
        selection::{
            Rule, Spectral,
            filters::{self, SelectedFilter},
        },
        spec::{Criterion, Parameter},
    },
    numerics::{cancel::Asking, distribution::normal},
};

/// Draws of the simulation.
const DRAWS: usize = 60;
const SEED: u64 = 0x5eed;
/// Up to so many degrees of freedom χ² is a sum of squares, beyond a cube (Wilson and Hilferty).
const FEW: usize = 60;

/// What is drawn of σ: the variance, and the residual sum of squares that goes with it.
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

    /// σ*² and RSS*.
    fn draw(&self, random: &mut Normals) -> (f64, f64) {
        let nu = self.freedom as f64;
        let chi_squared = match self.freedom {
            0 => 0.0,
            few if few <= FEW => random.take(few).iter().map(|x| x * x).sum(),
            _ => {
                let share = 2.0 / (9.0 * nu);
                nu * (1.0 - share + share.sqrt() * random.draw()).powi(3)
            }
        };
        let rss = self.variance * chi_squared;
        (if self.given || self.freedom == 0 { self.variance } else { rss / nu }, rss)
    }
}

/// Normal numbers along `size` directions: those of each direction are the middles of as many equal
/// shares of the distribution as there are draws, in an order of their own.
fn hypercube(size: usize) -> Vec<Vec<f64>> {
    let middle = |rank: usize| -normal::upper_quantile((rank as f64 + 0.5) / DRAWS as f64);
    let middles: Vec<f64> = (0..DRAWS).map(middle).collect();
    let mut rows = vec![vec![0.0; size]; DRAWS];
    for i in 0..size {
        let lots = Normals::new(SEED, (DRAWS + i) as u64).take(DRAWS);
        let mut order: Vec<usize> = (0..DRAWS).collect();
        order.sort_by(|&a, &b| lots[a].total_cmp(&lots[b]));
        for (&draw, middle) in order.iter().zip(&middles) {
            rows[draw][i] = *middle;
        }
    }
    rows
}

/// `predicted · Σ errors / Σ predictions`, at least `least`, over the draws of `again`, which
/// answers both from one normal number for each of `size` directions, σ*² and RSS*.
fn corrected(
    [predicted, least]: [f64; 2],
    noise: &Noise,
    (size, work): (usize, usize),
    again: impl Fn(&[f64], f64, f64) -> Option<(f64, f64)>,
) -> Option<f64> {
    let (mut errors, mut predictions) = (0.0, 0.0);
    for (draw, normals) in hypercube(size).iter().enumerate().asking(work) {
        let (variance, rss) = noise.draw(&mut Normals::new(SEED, draw as u64));
        let (error, prediction) = again(normals, variance, rss)?;
        errors += error;
        predictions += prediction;
    }
    Some((predicted * errors / predictions).max(least)).filter(|corrected| corrected.is_finite())
}

/// How the parameter was found, unless by looking at every node.
fn parameter(criterion: Option<Criterion>, fixed: bool, value: f64) -> Option<Parameter> {
    match criterion {
        _ if fixed => Some(Parameter::Fixed(value)),
        Some(criterion) if criterion.is_nodewise() => None,
        Some(criterion) => Some(Parameter::Criterion(criterion)),
        None => None,
    }
}

/// Of a filter on the eigenvectors, `rule` at the parameter that was selected.
pub(super) fn of_filter(context: &Context, problem: &Spectral, rule: Rule, selected: &SelectedFilter) -> Option<f64> {
    let (lambda, a) = (problem.lambda, &context.spectrum.a);
    let (noise, value) = (Noise::of(context)?, selected.parameter());
    let predicted = problem.sums(rule, value).mse[0];
    if rule == Rule::None {
        // least squares chooses nothing
        return Some(predicted);
    }
    let asked = parameter(selected.selection.criterion, selected.selection.fixed, value)?;
    let truth: Vec<f64> = (0..a.len()).map(|i| rule.at(i, lambda[i], value).factor * a[i]).collect();
    let passed = |(i, l): (usize, &f64)| if *l > 0.0 { rule.at(i, *l, value).factor.powi(2) / l } else { 0.0 };
    let least = noise.variance * lambda.iter().enumerate().map(passed).sum::<f64>();
    corrected([predicted, least], &noise, (a.len(), 2000 * a.len()), |normals, variance, rss| {
        let drawn: Vec<f64> = lambda
            .iter()
            .zip(&truth)
            .zip(normals)
            .map(|((&l, t), z)| if l > 0.0 { t + (noise.variance / l).sqrt() * z } else { 0.0 })
            .collect();
        let sigma = context.spec.noise_sigma;
        let again =
            Spectral::new(lambda, &drawn, Some(variance), rss, problem.count, problem.unpenalised).with_sigma(sigma);
        let value = filters::choose(&again, rule, &drawn, asked)?;
        let error = (0..a.len()).map(|i| (rule.at(i, lambda[i], value).factor * drawn[i] - truth[i]).powi(2)).sum();
        Some((error, again.sums(rule, value).mse[0]))
    })
}

/// Coefficients at most for which λ of a penalty is chosen again so many times.
const MOST_OBLIQUE: usize = 200;

/// Of a penalty along oblique directions at `lambda`, which `choose` finds anew for other heights.
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
    let truth: Vec<f64> = (0..size).map(|i| oblique.factor(i, lambda) * oblique.a[i]).collect();
    let passed = |i: usize| {
        let along = DVector::from_fn(size, |k, _| if k == i { oblique.factor(i, lambda) } else { 0.0 });
        oblique.along(&along).norm_squared()
    };
    let least = noise.variance * (oblique.silent..size).asking(size * size).map(passed).sum::<f64>();
    corrected([predicted, least], &noise, (size, 400 * size * size), |normals, variance, rss| {
        // along these directions least squares has the variance σ²
        let drawn: Vec<f64> = truth
            .iter()
            .enumerate()
            .map(|(i, t)| if i < oblique.silent { 0.0 } else { t + noise.variance.sqrt() * normals[i] })
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
        let rows = hypercube(3);
        let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
        assert!(column(0) != column(1) && column(1) != column(2));
        for i in 0..3 {
            let mut sorted = column(i);
            sorted.sort_by(f64::total_cmp);
            for (k, z) in sorted.iter().enumerate() {
                assert!((normal::upper_tail(*z) - (1.0 - (k as f64 + 0.5) / 60.0)).abs() < 1e-12, "{k}: {z}");
            }
        }
    }
}
