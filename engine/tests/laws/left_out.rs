//! Requested results that do not exist are left out, and a warning says so.

use crate::{oracle::random::Random, problems::fit};
use flankfit_engine::estimation::{
    FitError, FitResult, FitSpec, Nodes,
    result::Warning,
    spec::{
        Count, Criterion, DEFAULT_CONDITION_LIMIT, Degree, Distribution, Estimator, Include, Kinds, Model, Parameter,
        Places, PolynomialBasis, Predict, Prior, PriorSpread, Regularization, Scheme, Terms, Variance,
    },
};

fn spec(degree: usize) -> FitSpec {
    let model =
        Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn line(noise: f64) -> Nodes {
    let mut random = Random::new(5);
    let x: Vec<f64> = (0..40).map(|k| f64::from(k) / 8.0).collect();
    let y = x.iter().map(|x| 2.0 - 0.5 * x + noise * random.normal()).collect();
    Nodes::curve(x, y, None).unwrap()
}

fn warned(found: &FitResult, code: &str) -> bool {
    found.warnings.iter().any(|warning| warning.code() == code)
}

#[test]
fn influences_of_too_many_nodes() {
    let x: Vec<f64> = (0..200_001).map(|k| f64::from(k) * 1e-4).collect();
    let y = x.iter().map(|x| (300.0 * x).sin()).collect();
    let include = Include { influence: true, ..Include::default() };
    let found = fit(&Nodes::curve(x, y, None).unwrap(), &FitSpec { include, ..spec(1) });
    assert!(found.influence.is_none());
    assert!(found.warnings.contains(&Warning::InfluenceOfMany { nodes: 200_001, most: 200_000 }));
}

#[test]
fn a_norm_limit_that_no_interval_uses() {
    let limited = |spec: FitSpec| fit(&line(0.1), &FitSpec { coefficient_norm_limit: Some(50.0), ..spec });
    assert!(warned(&limited(FitSpec { estimator: Estimator::LeastAbsolute, ..spec(1) }), "norm_limit_unused"));
    assert!(warned(&limited(FitSpec { variance: Variance::Hc3, ..spec(1) }), "norm_limit_unused"));
    let plain = limited(spec(1));
    assert!(!warned(&plain, "norm_limit_unused") && plain.coefficients[0].interval.unwrap().gain.is_some());
    let robust = fit(&line(0.1), &FitSpec { estimator: Estimator::LeastAbsolute, ..spec(1) });
    assert!(!warned(&robust, "norm_limit_unused"));
}

#[test]
fn a_predicted_error_that_nothing_corrects() {
    let include = Include { predicted_mse: true, ..Include::default() };
    let of = |regularization: Regularization| {
        let found = fit(&line(0.1), &FitSpec { include, regularization, ..spec(3) });
        let there = found.regularization.predicted_mse_corrected.is_some();
        assert_ne!(there, warned(&found, "no_corrected_error"), "{:?}", found.regularization.kind);
        there
    };
    let ridge = |criterion| Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
    assert!(of(ridge(Criterion::MinMse)) && !of(ridge(Criterion::Press)));
    assert!(!of(Regularization::TruncatedSvd { rank: 2 }));
    let scheme = Regularization::Spectral {
        scheme: Scheme::FirstOrder,
        count: Count::Auto,
        condition_limit: DEFAULT_CONDITION_LIMIT,
        lambda_star: Parameter::Criterion(Criterion::MinMse),
    };
    of(scheme);
}

/// One place far away, whose powers exceed doubles, takes nothing from the others.
#[test]
fn places_whose_powers_overflow_are_omitted() {
    let all = Kinds { confidence: true, prediction: true, simultaneous: true };
    let asked = |at: Vec<f64>, slopes: bool| FitSpec {
        predict: Some(Predict { at: Places::Curve(at), level: None, kinds: all, slopes }),
        ..spec(3)
    };
    for far in [1e120, 1e102, -1e154] {
        for slopes in [false, true] {
            let found = fit(&line(0.1), &asked(vec![1.0, far, 2.0], slopes));
            let there = fit(&line(0.1), &asked(vec![1.0, 2.0], slopes)).predictions.unwrap();
            let left = found.predictions.unwrap();
            assert_eq!(left.place_indices, Some(vec![0, 2]), "{far}");
            assert_eq!(left.value, there.value);
            assert_eq!(left.confidence, there.confidence);
            assert_eq!(left.simultaneous, there.simultaneous);
            assert_eq!((left.slope_u, left.slope_v), (there.slope_u, there.slope_v));
            let named = Warning::PlacesExceedDouble { places: vec![1], count: 1 };
            assert!(found.warnings.contains(&named), "{:?}", found.warnings);
        }
    }
    let found = fit(&line(0.1), &asked(vec![1e120], false));
    assert!(found.predictions.is_none() && warned(&found, "exceeds_double"));
    assert!(fit(&line(0.1), &asked(vec![1.0], false)).predictions.unwrap().place_indices.is_none());
}

/// Prior of the true coefficients of [`line`], with this uncertainty.
fn with_prior(std_error: f64) -> FitSpec {
    let spread = PriorSpread::StdError(vec![std_error; 2]);
    FitSpec { prior: Some(Prior::Given { mean: vec![2.0, -0.5], spread }), ..spec(1) }
}

#[test]
fn a_prior_without_noise_to_weigh_it_against() {
    let x: Vec<f64> = (0..8).map(f64::from).collect();
    let flat = Nodes::curve(x, vec![0.0; 8], None).unwrap();
    let found = fit(&flat, &with_prior(1.0));
    assert!(warned(&found, "prior_unused") && found.coefficients.iter().all(|c| c.value == 0.0));
    let known = fit(&flat, &FitSpec { noise_sigma: Some(0.5), ..with_prior(1.0) });
    assert!(!warned(&known, "prior_unused") && known.coefficients[0].value > 0.0);
}

/// Numbers above doubles are the prior's error, not the nodes' or the regularisation's.
#[test]
fn extreme_priors_are_refused_at_their_spread() {
    for std_error in [1e-300, 1e-160, 1e160, 1e300, 1.7e308] {
        let found = flankfit_engine::estimation::fit(&line(0.1), &with_prior(std_error));
        let Err(FitError::ExceedsDouble(faults)) = found else { panic!("{std_error}") };
        assert_eq!(faults.list()[0].path, "prior.std_error", "{std_error}");
    }
    for std_error in [1e-20, 1e20, 1e150] {
        assert!(flankfit_engine::estimation::fit(&line(0.1), &with_prior(std_error)).is_ok(), "{std_error}");
    }
}

#[test]
fn a_shape_at_an_end_of_its_range() {
    // heavier tails than Student's with half a degree of freedom
    let mut random = Random::new(8);
    let x: Vec<f64> = (0..200).map(|k| f64::from(k) / 8.0).collect();
    let wild = x.iter().map(|x| 1.0 + x + (5.0 * random.normal()).exp() * random.normal()).collect();
    let even = x.iter().map(|x| 1.0 + x + random.unit()).collect();
    let tame = x.iter().map(|x| 1.0 + x + random.normal()).collect();
    let of = |y: Vec<f64>, distribution| {
        let nodes = Nodes::curve(x.clone(), y, None).unwrap();
        let found = fit(&nodes, &FitSpec { estimator: Estimator::Likelihood(distribution), ..spec(1) });
        let shape = found.robust.as_ref().unwrap().likelihood.as_ref().unwrap().shape.unwrap();
        (shape, warned(&found, "shape_at_bound"))
    };
    let student = |freedom| Distribution::Student { freedom };
    let normal = |exponent| Distribution::GeneralizedNormal { exponent };
    let wild: Vec<f64> = wild;
    assert_eq!(of(wild.clone(), student(None)), (0.5, true));
    assert_eq!(of(wild.clone(), student(Some(0.5))), (0.5, false));
    assert_eq!(of(wild, normal(None)), (1.0, true));
    assert_eq!(of(even, normal(None)), (8.0, true));
    assert!(!of(tame, student(None)).1);
}
