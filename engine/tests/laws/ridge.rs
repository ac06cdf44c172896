//! Ridge: the solution of (XᵀX + k) A = XᵀY, and the same criteria over log k.

use crate::criteria::Trial;
use crate::oracle::big::Big;
use crate::oracle::matrix::{column, dot, doubles, gram, inverse, times, vector};
use crate::oracle::spectral::Filter;
use crate::problems::{Problem, assert_all_close, assert_close, by, close, columns, config, fit, linear, values};
use flankfit_engine::estimation::spec::{ChosenBy, Criterion, FitSpec, Parameter, Regularization, Scaling};
use flankfit_engine::estimation::{FitError, fit as try_fit};
use proptest::prelude::*;

fn ridge(parameter: Parameter) -> Regularization {
    Regularization::Ridge { parameter }
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn the_estimate_solves_the_penalised_equations(
        seed: u64, n in 1usize..9, extra in 1usize..12, log_condition in 1.0f64..12.0, place in -0.5f64..1.5,
        unit: bool,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let spectrum = problem.spectrum(columns(scaling));
        let sums = spectrum.sums();
        let k = sums.lambda[0] * (sums.lambda[n - 1] / sums.lambda[0]).powf(place);
        let spec = FitSpec { scaling, regularization: ridge(Parameter::Fixed(k)), ..linear() };
        let result = fit(&problem.nodes(), &spec);

        let mut penalised = gram(&spectrum.scaled);
        (0..n).for_each(|i| penalised[i][i] = &penalised[i][i] + &Big::from(k));
        let y = vector(&problem.y);
        let moments: Vec<Big> = (0..n).map(|j| dot(&column(&spectrum.scaled, j), &y)).collect();
        let exact = doubles(&times(&inverse(&penalised), &moments));
        let norm = exact.iter().map(|a| a * a).sum::<f64>().sqrt();
        for ((value, scale), exact) in values(&result).iter().zip(&spectrum.scales).zip(&exact) {
            let scaled = value * scale.to_f64();
            prop_assert!(close(scaled, *exact, 0.0, 1e-9 * norm), "{scaled:e} solves to {exact:e}");
        }
        let factors = sums.factors(Filter::Ridge, k);
        assert_all_close("f", &result.regularization.filter_factors, &factors, 1e-8);
        let shifted: Vec<f64> = sums.lambda.iter().map(|l| l + k).collect();
        assert_all_close("λ + k", &result.spectrum.regularized.eigenvalues, &shifted, 1e-8);

        let (report, bias) = (&result.regularization, &result.bias);
        prop_assert!(report.scheme.is_none() && report.count.is_none() && report.gamma.is_none());
        prop_assert!(report.matrix_norm_squared.is_none() && report.largest_eigenvalue_bound.is_none());
        prop_assert!(bias.paper_bound.is_none() && bias.e.is_none());
        let reach = factors.iter().map(|f| 1.0 - f).fold(0.0, f64::max);
        assert_close("sharp", bias.sharp_bound, bias.coefficient_norm_limit * reach, 1e-7, 0.0);
        prop_assert!(bias.norm <= bias.sharp_bound * (1.0 + 1e-9));
        for c in &result.coefficients {
            let change = (c.least_squares - c.value).abs();
            prop_assert!(change <= c.bias_bound * (1.0 + 1e-7) + 1e-14 * c.least_squares.abs());
        }
    }

    #[test]
    fn choices_of_k_are_those_of_a_brute_force_search(
        seed: u64, n in 1usize..9, extra in 1usize..20, log_condition in 1.0f64..12.0, unit: bool,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let sums = problem.spectrum(columns(scaling)).sums();
        let range = [1e-8 * sums.lambda[0], 1e4 * sums.lambda[n - 1]];
        let trial = Trial { sums: &sums, filter: Filter::Ridge, range, sigma: sums.sigma() };
        for criterion in [Criterion::MinMse, Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve] {
            let spec = FitSpec { scaling, regularization: ridge(by(criterion)), ..linear() };
            let result = fit(&problem.nodes(), &spec);
            trial.check(&result);
            let wanted = ChosenBy::Criterion(criterion);
            let choice = result.regularization.choices.iter().find(|c| c.criterion == wanted).unwrap();
            prop_assert_eq!(choice.lambda_star, result.regularization.lambda_star);
        }
    }
}

#[test]
fn ridge_has_no_least_condition() {
    let problem = Problem::graded(1, 3, 4, 4.0);
    let spec = FitSpec { regularization: ridge(by(Criterion::MinCondition)), ..linear() };
    let refused = try_fit(&problem.nodes(), &spec);
    let Err(FitError::Invalid(faults)) = refused else { panic!("{refused:?}") };
    assert!(faults.list()[0].path == "regularization.parameter.criterion", "{faults:?}");
}

#[test]
fn no_regularised_count_reaches_n() {
    use crate::problems::spectral;
    use flankfit_engine::estimation::spec::{Count, Scheme};
    let problem = Problem::graded(1, 3, 4, 4.0);
    for (scheme, count) in [(Scheme::FirstOrder, 3), (Scheme::Exact, 7)] {
        let spec = FitSpec { regularization: spectral(scheme, Count::Given(count), by(Criterion::MinMse)), ..linear() };
        let refused = try_fit(&problem.nodes(), &spec);
        let Err(FitError::Invalid(faults)) = refused else { panic!("{refused:?}") };
        assert_eq!(faults.list()[0].path, "regularization.count");
    }
}
