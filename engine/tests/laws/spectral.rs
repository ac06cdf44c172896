//! Eqs. 29–48: the spectrum of X, of X + B formed explicitly, the size of B and the estimate.

use crate::oracle::big::Big;
use crate::oracle::matrix::{dot, doubles, eigen, gram, least_squares, rows, vector};
use crate::problems::{
    Problem, assert_all_close, assert_close, close, columns, config, filter, fit, least_squares_values, linear, matrix,
    spectral, values,
};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::spec::{Count, FitSpec, Include, Parameter, Regularization, Scaling, Scheme};
use proptest::prelude::*;

fn question(problem: &Problem, scheme: Scheme, scaling: Scaling, count: Count, place: f64) -> FitSpec {
    // λ* is placed on the logarithmic scale, 0 at λ₁ and 1 at λₙ.
    let lambda = problem.spectrum(columns(scaling)).sums().lambda;
    let (low, high) = (lambda[0].ln(), lambda[lambda.len() - 1].ln());
    let lambda_star = Parameter::Fixed((low + place * (high - low)).exp());
    let include = Include { matrix_b: true, ..Include::default() };
    FitSpec { scaling, include, regularization: spectral(scheme, count, lambda_star), ..linear() }
}

fn schemes() -> impl Strategy<Value = Scheme> {
    prop_oneof![Just(Scheme::FirstOrder), Just(Scheme::Exact)]
}

fn scalings() -> impl Strategy<Value = Scaling> {
    prop_oneof![Just(Scaling::UnitLength), Just(Scaling::None)]
}

/// (X + B) in the scaled columns, explicitly.
fn regularized_matrix(problem: &Problem, scaling: Scaling, result: &FitResult) -> (Vec<Vec<Big>>, Vec<Vec<Big>>) {
    let spectrum = problem.spectrum(columns(scaling));
    let b = rows(result.matrix_b.as_ref().expect("B was asked for"));
    let scaled_b: Vec<Vec<Big>> =
        b.iter().map(|row| row.iter().zip(&spectrum.scales).map(|(b, s)| b / s).collect()).collect();
    let sum =
        (spectrum.scaled.iter().zip(&scaled_b)).map(|(x, b)| x.iter().zip(b).map(|(x, b)| x + b).collect()).collect();
    (sum, scaled_b)
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn the_spectrum_is_that_of_the_matrix(
        seed: u64, n in 1usize..9, extra in 1usize..12, log_condition in 0.0f64..20.0, scaling in scalings(),
    ) {
        let problem = Problem::clustered(seed, n, extra, log_condition);
        let sums = problem.spectrum(columns(scaling)).sums();
        let result = fit(&problem.nodes(), &FitSpec { scaling, regularization: Regularization::None, ..linear() });
        let spectrum = &result.spectrum;
        prop_assert_eq!(spectrum.rank, n);
        assert_all_close("eigenvalues", &spectrum.eigenvalues, &sums.lambda, 1e-9);
        let condition = sums.lambda[n - 1] / sums.lambda[0];
        assert_close("condition", spectrum.condition.unwrap(), condition, 1e-8, 0.0);
        assert_close("log10 condition", spectrum.log10_condition.unwrap(), condition.log10(), 0.0, 1e-8);
        let determinant: f64 = sums.lambda.iter().map(|l| l.log10()).sum();
        assert_close("log10 determinant", spectrum.log10_determinant.unwrap(), determinant, 0.0, 1e-7);
        assert_all_close("nothing is regularised", &spectrum.regularized.eigenvalues, &spectrum.eigenvalues, 0.0);
        prop_assert!(result.regularization.filter_factors.iter().all(|f| *f == 1.0));
    }

    #[test]
    fn eigenvalues_of_the_explicit_sum_are_those_reported(
        seed: u64, n in 2usize..9, extra in 0usize..12, log_condition in 0.0f64..12.0, place in -0.2f64..1.2,
        scheme in schemes(), scaling in scalings(), count in 0usize..8,
    ) {
        let problem = Problem::clustered(seed, n, extra, log_condition);
        let count = if count == 0 { Count::Auto } else { Count::Given(1 + (count - 1) % (n - 1)) };
        let result = fit(&problem.nodes(), &question(&problem, scheme, scaling, count, place));
        let report = &result.regularization;
        let used = report.count.unwrap();
        if count == Count::Auto {
            let lambda = problem.spectrum(columns(scaling)).sums().lambda;
            prop_assert_eq!(used, lambda.iter().filter(|l| lambda[n - 1] / **l > 900.0).count());
        }
        if used == 0 {
            prop_assert!(report.lambda_star.is_none() && report.lambda_star_interval.is_none());
            prop_assert!(report.filter_factors.iter().all(|f| *f == 1.0));
            prop_assert_eq!(result.bias.norm, 0.0);
            prop_assert_eq!(values(&result), least_squares_values(&result));
            return Ok(());
        }

        let (sum, b) = regularized_matrix(&problem, scaling, &result);
        let (explicit, _) = eigen(&gram(&sum));
        let mut reported = result.spectrum.regularized.eigenvalues.clone();
        reported.sort_by(f64::total_cmp);
        let b_squared = b.iter().fold(Big::zero(), |s, row| &s + &dot(row, row)).to_f64();
        // B comes as doubles: its rounding moves every singular value by at most this much.
        let rounding = 1e-13 * (b_squared.sqrt() + explicit[n - 1].sqrt().to_f64());
        for (e, r) in explicit.iter().zip(&reported) {
            let (e, r) = (e.sqrt().to_f64(), r.sqrt());
            prop_assert!(close(e, r, 1e-9, rounding), "singular value {e:e} of X + B is reported as {r:e}");
        }

        // Eq. 41, Ineq. 48, and the definitions around them.
        let (lambda, mu) = (&result.spectrum.eigenvalues, &result.spectrum.regularized.eigenvalues);
        let t = report.lambda_star.unwrap();
        assert_close("gamma", report.gamma.unwrap(), t - lambda[0], 1e-9, 1e-12 * t);
        assert_close("norm of B", report.matrix_norm_squared.unwrap().sqrt(), b_squared.sqrt(), 1e-9, rounding);
        let bound = report.largest_eigenvalue_bound.unwrap();
        assert_close("Ineq. 48", bound, lambda[n - 1] + mu[0] - lambda[0], 1e-9, 0.0);
        prop_assert!(mu.iter().all(|m| *m <= bound * (1.0 + 1e-12)));
        let sums = problem.spectrum(columns(scaling)).sums();
        let filter = filter(scheme, used);
        assert_all_close("μ", mu, &sums.regularized(filter, t), 1e-8);
        assert_all_close("f", &report.filter_factors, &sums.factors(filter, t), 1e-8);
        prop_assert!(report.filter_factors.iter().all(|f| *f > 0.0 && *f <= 1.0));
        if scheme == Scheme::Exact {
            prop_assert!((0..used).all(|i| close(mu[i], t.max(lambda[i]), 1e-9, 0.0)));
        }
    }

    #[test]
    fn the_estimate_is_equation_29(
        seed: u64, n in 2usize..9, extra in 1usize..12, log_condition in 0.0f64..8.0, place in 0.0f64..1.0,
        scheme in schemes(), scaling in scalings(), count in 1usize..8,
    ) {
        let problem = Problem::clustered(seed, n, extra, log_condition);
        let count = 1 + (count - 1) % (n - 1);
        let result = fit(&problem.nodes(), &question(&problem, scheme, scaling, Count::Given(count), place));
        let (sum, _) = regularized_matrix(&problem, scaling, &result);
        let naive = doubles(&least_squares(&sum, &vector(&problem.y)).coefficients);
        let scales = doubles(&problem.spectrum(columns(scaling)).scales);
        let norm = naive.iter().map(|a| a * a).sum::<f64>().sqrt();
        for (j, coefficient) in result.coefficients.iter().enumerate() {
            let scaled = coefficient.value * scales[j];
            prop_assert!(close(scaled, naive[j], 0.0, 1e-9 * norm), "{scaled:e} and, by Eq. 29, {:e}", naive[j]);
        }
    }

    #[test]
    fn nothing_to_regularise_is_least_squares(
        seed: u64, n in 1usize..9, extra in 1usize..12, log_condition in 0.0f64..12.0, scheme in schemes(),
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let none = fit(&problem.nodes(), &FitSpec { regularization: Regularization::None, ..linear() });
        let regularization = spectral(scheme, Count::Given(0), Parameter::Fixed(1.0));
        let nought = fit(&problem.nodes(), &FitSpec { regularization, ..linear() });
        prop_assert_eq!(values(&none), values(&nought));
        prop_assert_eq!(values(&none), least_squares_values(&none));
        prop_assert_eq!(least_squares_values(&none), least_squares_values(&nought));
        prop_assert_eq!(none.residuals.rss, nought.residuals.rss);
        prop_assert_eq!(none.residuals.rss, none.residuals.least_squares_rss);
        prop_assert_eq!(nought.regularization.count, Some(0));
        prop_assert_eq!((nought.bias.norm, nought.bias.sharp_bound), (0.0, 0.0));
        for c in &nought.coefficients {
            prop_assert_eq!(c.bias_bound, 0.0);
            prop_assert_eq!(c.std_error, c.least_squares_std_error);
        }
        // λ* at or below λ₁ leaves everything as it is.
        if n > 1 {
            let below = Parameter::Fixed(0.5 * none.spectrum.eigenvalues[0]);
            let regularization = spectral(scheme, Count::Given(1), below);
            let result = fit(&problem.nodes(), &FitSpec { regularization, ..linear() });
            prop_assert!(result.regularization.filter_factors.iter().all(|f| *f == 1.0));
            prop_assert_eq!(result.bias.norm, 0.0);
        }
    }

    #[test]
    fn least_squares_coefficients_are_the_exact_ones(
        seed: u64, n in 1usize..9, extra in 0usize..12, log_condition in 0.0f64..20.0,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let exact = doubles(&least_squares(&rows(&problem.x), &vector(&problem.y)).coefficients);
        let result = fit(&problem.nodes(), &FitSpec { regularization: Regularization::None, ..linear() });
        let norm = exact.iter().map(|a| a * a).sum::<f64>().sqrt();
        for (got, exact) in values(&result).iter().zip(&exact) {
            prop_assert!(close(*got, *exact, 0.0, 1e-10 * norm), "{got:e} is {exact:e}");
        }
    }
}

#[test]
fn b_belongs_to_the_rows_as_posted() {
    // A weight of 0 leaves a node out of X, hence out of B.
    let problem = Problem::graded(3, 3, 6, 6.0);
    let mut weight = vec![1.0; problem.y.len()];
    weight[2] = 0.0;
    let include = Include { matrix_b: true, ..Include::default() };
    let regularization = spectral(Scheme::Exact, Count::Given(1), Parameter::Fixed(0.1));
    let result = fit(&matrix(&problem.x, &problem.y, Some(weight)), &FitSpec { include, regularization, ..linear() });
    assert_eq!(result.matrix_b.unwrap().len(), problem.y.len() - 1);
}
