//! Prior knowledge: laws that hold for every chain, and its quality on average.

use std::sync::Arc;

use crate::oracle::random::Random;
use crate::problems::{linear, matrix};
use flankfit_engine::estimation::{
    FitError, FitResult, FitSpec, Nodes, fit,
    result::{IntervalKind, NormLimitSource, Warning},
    spec::{
        Chain, Criterion, Degree, Earlier, Estimator, Include, JamesStein, Kinds, Model, Moves, Parameter, Places,
        PolynomialBasis, Predict, Prior, PriorSpread, Regularization, Scaling, ShrinkageFactor, Terms, Which,
    },
};

/// Close against the largest of them.
#[track_caller]
fn assert_close(a: &[f64], b: &[f64], slack: f64) {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    assert!(a.iter().zip(b).all(|(p, q)| (p - q).abs() <= slack * size), "{a:?} {b:?}");
}

fn chain(earlier: &[Nodes], moves: Moves) -> Prior {
    let earlier = earlier.iter().enumerate().map(|(k, nodes)| Earlier {
        number: k as u32 + 1,
        fit_id: format!("fit {k}"),
        nodes: Arc::new(nodes.clone()),
        corrections: vec![],
    });
    Prior::Iterations(Chain { which: Which::Previous, moves, correction: true, earlier: Some(earlier.collect()) })
}

fn plain(model: Model) -> FitSpec {
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn with(prior: Prior) -> FitSpec {
    FitSpec { prior: Some(prior), regularization: Regularization::None, ..linear() }
}

/// Rows of a design with `n` columns that lean on each other.
fn rows(random: &mut Random, m: usize, n: usize) -> Vec<Vec<f64>> {
    (0..m)
        .map(|_| {
            let t = random.between(-1.0, 1.0);
            (0..n).map(|j| t.powi(j as i32) + 0.2 * random.normal()).collect()
        })
        .collect()
}

/// Iterations over nodes of their own, the coefficients moving by `step` standard deviations.
fn measured(seed: u64, count: usize, n: usize, step: f64) -> Vec<(Vec<Vec<f64>>, Vec<f64>)> {
    let mut random = Random::new(seed);
    let mut truth = random.normals(n);
    (0..count)
        .map(|_| {
            let m = n + 3 + random.below(6);
            let x = rows(&mut random, m, n);
            let y = x.iter().map(|row| dot(row, &truth) + 0.1 * random.normal()).collect();
            truth.iter_mut().for_each(|a| *a += step * random.normal());
            (x, y)
        })
        .collect()
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn nodes(all: &[(Vec<Vec<f64>>, Vec<f64>)]) -> Vec<Nodes> {
    all.iter().map(|(x, y)| matrix(x, y, None)).collect()
}

fn values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.value).collect()
}

fn errors(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.std_error.expect("there is noise")).collect()
}

fn answered(all: &[Nodes], moves: Moves) -> FitResult {
    let (now, earlier) = all.split_last().expect("iterations");
    fit(now, &with(chain(earlier, moves))).expect("a fit")
}

#[test]
fn without_moves_all_iterations_are_one_fit() {
    for seed in 0..20 {
        let measured = measured(seed, 4, 3, 0.0);
        let together = matrix(
            &measured.iter().flat_map(|(x, _)| x.clone()).collect::<Vec<_>>(),
            &measured.iter().flat_map(|(_, y)| y.clone()).collect::<Vec<_>>(),
            None,
        );
        let pooled = fit(&together, &with_plain()).unwrap();
        let found = answered(&nodes(&measured), Moves::StdError(vec![1e-12; 3]));
        if found.prior.as_ref().unwrap().conflict.unwrap().dropped {
            continue;
        }
        assert_close(&values(&found), &values(&pooled), 1e-8);
        // the same covariance but for σ̂, of which each iteration has an estimate of its own
        let sigma = found.prior.as_ref().unwrap().sigma.unwrap() / pooled.residuals.sigma.unwrap();
        let scaled: Vec<f64> = errors(&pooled).iter().map(|e| e * sigma).collect();
        assert_close(&errors(&found), &scaled, 1e-8);
    }
}

fn with_plain() -> FitSpec {
    FitSpec { regularization: Regularization::None, ..linear() }
}

#[test]
fn a_prior_that_knows_nothing_is_least_squares() {
    let all = nodes(&measured(3, 3, 3, 0.1));
    let alone = fit(&all[2], &with_plain()).unwrap();
    let vague = Prior::Given { mean: vec![7.0, -2.0, 0.0], spread: PriorSpread::StdError(vec![1e9; 3]) };
    let given = fit(&all[2], &with(vague)).unwrap();
    assert_close(&values(&given), &values(&alone), 1e-12);
    assert_close(&errors(&given), &errors(&alone), 1e-12);
    let chained = answered(&all, Moves::StdError(vec![1e9; 3]));
    assert_close(&values(&chained), &values(&alone), 1e-12);
    for (prior, alone) in given.coefficients.iter().zip(&alone.coefficients) {
        assert_close(&prior.interval.unwrap().ends, &alone.interval.unwrap().ends, 1e-12);
    }
    assert!(given.regularization.filter_factors.iter().all(|f| *f > 1.0 - 1e-12));
    assert!(given.prior.unwrap().share.iter().chain(&chained.prior.unwrap().share).all(|share| *share < 1e-12));
}

/// Other columns that span the same, and columns in other units: the fitted heights stay.
#[test]
fn the_basis_and_its_scaling_do_not_matter() {
    let change = [[2.0, -1.0, 0.3], [0.0, 1e-3, 4.0], [0.0, 0.0, 1e4]];
    for seed in 0..10 {
        let measured = measured(seed, 4, 3, 0.05);
        let turned: Vec<_> = measured
            .iter()
            .map(|(x, y)| {
                let row = |row: &Vec<f64>| (0..3).map(|j| (0..3).map(|i| row[i] * change[i][j]).sum()).collect();
                (x.iter().map(row).collect::<Vec<Vec<f64>>>(), y.clone())
            })
            .collect();
        let (found, other) =
            (answered(&nodes(&measured), Moves::Estimated), answered(&nodes(&turned), Moves::Estimated));
        let back: Vec<f64> = (0..3).map(|i| dot(&change[i], &values(&other))).collect();
        assert_close(&back, &values(&found), 1e-9);
        let (p, q) = (found.prior.unwrap(), other.prior.unwrap());
        assert_close(&[p.move_ratio.unwrap()], &[q.move_ratio.unwrap()], 1e-9);
        assert_close(&[p.conflict.unwrap().p], &[q.conflict.unwrap().p], 1e-8);
    }
}

#[test]
fn the_order_of_nodes_does_not_matter() {
    let measured = measured(5, 3, 3, 0.1);
    let reversed: Vec<_> = measured
        .iter()
        .map(|(x, y)| (x.iter().rev().cloned().collect::<Vec<_>>(), y.iter().rev().copied().collect::<Vec<_>>()))
        .collect();
    let (a, b) = (answered(&nodes(&measured), Moves::Estimated), answered(&nodes(&reversed), Moves::Estimated));
    assert_close(&values(&a), &values(&b), 1e-11);
    assert_close(&errors(&a), &errors(&b), 1e-11);
}

/// A covariance says what standard deviations say; a posterior posted as the next prior is the
/// chain of one move after the other, where σ is given.
#[test]
fn a_posterior_is_the_next_prior() {
    let measured = measured(8, 2, 3, 0.02);
    let all = nodes(&measured);
    let specified = |prior: Option<Prior>| FitSpec {
        noise_sigma: Some(0.1),
        prior,
        include: Include { covariance: true, ..Include::default() },
        ..with_plain()
    };
    let first = fit(&all[0], &specified(None)).unwrap();
    let covariance = first.covariance.clone().unwrap().coefficients;
    let posted = Prior::Given { mean: values(&first), spread: PriorSpread::Covariance(covariance) };
    let posted = fit(&all[1], &specified(Some(posted))).unwrap();
    let chained = fit(&all[1], &specified(Some(chain(&all[..1], Moves::StdError(vec![1e-9; 3]))))).unwrap();
    assert_close(&values(&posted), &values(&chained), 1e-8);
    assert_close(&errors(&posted), &errors(&chained), 1e-8);
    assert_eq!(posted.bias.coefficient_norm_limit_source, NormLimitSource::Prior);
    assert_close(&[posted.bias.coefficient_norm_limit], &[chained.bias.coefficient_norm_limit], 1e-8);
    let kinds: Vec<_> = posted.coefficients.iter().map(|c| c.interval.unwrap().kind).collect();
    assert_eq!(kinds, [IntervalKind::Posterior; 3]);
}

/// No coefficients that lie from the prior's mean as far as it says on average are expected further
/// off than the bound, and some are as far off. It is at most ½√n standard errors of least squares.
#[test]
fn the_bias_of_a_posterior_is_bounded_sharply() {
    let mut random = Random::new(4);
    let (x, deviations, center) = (rows(&mut random, 12, 3), vec![0.05, 0.2, 0.1], vec![1.0, 2.0, -1.0]);
    let mean = |truth: &[f64]| {
        let y: Vec<f64> = x.iter().map(|row| dot(row, truth)).collect();
        let prior = Prior::Given { mean: center.clone(), spread: PriorSpread::StdError(deviations.clone()) };
        let spec = FitSpec { noise_sigma: Some(10.0), scaling: Scaling::None, ..with(prior) };
        fit(&matrix(&x, &y, None), &spec).unwrap()
    };
    let r = mean(&center).bias.coefficient_norm_limit;
    assert_close(&[r], &[deviations.iter().map(|d| d * d).sum::<f64>().sqrt()], 1e-12);
    let found = mean(&center);
    let bounds: Vec<f64> = found.coefficients.iter().map(|c| c.bias_bound).collect();
    let most = 0.5 * 3f64.sqrt();
    assert!(found.coefficients.iter().all(|c| c.bias_bound <= most * c.least_squares_std_error.unwrap()));
    let (mut worst, mut farthest) = (vec![0.0f64; 3], 0.0f64);
    for _ in 0..400 {
        let step = random.normals(3);
        let length = (dot(&step, &step) / 3.0).sqrt();
        let truth: Vec<f64> = (0..3).map(|j| center[j] + deviations[j] * step[j] / length).collect();
        let found = mean(&truth);
        for (j, coefficient) in found.coefficients.iter().enumerate() {
            worst[j] = worst[j].max((coefficient.value - truth[j]).abs() / bounds[j]);
        }
        let off: Vec<f64> = found.coefficients.iter().zip(&truth).map(|(c, a)| c.value - a).collect();
        farthest = farthest.max(dot(&off, &off).sqrt());
    }
    assert!(worst.iter().all(|share| (0.98..1.0 + 1e-9).contains(share)), "{worst:?}");
    let share = farthest / found.bias.sharp_bound;
    assert!((0.98..1.0 + 1e-9).contains(&share), "{share}");
}

/// Share of the heights in the result: the trace of `XᵀX Cov/σ²`, and the determinants of the
/// information of the nodes and of both together.
#[test]
fn filter_factors_are_the_shares_of_the_nodes() {
    let mut random = Random::new(14);
    let x = rows(&mut random, 12, 3);
    let y: Vec<f64> = x.iter().map(|row| dot(row, &[0.5; 3]) + 0.7 * random.normal()).collect();
    let prior = Prior::Given { mean: vec![0.5; 3], spread: PriorSpread::StdError(vec![0.05, 0.4, 30.0]) };
    let include = Include { covariance: true, ..Include::default() };
    let spec = FitSpec { noise_sigma: Some(0.7), scaling: Scaling::None, include, ..with(prior) };
    let found = fit(&matrix(&x, &y, None), &spec).unwrap();
    let factors = &found.regularization.filter_factors;
    assert!(factors.len() == 3 && factors.is_sorted() && factors.iter().all(|f| (0.0..=1.0).contains(f)));
    assert!(factors[0] < 0.5 && factors[2] > 0.9, "{factors:?}");
    let covariance = found.covariance.unwrap().coefficients;
    let entry = |j: usize, k: usize| if k <= j { covariance[j][k] } else { covariance[k][j] };
    let products = |j: usize, k: usize| x.iter().map(|row| row[j] * row[k]).sum::<f64>();
    let trace: f64 = (0..9).map(|i| products(i / 3, i % 3) * entry(i / 3, i % 3)).sum::<f64>() / 0.49;
    assert_close(&[factors.iter().sum()], &[trace], 1e-10);
    let product = |of: &[f64]| of.iter().product::<f64>();
    let both = product(&found.spectrum.regularized.eigenvalues);
    assert_close(&[product(factors)], &[product(&found.spectrum.eigenvalues) / both], 1e-10);
}

/// Mapped functions live on the domain of the nodes of now; earlier nodes may lie outside of it,
/// and powers of x give the same heights.
#[test]
fn functions_are_those_of_the_nodes_of_now() {
    let over = |low: f64, high: f64, shift: f64| {
        let x: Vec<f64> = (0..9).map(|k| low + (high - low) * f64::from(k) / 8.0).collect();
        let y = x.iter().enumerate().map(|(k, x)| x * x * 0.1 + shift + 0.01 * ((7 * k) % 5) as f64).collect();
        Nodes::curve(x, y, None).unwrap()
    };
    let all = [over(0.0, 10.0, 0.0), over(-1.0, 8.0, 0.02), over(2.0, 9.0, 0.01)];
    let model = |basis| Model::Polynomial { degree: Degree::Both(2), basis, terms: Terms::Tensor };
    let at = Places::Curve(vec![2.0, 4.5, 7.0, 9.0]);
    let spec = |basis| FitSpec {
        prior: Some(chain(&all[..2], Moves::Estimated)),
        predict: Some(Predict { at: at.clone(), level: None, kinds: Kinds::default(), slopes: false }),
        include: Include { residuals: true, ..Include::default() },
        ..plain(model(basis))
    };
    let [powers, mapped] =
        [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev].map(|basis| fit(&all[2], &spec(basis)).unwrap());
    assert_close(powers.residuals.values.as_ref().unwrap(), mapped.residuals.values.as_ref().unwrap(), 1e-9);
    let [own, other] = [&powers, &mapped].map(|found| found.predictions.as_ref().unwrap());
    assert_close(&own.bias_bound, &other.bias_bound, 1e-7);
    assert_close(&powers.regularization.filter_factors, &mapped.regularization.filter_factors, 1e-7);
    assert!(own.bias_bound.iter().all(|bound| *bound > 0.0));
    assert!(powers.prior.unwrap().share.iter().all(|share| *share > 0.3));
}

#[test]
fn a_flank_that_jumps_lets_its_prior_go() {
    let mut measured = measured(12, 5, 3, 0.01);
    measured[4].1.iter_mut().for_each(|y| *y += 3.0);
    let all = nodes(&measured);
    let found = answered(&all, Moves::Estimated);
    let conflict = found.prior.as_ref().unwrap().conflict.unwrap();
    assert!(conflict.dropped && conflict.p < 1e-4 && conflict.statistic > 10.0, "{conflict:?}");
    assert!(found.warnings.contains(&Warning::PriorConflict { statistic: conflict.statistic, p: conflict.p }));
    let alone = fit(&all[4], &with_plain()).unwrap();
    assert_eq!((values(&found), errors(&found)), (values(&alone), errors(&alone)));
    for (ours, theirs) in found.coefficients.iter().zip(&alone.coefficients) {
        let [ours, theirs] = [ours, theirs].map(|one| one.interval.unwrap());
        let width = |ends: [f64; 2]| ends[1] - ends[0];
        assert!((0.95..1.05).contains(&(width(ours.ends) / width(theirs.ends))), "{ours:?} {theirs:?}");
    }
    // two iterations have no jump before the one that is judged
    assert_eq!(answered(&all[3..], Moves::Estimated).prior.unwrap().conflict, None);
}

#[test]
fn invalid_priors_are_refused_with_their_path() {
    let all = nodes(&measured(1, 3, 3, 0.1));
    let given = |n: usize| Prior::Given { mean: vec![0.0; n], spread: PriorSpread::StdError(vec![1.0; n]) };
    let covariance = |rows: Vec<Vec<f64>>| Prior::Given { mean: vec![0.0; 3], spread: PriorSpread::Covariance(rows) };
    let unknown = Chain { which: Which::Previous, moves: Moves::Estimated, correction: true, earlier: None };
    let other = Nodes::curve(vec![0.0, 1.0, 2.0, 3.0], vec![0.0; 4], None).unwrap();
    let few = Nodes::matrix(vec![1.0; 6], 3, vec![0.0; 2], None, None).unwrap();
    let mut negative = given(3);
    if let Prior::Given { spread: PriorSpread::StdError(deviations), .. } = &mut negative {
        deviations[1] = 0.0;
    }
    let robust = Estimator::Rank;
    let ridge = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Gcv) };
    let stein = JamesStein { factor: ShrinkageFactor::JamesStein, positive_part: true, target: None };
    let cases: Vec<(FitSpec, &str)> = vec![
        (with(given(2)), "prior.mean: 2 entries; the model has 3 coefficients"),
        (with(negative), "prior.std_error[1]: 0 is not a standard deviation"),
        (
            with(covariance(vec![vec![1.0], vec![0.0, 1.0], vec![0.0, 2.0, 1.0]])),
            "prior.covariance: the covariance matrix is not positive definite",
        ),
        (
            with(covariance(vec![vec![1.0], vec![0.0], vec![0.0, 0.0, 1.0]])),
            "prior.covariance[1]: row 1 of a lower triangle has 2 numbers; this one has 1",
        ),
        (with(Prior::Iterations(unknown)), "prior.iterations: only a fit in a job has earlier iterations"),
        (with(chain(&all[..1], Moves::StdError(vec![1.0]))), "prior.move: "),
        (with(chain(&[other], Moves::Estimated)), "prior.iterations: "),
        (with(chain(&[few], Moves::Estimated)), "prior.iterations: "),
        (FitSpec { regularization: ridge, ..with(given(3)) }, "regularization: a `prior` excludes"),
        (
            FitSpec { regularization: Regularization::JamesStein(stein), ..with(given(3)) },
            "regularization: a `prior` excludes regularisation",
        ),
        (FitSpec { estimator: robust, ..with(given(3)) }, "estimator: a `prior` needs the estimator `least_squares`"),
        (
            FitSpec { coefficient_norm_limit: Some(1.0), ..with(given(3)) },
            "coefficient_norm_limit: the `prior` already limits the coefficients",
        ),
    ];
    for (spec, message) in cases {
        let Err(FitError::Invalid(faults)) = fit(&all[2], &spec) else { panic!("{message} is taken") };
        assert!(faults.to_string().starts_with(message), "{faults}");
    }
}

#[test]
fn a_prior_is_of_the_constant_too() {
    let nodes = Nodes::curve((0..6).map(f64::from).collect(), vec![1.0, 2.0, 2.0, 4.0, 3.0, 6.0], None).unwrap();
    let model = Model::Polynomial { degree: Degree::Both(1), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let prior = Some(Prior::Given { mean: vec![0.5, 1.0], spread: PriorSpread::StdError(vec![1.0; 2]) });
    let spec = FitSpec { scaling: Scaling::Standardized, prior, ..plain(model) };
    let Err(FitError::Invalid(faults)) = fit(&nodes, &spec) else { panic!("it is taken") };
    assert!(faults.to_string().starts_with("scaling: a `prior` covers all coefficients"), "{faults}");
    let found = fit(&nodes, &FitSpec { scaling: Scaling::None, ..spec }).unwrap();
    // the spectrum of nodes and prior together: XᵀX + σ² 1
    let sigma = found.prior.unwrap().sigma.unwrap();
    let trace = |of: &[f64]| of.iter().sum::<f64>();
    let (before, after) = (trace(&found.spectrum.eigenvalues), trace(&found.spectrum.regularized.eigenvalues));
    assert_close(&[after], &[before + 2.0 * sigma * sigma], 1e-12);
}
