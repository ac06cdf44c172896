//! Results of every robust estimator: standard errors, exact fits, and its regularised forms.

use crate::{
    oracle::{
        errors::{Errors, coverage, estimators as table},
        random::Random,
    },
    robust::{Problem, estimators, near, values},
};
use flankfit_engine::estimation::{
    FitSpec,
    result::Warning,
    spec::{
        Attraction, Criterion, Distribution, Estimator, JamesStein, Model, Parameter, Regularization, ShrinkageFactor,
        Tikhonov,
    },
};

#[test]
fn standard_errors_agree_with_the_scatter_of_estimates() {
    let repetitions = 300;
    for estimator in estimators() {
        let (mut squares, mut claimed) = (0.0, 0.0);
        for seed in 0..repetitions {
            let mut random = Random::new(5000 + seed);
            let x: Vec<Vec<f64>> = (0..60).map(|k| vec![1.0, (k as f64 - 29.5) / 10.0]).collect();
            let y = x.iter().map(|row| 2.0 * row[1] + random.normal()).collect();
            let result = Problem { x, y, weight: None }.fit(estimator);
            squares += (result.coefficients[1].value - 2.0).powi(2);
            claimed += result.coefficients[1].std_error.unwrap().powi(2);
        }
        let ratio = (claimed / squares).sqrt();
        println!("{estimator:?}: {ratio}");
        assert!((0.75..1.4).contains(&ratio), "{estimator:?}: claimed/seen {ratio}");
    }
}

#[test]
fn an_exact_fit_of_most_nodes_is_answered() {
    for estimator in estimators() {
        let x: Vec<Vec<f64>> = (0..20).map(|k| vec![1.0, f64::from(k)]).collect();
        let y =
            (0..20).map(|k| 3.0 - 2.0 * f64::from(k) + if k % 6 == 1 { 50.0 + f64::from(k) } else { 0.0 }).collect();
        let problem = Problem { x, y, weight: None };
        let result = problem.fit(estimator);
        let exact = !matches!(
            estimator,
            Estimator::Lp { .. }
                | Estimator::Quantile { .. }
                | Estimator::NormalScores
                | Estimator::L(_)
                | Estimator::Likelihood(_)
        );
        if exact {
            for (c, wanted) in result.coefficients.iter().zip([3.0, -2.0]) {
                assert!((c.value - wanted).abs() < 1e-9, "{estimator:?}: {}", c.value);
            }
        }
        // nothing but one surface
        let problem = Problem { y: problem.x.iter().map(|x| 1.0 + x[1]).collect(), ..problem };
        let result = problem.fit(estimator);
        for c in &result.coefficients {
            assert!((c.value - 1.0).abs() < 1e-9, "{estimator:?}: {}", c.value);
        }
        // as many coefficients as nodes
        let few = Problem { x: problem.x[..2].to_vec(), y: vec![1.0, 3.0], weight: None };
        if !matches!(estimator, Estimator::LeastTrimmed { .. }) {
            let result = few.fit(estimator);
            assert!((result.coefficients[1].value - 2.0).abs() < 1e-9, "{estimator:?}: {result:?}");
            assert!(result.coefficients.iter().all(|c| c.std_error.is_none()));
        }
    }
}

/// One estimate under each of its names: a standard error of 0 would give an interval of width 0.
#[test]
fn an_exact_fit_is_reported_by_every_least_deviations_estimator() {
    let x: Vec<Vec<f64>> = (0..20).map(|k| vec![1.0, f64::from(k)]).collect();
    let y = (0..20).map(|k| 3.0 + f64::from(k) + if k % 6 == 1 { 50.0 + f64::from(k) } else { 0.0 }).collect();
    let problem = Problem { x, y, weight: None };
    let generalized = |exponent| Estimator::Likelihood(Distribution::GeneralizedNormal { exponent });
    for estimator in [
        Estimator::LeastAbsolute,
        Estimator::Lp { p: 1.0 },
        Estimator::Quantile { tau: 0.5 },
        Estimator::Likelihood(Distribution::Laplace),
        generalized(Some(1.0)),
        generalized(None),
    ] {
        let result = problem.fit(estimator);
        let exact = result.warnings.iter().find(|warning| warning.code() == "exact_fit");
        assert_eq!(
            exact,
            Some(&Warning::ExactFit { on_surface: 16, nodes: 20 }),
            "{estimator:?}: {:?}",
            result.warnings
        );
        assert!(result.robust.as_ref().unwrap().likelihood.is_none(), "{estimator:?}");
        for (c, truth) in result.coefficients.iter().zip([3.0, 1.0]) {
            assert!((c.value - truth).abs() < 1e-12, "{estimator:?}: {}", c.value);
            assert!(c.std_error.is_none() && c.interval.is_none(), "{estimator:?}: {c:?}");
        }
    }
}

#[test]
fn every_estimator_goes_with_every_regularisation() {
    let problem = Problem::new(11, 40, 4, false);
    let parameter = Parameter::Criterion(Criterion::MinMse);
    let regularizations = [
        FitSpec::new(Model::Linear).regularization,
        Regularization::Ridge { parameter },
        Regularization::TruncatedSvd { rank: 3 },
        Regularization::Tikhonov(Tikhonov { order: 1, weights: None, parameter: Parameter::Fixed(1e-3) }),
        Regularization::JamesStein(JamesStein {
            factor: ShrinkageFactor::EfronMorris,
            positive_part: true,
            target: None,
        }),
        Regularization::Attraction(Attraction { target: vec![1.0; 4], parameter: Parameter::Fixed(0.1) }),
    ];
    for estimator in estimators() {
        let plain = problem.fit(estimator);
        for regularization in &regularizations {
            let result = problem.fit_with(estimator, regularization.clone());
            let robust = result.robust.as_ref().unwrap();
            // the estimate before regularisation does not know of it, nor does least squares
            assert_eq!(robust.coefficients, plain.robust.as_ref().unwrap().coefficients);
            assert_eq!(robust.weights, plain.robust.as_ref().unwrap().weights);
            let r = problem.residuals(&values(&result));
            near("rss", result.residuals.rss, r.iter().map(|r| r * r).sum(), 1e-10);
            near("max_abs", result.residuals.max_abs.unwrap(), r.iter().map(|r| r.abs()).fold(0.0, f64::max), 1e-10);
            assert!(result.residuals.rss >= result.residuals.least_squares_rss * (1.0 - 1e-12));
            for (c, unfiltered) in result.coefficients.iter().zip(&plain.coefficients) {
                assert_eq!(c.least_squares, unfiltered.least_squares);
                assert_eq!(c.least_squares_std_error, unfiltered.least_squares_std_error);
                let (error, whole) = (c.error_given_lambda().unwrap(), unfiltered.error_given_lambda().unwrap());
                assert!(error > 0.0 && error < 2.0 * whole, "{estimator:?} {regularization:?}: {error} {whole}");
            }
            assert!(result.residuals.values.is_none());
        }
    }
}

/// The long table is made by examples/robust_coverage.
#[test]
fn intervals_hold_with_errors_as_each_estimator_expects_them() {
    let heavy = [Errors::Contaminated, Errors::Laplace, Errors::Student3];
    for (at, (name, estimator)) in table().into_iter().enumerate().filter(|(_, (_, e))| *e != Estimator::LeastSquares) {
        let errors = heavy[at % 3];
        let found = coverage(estimator, errors, 120, 45);
        println!("{name}, {errors:?}: {} {} {}", found.mean, found.worst, found.width);
        assert!((0.9..=0.99).contains(&found.mean), "{name}, {errors:?}: {}", found.mean);
        // winsorized means give peaks most of their weight
        let widest = if name.starts_with("winsorized") { 1.15 } else { 1.05 };
        assert!(found.width < widest, "{name}, {errors:?}: wider than least squares with peaks: {}", found.width);
    }
}

/// With an estimated exponent the interval must not be too narrow: it covered 0.87 when the
/// likeliest exponent was taken as given.
#[test]
fn an_estimated_exponent_holds_with_normal_errors_too() {
    let estimator = Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None });
    let found = coverage(estimator, Errors::Normal, 120, 45);
    assert!((0.915..=0.97).contains(&found.mean) && found.worst >= 0.9, "{} {}", found.mean, found.worst);
}
