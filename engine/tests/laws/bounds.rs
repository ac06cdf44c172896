//! Ineq. 51 and the other bounds: each as defined, each in its order, each truly a bound.

use crate::oracle::matrix::doubles;
use crate::oracle::spectral::Sums;
use crate::problems::{Problem, assert_close, columns, config, filter, fit, linear, spectral, warned};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::result::NormLimitSource;
use flankfit_engine::estimation::spec::{Count, FitSpec, Parameter, Regularization, Scaling, Scheme};
use proptest::prelude::*;

/// Ineq. 51 with e = max cᵢ, as a bound on the norm.
fn paper(sums: &Sums, mu: &[f64], e: f64, r: f64) -> f64 {
    let n = mu.len() as f64;
    let trace: f64 = mu.iter().sum();
    let least = mu.iter().copied().fold(f64::INFINITY, f64::min);
    let mean_log = mu.iter().map(|m| m.ln()).sum::<f64>() / n;
    (trace * e * e * sums.lambda[0].powi(2) * (1.0 + e * e) * r * r / (least * least * mean_log.exp())).sqrt()
}

fn check(problem: &Problem, scheme: Scheme, scaling: Scaling, count: usize, result: &FitResult) {
    let spectrum = problem.spectrum(columns(scaling));
    let sums = spectrum.sums();
    let n = sums.n();
    let (filter, t) = (filter(scheme, count), result.regularization.lambda_star.unwrap());
    let (bias, c) = (&result.bias, sums.c(filter, t));
    let (r, e) = (bias.coefficient_norm_limit, c.iter().copied().fold(0.0, f64::max));
    let estimate = sums.a.iter().map(|a| a * a).sum::<f64>().sqrt();
    assert_close("norm of D", bias.norm, sums.bias_norm(filter, t), 1e-6, 1e-10 * estimate);
    assert_close("e", bias.e.unwrap(), e, 1e-7, 1e-12);
    assert_close("sharp", bias.sharp_bound, r * e / (1.0 + e), 1e-7, 1e-12 * r);
    let (sharp, paper_bound) = (bias.sharp_bound, bias.paper_bound.unwrap());
    assert_close("Ineq. 51", paper_bound, paper(&sums, &sums.regularized(filter, t), e, r), 1e-6, 1e-10 * r);
    assert!(sharp <= paper_bound * (1.0 + 1e-9), "sharp {sharp:e} above the paper's {paper_bound:e}");
    if r >= estimate * (1.0 - 1e-12) {
        assert!(bias.norm <= sharp * (1.0 + 1e-9) + 1e-13 * r, "observed {:e} above {sharp:e}", bias.norm);
    }

    // |D_j| of every coefficient, in the caller's columns.
    let (vectors, scales) = (&spectrum.vectors, doubles(&spectrum.scales));
    let factors: Vec<f64> = c.iter().map(|c| c / (1.0 + c)).collect();
    for (j, coefficient) in result.coefficients.iter().enumerate() {
        let reach = (0..n).map(|i| (factors[i] * vectors[i][j].to_f64()).powi(2)).sum::<f64>().sqrt();
        let bound = coefficient.bias_bound;
        assert_close("bound of a coefficient", bound, r * reach / scales[j], 1e-6, 1e-11 * r / scales[j]);
        if r >= estimate * (1.0 - 1e-12) {
            let change = (coefficient.least_squares - coefficient.value).abs();
            let rounding = 1e-14 * coefficient.least_squares.abs();
            assert!(change <= bound * (1.0 + 1e-7) + rounding, "{change:e} above its bound {bound:e}");
        }
    }
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn sharp_bounds_lie_between_observed_and_paper_bounds(
        seed: u64, n in 2usize..9, extra in 0usize..12, log_condition in 1.0f64..12.0, place in 0.0f64..1.0,
        exact: bool, unit: bool, count in 1usize..8, limit in 0.1f64..10.0,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let count = 1 + (count - 1) % (n - 1);
        let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let sums = problem.spectrum(columns(scaling)).sums();
        let t = sums.lambda[0] * (sums.lambda[n - 1] / sums.lambda[0]).powf(place);
        let estimate = sums.a.iter().map(|a| a * a).sum::<f64>().sqrt();
        let regularization = spectral(scheme, Count::Given(count), Parameter::Fixed(t));
        let spec = FitSpec { scaling, regularization, ..linear() };

        let own = fit(&problem.nodes(), &spec);
        prop_assert_eq!(own.bias.coefficient_norm_limit_source, NormLimitSource::Estimate);
        assert_close("‖Â‖", own.bias.coefficient_norm_limit, estimate, 1e-7, 0.0);
        check(&problem, scheme, scaling, count, &own);

        let asked = fit(&problem.nodes(), &FitSpec { coefficient_norm_limit: Some(limit * estimate), ..spec });
        prop_assert_eq!(asked.bias.coefficient_norm_limit_source, NormLimitSource::Request);
        prop_assert_eq!(asked.bias.coefficient_norm_limit, limit * estimate);
        prop_assert!(limit < 1.0 || !warned(&asked, "norm_limit_contradicted"));
        check(&problem, scheme, scaling, count, &asked);
        prop_assert_eq!(asked.bias.norm, own.bias.norm);
    }
}

#[test]
fn one_coefficient_has_no_paper_bound() {
    let problem = Problem::graded(1, 1, 4, 0.0);
    let result = fit(&problem.nodes(), &FitSpec { regularization: Regularization::default(), ..linear() });
    assert_eq!(result.bias.paper_bound, None);
}
