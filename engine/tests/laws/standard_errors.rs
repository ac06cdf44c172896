//! Standard errors, intervals, covariances and bands say the same of one fit, whatever is known of
//! the noise and whatever the estimator.

use crate::oracle::{
    errors::{Errors, further},
    random::Random,
};
use crate::problems::{by, fit, linear};
use flankfit_engine::estimation::{
    FitResult, Nodes,
    result::IntervalKind,
    spec::{
        Criterion, Degree, Estimator, FitSpec, Include, Kinds, Loss, MEstimator, Model, Parameter, Places,
        PolynomialBasis, Predict, Regularization, Terms, Tikhonov,
    },
};

fn cubic(m: usize, seed: u64) -> Nodes {
    let mut random = Random::new(seed);
    let x: Vec<f64> = (0..m).map(|k| k as f64 / (m - 1) as f64).collect();
    let y = x.iter().map(|x| 1.0 - x + 2.0 * x * x * x + 0.1 * random.normal()).collect();
    Nodes::curve(x, y, None).unwrap()
}

fn spec() -> FitSpec {
    let (basis, terms) = (PolynomialBasis::Monomial, Terms::Tensor);
    let include = Include { covariance: true, ..Include::default() };
    FitSpec { include, ..FitSpec::new(Model::Polynomial { degree: Degree::Both(3), basis, terms }) }
}

fn huber() -> Estimator {
    Estimator::M(MEstimator::new(Loss::HUBER))
}

fn check_one_covariance(what: &str, result: &FitResult) {
    let covariance = result.covariance.as_ref().unwrap();
    for (j, c) in result.coefficients.iter().enumerate() {
        let (found, want) = (c.error_given_lambda().unwrap(), covariance.coefficients[j][j].sqrt());
        assert!((found / want - 1.0).abs() < 1e-9, "{what}: {found} {want}");
    }
}

#[test]
fn a_given_sigma_is_in_every_error() {
    let estimated = fit(&cubic(12, 1), &spec());
    for m in [12, 4] {
        for regularization in [Regularization::None, Regularization::Ridge { parameter: Parameter::Fixed(1e-3) }] {
            let result = fit(&cubic(m, 1), &FitSpec { noise_sigma: Some(0.5), regularization, ..spec() });
            check_one_covariance("σ given", &result);
            assert!(!result.warnings.iter().any(|w| w.code() == "no_degrees_of_freedom"), "{:?}", result.warnings);
            for c in &result.coefficients {
                let interval = c.interval.as_ref().unwrap();
                let half = 0.5 * (interval.ends[1] - interval.ends[0]);
                let error = c.least_squares_std_error.unwrap();
                assert!((half / error - 1.959963984540054).abs() < 1e-9, "{half} {error}");
            }
        }
    }
    // as much greater as σ is
    let given = fit(&cubic(12, 1), &FitSpec { noise_sigma: Some(0.5), ..spec() });
    let ratio = 0.5 / estimated.residuals.sigma.unwrap();
    let errors = |result: &FitResult| result.coefficients[0].least_squares_std_error.unwrap();
    assert!((errors(&given) / errors(&estimated) / ratio - 1.0).abs() < 1e-9);
}

#[test]
fn a_given_sigma_makes_no_robust_interval_shorter() {
    for estimator in [huber(), Estimator::Rank, Estimator::LeastAbsolute] {
        let own = FitSpec { estimator, regularization: Regularization::None, ..spec() };
        let plain = fit(&cubic(12, 3), &own);
        let given = fit(&cubic(12, 3), &FitSpec { noise_sigma: Some(100.0), ..own });
        for (a, b) in plain.coefficients.iter().zip(&given.coefficients) {
            assert_eq!(a.interval.as_ref().unwrap().ends, b.interval.as_ref().unwrap().ends);
        }
    }
}

#[test]
fn robust_errors_are_those_of_their_covariance() {
    let tikhonov = Tikhonov { order: 1, weights: None, parameter: Parameter::Fixed(0.1) };
    for regularization in [
        Regularization::None,
        Regularization::Ridge { parameter: Parameter::Fixed(0.01) },
        Regularization::Tikhonov(tikhonov),
    ] {
        for estimator in [huber(), Estimator::Rank, Estimator::LeastTrimmed { coverage: 0.8, seed: 1 }] {
            let asked = FitSpec { estimator, regularization: regularization.clone(), ..spec() };
            check_one_covariance(&format!("{estimator:?}"), &fit(&cubic(30, 5), &asked));
        }
    }
}

/// With a filter that passes everything the estimate is least squares, and its interval Student's.
#[test]
fn a_filter_that_does_nothing_is_not_named() {
    let ridge = |k: f64| Regularization::Ridge { parameter: Parameter::Fixed(k) };
    let kind = |regularization: Regularization| {
        let result = fit(&cubic(30, 5), &FitSpec { regularization, ..spec() });
        result.coefficients[0].interval.as_ref().unwrap().kind
    };
    assert_eq!(kind(ridge(0.1)), IntervalKind::LeastSquares);
    assert_eq!(kind(Regularization::None), IntervalKind::Student);
    assert_eq!(kind(ridge(0.0)), IntervalKind::Student);
}

/// A limit of the norm never makes a simultaneous band wider on the whole.
#[test]
fn a_norm_limit_never_widens_a_band() {
    let x: Vec<f64> = (0..20).map(|k| 30.0 + 0.5 * f64::from(k)).collect();
    let kinds = Kinds { confidence: true, prediction: false, simultaneous: true };
    let predict = Some(Predict { at: Places::Curve(x.clone()), level: None, kinds, slopes: false });
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let y = x.iter().map(|x| 0.01 * x + random.normal()).collect();
        let nodes = Nodes::curve(x.clone(), y, None).unwrap();
        let asked = FitSpec {
            predict: predict.clone(),
            regularization: Regularization::Ridge { parameter: by(Criterion::Gcv) },
            ..spec()
        };
        let width = |spec: &FitSpec| -> f64 {
            let band = fit(&nodes, spec).predictions.unwrap().simultaneous.unwrap().band;
            band.iter().map(|[low, high]| high - low).sum()
        };
        let without = width(&asked);
        for r in [1.0, 100.0] {
            let with = width(&FitSpec { coefficient_norm_limit: Some(r), ..asked.clone() });
            assert!(with <= without * (1.0 + 1e-9), "{seed}: {with} {without}");
        }
    }
}

#[test]
fn bands_of_robust_fits_hold_further_measurements() {
    for estimator in [huber(), Estimator::Rank, Estimator::LeastAbsolute] {
        for errors in [Errors::Normal, Errors::Student3, Errors::Laplace, Errors::Contaminated] {
            let found = further(estimator, errors, 60, 45);
            assert!((0.92..=0.985).contains(&found), "{estimator:?} {errors:?}: {found}");
        }
    }
    // a quantile is not the middle of measurements
    let kinds = Kinds { confidence: true, prediction: true, simultaneous: false };
    let places = Places::Rows(vec![vec![1.0, 0.5]]);
    let predict = Some(Predict { at: places, level: None, kinds, slopes: false });
    let nodes = Nodes::matrix(
        [1.0, 0.0, 1.0, 0.4, 1.0, 0.7, 1.0, 1.0, 1.0, 2.0].to_vec(),
        2,
        vec![0.1, 0.5, 0.6, 1.2, 1.9],
        None,
        None,
    );
    let asked = FitSpec { predict, estimator: Estimator::Quantile { tau: 0.4 }, ..linear() };
    let found = fit(&nodes.unwrap(), &asked).predictions.unwrap();
    assert!(found.prediction.is_none() && found.confidence.is_some());
}
