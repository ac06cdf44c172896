//! Whatever finite numbers are posted: an answer of finite numbers, or a refusal, never a panic, an
//! infinity or a NaN.

use crate::oracle::random::Random;
use crate::problems::config;
use flankfit_engine::estimation::spec::{Action, Filter, FilterAxis, Gaussian, Hampel, Order, Spline};
use flankfit_engine::estimation::spec::{
    Constraint, ConstraintKind, Count, Criterion, Degree, Domain, Estimator, ExpectedSize, FitSpec, Include, Kinds,
    Knots, Model, NodeUncertainty, Parameter, Places, PolynomialBasis, Predict, Regularization, Scaling, Scheme, Terms,
    Variance,
};
use flankfit_engine::estimation::{FitResult, Nodes, fit};
use proptest::prelude::*;

/// A number that somebody might post: tame, tiny, huge, equal to others.
fn number(random: &mut Random, wildness: usize) -> f64 {
    let tame = [0.0, 1.0, -1.0, 0.5, 2.0, 30.0, 0.1];
    let wild = [1e-300, -1e-160, 1e-20, 1e8, 1e16, -1e77, 1e154, 1e300, f64::MAX, f64::MIN_POSITIVE, 5e-324];
    match random.below(8) {
        0 | 1 => tame[random.below(tame.len())],
        2 if wildness > 0 => wild[random.below(if wildness > 1 { wild.len() } else { 6 })],
        3 => f64::from(random.below(5) as u32),
        _ => random.normal() * [1.0, 1e-3, 1e3][random.below(3)],
    }
}

fn numbers(random: &mut Random, count: usize, wildness: usize) -> Vec<f64> {
    (0..count).map(|_| number(random, wildness)).collect()
}

fn axis(random: &mut Random, wildness: usize) -> Vec<f64> {
    let count = 1 + random.below(7);
    let mut axis = numbers(random, count, wildness);
    axis.sort_by(f64::total_cmp);
    axis.dedup_by(|a, b| *a <= *b);
    axis
}

fn nodes(random: &mut Random, wildness: usize) -> Option<Nodes> {
    let m = 1 + random.below(14);
    let weight = |random: &mut Random, count: usize| {
        (random.below(3) == 0).then(|| numbers(random, count, wildness).iter().map(|w| w.abs()).collect::<Vec<f64>>())
    };
    let nodes = match random.below(4) {
        0 => {
            let (x, y, weight) = (numbers(random, m, wildness), numbers(random, m, wildness), weight(random, m));
            Nodes::curve(x, y, weight)
        }
        1 => {
            let (u, v, z) = (numbers(random, m, wildness), numbers(random, m, wildness), numbers(random, m, wildness));
            let weight = weight(random, m);
            Nodes::scattered(u, v, z, weight)
        }
        2 => {
            let (u, v) = (axis(random, wildness), axis(random, wildness));
            let count = u.len() * v.len();
            let mut z = numbers(random, count, wildness);
            (0..random.below(3)).for_each(|_| z[random.below(count)] = f64::NAN);
            let valid = (random.below(3) == 0).then(|| (0..count).map(|_| random.below(5) > 0).collect());
            let weight = weight(random, count);
            Nodes::grid(u, v, z, valid, weight)
        }
        _ => {
            let n = 1 + random.below(5);
            let (x, y, weight) = (numbers(random, m * n, wildness), numbers(random, m, wildness), weight(random, m));
            Nodes::matrix(x, n, y, None, weight)
        }
    };
    nodes.ok()
}

fn model(random: &mut Random, nodes: &Nodes) -> Model {
    if matches!(nodes, Nodes::Matrix(_)) {
        return Model::Linear;
    }
    let surface = !matches!(nodes, Nodes::Curve(_));
    let (p, q) = (random.below(5), random.below(4));
    let degree = if surface && random.below(2) == 0 { Degree::Each(p, q) } else { Degree::Both(p) };
    if random.below(4) == 0 {
        let spans = 1 + random.below(3);
        return Model::BSpline { degree, knots: Knots::Spans(spans), weights: None };
    }
    let basis = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre][random.below(3)];
    let total = matches!(degree, Degree::Both(_)) && random.below(3) == 0;
    Model::Polynomial { degree, basis, terms: if total { Terms::Total } else { Terms::Tensor } }
}

/// Filters that suit the nodes, in one case of four.
fn filters(random: &mut Random, nodes: &Nodes) -> Vec<Filter> {
    let axis = if random.below(2) == 0 { FilterAxis::U } else { FilterAxis::V };
    let axis = match nodes {
        _ if random.below(4) > 0 => return Vec::new(),
        Nodes::Scattered(_) => return Vec::new(),
        Nodes::Curve(_) | Nodes::Matrix(_) => None,
        Nodes::Grid(_) => Some(axis),
    };
    let action = if random.below(2) == 0 { Action::Replace } else { Action::Remove };
    let hampel = Filter::Hampel(Hampel { window: 5, threshold: [0.0, 3.0][random.below(2)], action, axis });
    let cutoff = [1e-3, 1.0, 30.0, 1e9][random.below(4)];
    match (nodes, random.below(4)) {
        (Nodes::Matrix(_), _) | (_, 0) => vec![hampel],
        (_, 1) => vec![hampel, Filter::Spline(Spline { axis, cutoff })],
        (_, 2) => vec![Filter::Gaussian(Gaussian { axis, cutoff, robust: None })],
        _ => vec![Filter::Gaussian(Gaussian { axis, cutoff, robust: Some(Order::Two) }), hampel],
    }
}

/// All places that can be requested.
fn predict(nodes: &Nodes) -> Option<Predict> {
    let at = match nodes {
        Nodes::Curve(curve) => Places::Curve(curve.x().to_vec()),
        Nodes::Grid(grid) => Places::Grid { u: grid.u().to_vec(), v: grid.v().to_vec() },
        Nodes::Scattered(scattered) => Places::Points { u: scattered.u().to_vec(), v: scattered.v().to_vec() },
        Nodes::Matrix(_) => return None,
    };
    Some(Predict {
        at,
        level: None,
        kinds: Kinds { confidence: true, prediction: true, simultaneous: true },
        slopes: true,
    })
}

fn constraints(random: &mut Random) -> Vec<Constraint> {
    use ConstraintKind::{Concave, Convex, Decreasing, Increasing};
    let axes = [None, Some(FilterAxis::U), Some(FilterAxis::V)];
    let kinds = [Increasing, Decreasing, Convex, Concave];
    let one =
        |random: &mut Random| Constraint { kind: kinds[random.below(4)], along: axes[random.below(3)], domain: None };
    (0..=random.below(2)).map(|_| one(random)).collect()
}

fn spec(random: &mut Random, nodes: &Nodes, wildness: usize) -> FitSpec {
    let parameter = |random: &mut Random| match random.below(7) {
        6 => Parameter::Fixed([1e-8, 1.0, 1e-200, 1e200, 0.03][random.below(5)]),
        5 => Parameter::Criterion(Criterion::MinMse),
        k => Parameter::Criterion(Criterion::ALL[k]),
    };
    let some = |random: &mut Random| random.below(3) == 0;
    FitSpec {
        prior: None,
        model: model(random, nodes),
        scaling: [Scaling::UnitLength, Scaling::None, Scaling::Standardized][random.below(3)],
        regularization: match random.below(3) {
            0 => Regularization::None,
            1 => Regularization::Ridge { parameter: parameter(random) },
            _ => Regularization::Spectral {
                scheme: [Scheme::FirstOrder, Scheme::Exact][random.below(2)],
                count: if some(random) { Count::Given(random.below(4)) } else { Count::Auto },
                condition_limit: [900.0, 1.0, 1e12][random.below(3)],
                lambda_star: parameter(random),
            },
        },
        estimator: Estimator::LeastSquares,
        domain: some(random).then_some(Domain { u: Some([-1e6, 1e6]), v: None }),
        coefficient_norm_limit: some(random).then(|| number(random, wildness).abs() + f64::MIN_POSITIVE),
        expected_size: match random.below(3) {
            0 => ExpectedSize::Estimated,
            1 => ExpectedSize::OfHeights,
            _ => ExpectedSize::Within((0..6).map(|_| number(random, wildness).abs()).collect()),
        },
        noise_sigma: some(random).then(|| number(random, wildness).abs() + f64::MIN_POSITIVE),
        sums: None,
        level: [0.95, 0.51, 0.999_999][random.below(3)],
        predict: predict(nodes),
        select: None,
        folds: None,
        node_uncertainty: some(random).then_some(NodeUncertainty { position: 1e-3, height: 1e-4, kind: None }),
        errors: None,
        variance: Variance::Constant,
        filters: filters(random, nodes),
        exclude: Vec::new(),
        constraints: if random.below(6) == 0 { constraints(random) } else { Vec::new() },
        include: Include {
            residuals: true,
            fitted: true,
            collinearity: true,
            lambda_curve: true,
            matrix_b: true,
            ridge_trace: false,
            robust_weights: true,
            peaks: true,
            covariance: true,
            influence: true,
            shape: true,
            representative: true,
            predicted_mse: true,
            enclosure: true,
        },
    }
}

/// Every number of a result passes through its debug form (warnings are sentences and may name
/// infinity).
fn finite(result: &FitResult) -> Result<(), String> {
    let text = format!("{:#?}", FitResult { warnings: Vec::new(), ..result.clone() });
    let bad = |line: &&str| {
        // a σ that was given has infinitely many degrees of freedom
        let line = line.replace("freedom: inf", "");
        let words = line.split(|c: char| !c.is_alphanumeric());
        words.into_iter().any(|word| word == "inf" || word == "NaN")
    };
    match text.lines().position(|line| bad(&line)) {
        Some(at) => Err(text.lines().skip(at.saturating_sub(6)).take(8).collect::<Vec<_>>().join("\n")),
        None => Ok(()),
    }
}

fn trial(seed: u64, wildness: usize) -> Result<bool, String> {
    let mut random = Random::new(seed);
    let Some(nodes) = nodes(&mut random, wildness) else { return Ok(false) };
    let spec = spec(&mut random, &nodes, wildness);
    match fit(&nodes, &spec) {
        Ok(result) => finite(&result).map(|()| true).map_err(|place| format!("{place}\n{nodes:?}\n{spec:?}")),
        Err(_) => Ok(false),
    }
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn results_are_finite(seed: u64, wildness in 0usize..3) {
        if let Err(fault) = trial(seed, wildness) {
            prop_assert!(false, "{fault}");
        }
    }
}

#[test]
fn most_tame_questions_are_answered() {
    let answered = (0..600).filter(|seed| trial(*seed, 0) == Ok(true)).count();
    assert!(answered > 150, "only {answered} of 600 were answered");
}
