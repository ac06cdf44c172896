//! Standard errors, residual figures, r², and the standardised scaling.

use crate::oracle::big::Big;
use crate::oracle::matrix::{doubles, least_squares, rows, vector};
use crate::oracle::random::Random;
use crate::oracle::spectral::{Columns, Filter, Spectrum};
use crate::problems::{
    Problem, assert_all_close, assert_close, by, columns, config, filter, fit, linear, matrix, polynomial, spectral,
    values, warned,
};
use flankfit_engine::estimation::spec::{
    ChosenBy, Count, Criterion, Degree, FitSpec, Include, Parameter, PolynomialBasis, Regularization, Scaling, Scheme,
};
use flankfit_engine::estimation::{
    FitError, Nodes, fit as try_fit,
    result::{Choice, FitResult},
};
use proptest::prelude::*;

/// Returns the criteria whose choices are reported.
fn criteria_of(result: &FitResult) -> Vec<Criterion> {
    let criterion = |choice: &Choice| match choice.criterion {
        ChosenBy::Criterion(criterion) => Some(criterion),
        ChosenBy::Fixed | ChosenBy::LeastSquares => None,
    };
    result.regularization.choices.iter().filter_map(criterion).collect()
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn standard_errors_and_residual_figures(
        seed: u64, n in 2usize..7, extra in 1usize..12, log_condition in 0.0f64..12.0, place in 0.0f64..1.0,
        exact: bool, weighted: bool,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let mut random = Random::new(seed);
        let weight: Option<Vec<f64>> = weighted.then(|| problem.y.iter().map(|_| random.between(0.1, 9.0)).collect());
        let spectrum =
            Spectrum::new(&rows(&problem.x), &vector(&problem.y), weight.as_deref(), columns(Scaling::UnitLength));
        let sums = spectrum.sums();
        let t = sums.lambda[0] * (sums.lambda[n - 1] / sums.lambda[0]).powf(place);
        let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
        let factors = sums.factors(filter(scheme, 1), t);
        let regularization = spectral(scheme, Count::Given(1), Parameter::Fixed(t));
        let include = Include { residuals: true, ..Include::default() };
        let nodes = matrix(&problem.x, &problem.y, weight.clone());
        let result = fit(&nodes, &FitSpec { regularization, include, ..linear() });

        let m = problem.y.len();
        let residual = &result.residuals;
        prop_assert_eq!((residual.count, residual.degrees_of_freedom), (m, m - n));
        assert_close("σ̂", residual.sigma.unwrap(), sums.sigma(), 1e-7, 0.0);
        assert_close("rss", residual.least_squares_rss, sums.rss, 1e-7, 0.0);
        assert_close("regularised rss", residual.rss, sums.rss_at(filter(scheme, 1), t), 1e-7, 0.0);
        assert_close("rms", residual.rms, (residual.rss / sums.total_weight).sqrt(), 1e-12, 0.0);

        // Residuals of Â_B are taken with the caller's X, unweighted.
        let own = spectrum.coefficients(&factors);
        let size = problem.y.iter().fold(0.0f64, |s, y| s.max(y.abs()));
        let mut greatest = 0.0f64;
        for (k, got) in residual.values.as_ref().unwrap().iter().enumerate() {
            let fitted = problem.x[k].iter().zip(&own).fold(Big::zero(), |s, (x, a)| &s + &(&Big::from(*x) * a));
            let exact = (&Big::from(problem.y[k]) - &fitted).to_f64();
            assert_close("residual", *got, exact, 0.0, 1e-9 * size);
            greatest = greatest.max(got.abs());
        }
        prop_assert_eq!(residual.max_abs, Some(greatest));

        for (j, c) in result.coefficients.iter().enumerate() {
            let spread = |f: &dyn Fn(usize) -> f64| {
                let part = |i: usize| (f(i) * spectrum.vectors[i][j].to_f64()).powi(2) / sums.lambda[i];
                sums.sigma() * (0..n).map(part).sum::<f64>().sqrt() / spectrum.scales[j].to_f64()
            };
            assert_close("standard error", c.error_given_lambda().unwrap(), spread(&|i| factors[i]), 1e-6, 0.0);
            assert_close("least squares", c.least_squares_std_error.unwrap(), spread(&|_| 1.0), 1e-6, 0.0);
        }
    }

    #[test]
    fn standardized_is_centring_by_hand(
        seed: u64, n in 2usize..6, extra in 2usize..12, log_condition in 0.0f64..8.0, at in 0usize..6, weighted: bool,
        constant in prop_oneof![Just(1.0), Just(-2.5)],
    ) {
        let mut problem = Problem::graded(seed, n, extra, log_condition);
        let mut random = Random::new(seed);
        let at = at % (n + 1);
        let shifts = random.normals(n);
        for row in &mut problem.x {
            row.iter_mut().zip(&shifts).for_each(|(x, s)| *x += s);
            row.insert(at, constant);
        }
        let weight: Option<Vec<f64>> = weighted.then(|| problem.y.iter().map(|_| random.between(0.1, 9.0)).collect());
        let spectrum =
            Spectrum::new(&rows(&problem.x), &vector(&problem.y), weight.as_deref(), Columns::Standardized(at));
        let sums = spectrum.sums();
        let k = (sums.lambda[0] * sums.lambda[n - 1]).sqrt();
        let nodes = matrix(&problem.x, &problem.y, weight);
        let mut cases = vec![(Regularization::None, None),
            (Regularization::Ridge { parameter: Parameter::Fixed(k) }, Some(Filter::Ridge))];
        if n > 1 {
            let regularization = spectral(Scheme::FirstOrder, Count::Given(1), Parameter::Fixed(k));
            cases.push((regularization, Some(Filter::FirstOrder(1))));
        }
        for (regularization, filter) in cases {
            let result = fit(&nodes, &FitSpec { scaling: Scaling::Standardized, regularization, ..linear() });
            let factors = filter.map_or(vec![1.0; n], |filter| sums.factors(filter, k));
            assert_all_close("eigenvalues", &result.spectrum.eigenvalues, &sums.lambda, 1e-8);
            assert_all_close("f", &result.regularization.filter_factors, &factors, 1e-7);
            let mut exact = doubles(&spectrum.coefficients(&factors));
            exact[at] /= constant;
            for (got, exact) in result.coefficients.iter().zip(&exact) {
                let noise = 1e-6 * got.least_squares_std_error.unwrap();
                assert_close(&got.term, got.value, *exact, 1e-8, noise);
            }
        }
    }

    #[test]
    fn as_many_nodes_as_coefficients(seed: u64, n in 2usize..7, log_condition in 4.0f64..10.0) {
        let problem = Problem::graded(seed, n, 0, log_condition);
        let result = fit(&problem.nodes(), &linear());
        prop_assert_eq!(result.residuals.degrees_of_freedom, 0);
        prop_assert!(result.residuals.sigma.is_none());
        prop_assert!(result.coefficients.iter().all(|c| c.std_error.is_none() && c.least_squares_std_error.is_none()));
        prop_assert!(warned(&result, "no_degrees_of_freedom"), "{:?}", result.warnings);
        // The default criterion needs σ̂; without one it chooses least squares.
        prop_assert_eq!(values(&result), result.coefficients.iter().map(|c| c.least_squares).collect::<Vec<f64>>());
        let offered = criteria_of(&result);
        // With nothing to be regularised they all choose least squares.
        for criterion in [Criterion::MinMse, Criterion::Gcv, Criterion::Discrepancy] {
            let nothing = result.regularization.count == Some(0);
            prop_assert!(nothing || !offered.contains(&criterion), "{}", criterion.name());
        }
        // With the caller's σ there is everything but gcv.
        let sigma = FitSpec { noise_sigma: Some(1e-3), ..linear() };
        let result = fit(&problem.nodes(), &sigma);
        if result.regularization.count != Some(0) {
            let offered = criteria_of(&result);
            prop_assert!(offered.contains(&Criterion::MinMse) && offered.contains(&Criterion::Discrepancy));
            prop_assert_eq!(result.regularization.criterion, Some(ChosenBy::Criterion(Criterion::MinMse)));
        }
    }
}

#[test]
fn r_squared_is_about_the_mean_where_the_constant_is_in_the_span() {
    let t: Vec<f64> = (0..10).map(|i| 1.0 + 0.5 * i as f64).collect();
    let y: Vec<f64> = t.iter().enumerate().map(|(i, t)| 3.0 + t + [0.1, -0.2, 0.15][i % 3]).collect();
    let weight: Vec<f64> = (0..10).map(|i| [1.0, 2.0, 0.5][i % 3]).collect();
    let plain = |spec: FitSpec| FitSpec { regularization: Regularization::None, ..spec };
    let total = |about: f64| y.iter().zip(&weight).map(|(y, w)| w * (y - about).powi(2)).sum::<f64>();
    let mean = y.iter().zip(&weight).map(|(y, w)| w * y).sum::<f64>() / weight.iter().sum::<f64>();

    let nodes = Nodes::curve(t.clone(), y.clone(), Some(weight.clone())).expect("checked nodes");
    let result = fit(&nodes, &plain(polynomial(Degree::Both(1), PolynomialBasis::Monomial)));
    let r_squared = result.residuals.r_squared.unwrap();
    assert_close("about the mean", r_squared, 1.0 - result.residuals.rss / total(mean), 1e-12, 0.0);

    // The constant as a combination of two columns counts, whatever their names.
    let spanning: Vec<Vec<f64>> = t.iter().map(|t| vec![t + 2.0, t - 1.0]).collect();
    let result = fit(&matrix(&spanning, &y, Some(weight.clone())), &plain(linear()));
    assert_close("in the span", result.residuals.r_squared.unwrap(), r_squared, 1e-11, 0.0);

    let through_zero: Vec<Vec<f64>> = t.iter().map(|t| vec![*t]).collect();
    let result = fit(&matrix(&through_zero, &y, Some(weight.clone())), &plain(linear()));
    let about_zero = 1.0 - result.residuals.rss / total(0.0);
    assert_close("about 0", result.residuals.r_squared.unwrap(), about_zero, 1e-12, 0.0);
}

#[test]
fn r_squared_is_omitted_where_nothing_varies() {
    let t: Vec<f64> = (0..7).map(f64::from).collect();
    for height in [0.0, 0.5] {
        let nodes = Nodes::curve(t.clone(), vec![height; 7], None).expect("checked nodes");
        let result = fit(&nodes, &polynomial(Degree::Both(1), PolynomialBasis::Monomial));
        assert_eq!(result.residuals.r_squared, None, "height {height}");
        assert!(result.residuals.rss < 1e-28);
    }
}

#[test]
fn standardized_needs_one_constant() {
    let spec = FitSpec { scaling: Scaling::Standardized, ..linear() };
    let rows_of = |f: fn(f64) -> Vec<f64>| (0..8).map(|k| f(f64::from(k))).collect::<Vec<_>>();
    let y: Vec<f64> = (0..8).map(|k| f64::from(k % 3)).collect();
    for x in [rows_of(|k| vec![k, k * k]), rows_of(|k| vec![1.0, k, 2.0])] {
        let refused = try_fit(&matrix(&x, &y, None), &spec);
        let Err(FitError::Invalid(faults)) = refused else { panic!("{refused:?}") };
        assert_eq!(faults.list()[0].path, "scaling");
    }
}

#[test]
fn constant_height_is_found_exactly() {
    let t: Vec<f64> = (0..9).map(|k| 30.0 + f64::from(k)).collect();
    let nodes = Nodes::curve(t, vec![0.1; 9], None).expect("checked nodes");
    let spec = polynomial(Degree::Both(3), PolynomialBasis::Monomial);
    let result = fit(&nodes, &FitSpec { regularization: Regularization::None, ..spec });
    assert_close("constant", values(&result)[0], 0.1, 1e-14, 0.0);
    let exact = least_squares(
        &(0..9).map(|k| (0..4).map(|p| Big::from((30.0 + f64::from(k)).powi(p))).collect()).collect(),
        &vector(&[0.1; 9]),
    );
    assert!(exact.rss.log10() < -100.0);
    let regularization = spectral(Scheme::FirstOrder, Count::Auto, by(Criterion::MinMse));
    let result = fit(
        &Nodes::curve((0..9).map(f64::from).collect(), vec![0.1; 9], None).expect("checked nodes"),
        &FitSpec { regularization, ..polynomial(Degree::Both(3), PolynomialBasis::Monomial) },
    );
    assert!(result.coefficients.iter().all(|c| c.value.is_finite()));
}
