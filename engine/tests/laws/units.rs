//! Under unit-length columns a change of unit changes units and nothing else.

use crate::problems::{Surface, assert_all_close, assert_close, config, fit, polynomial};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::result::TermKey;
use flankfit_engine::estimation::spec::{
    Criterion, Degree, FitSpec, NodeUncertainty, Parameter, PolynomialBasis, Regularization,
};
use proptest::prelude::*;

/// `one` in millimetres, `two` in a unit of which `unit` make a millimetre.
fn compare(one: &FitResult, two: &FitResult, unit: f64, slack: f64) {
    for (a, b) in one.coefficients.iter().zip(&two.coefficients) {
        let TermKey::Powers(powers) = &a.key else { panic!("{:?}", a.key) };
        assert_eq!(a.key, b.key);
        assert_eq!(a.term, b.term);
        let factor = unit.powi(1 - powers.iter().sum::<usize>() as i32);
        let noise = 1e-5 * a.least_squares_std_error.unwrap() * factor;
        for (p, q) in [(a.value, b.value), (a.least_squares, b.least_squares)] {
            assert_close(&a.term, p * factor, q, slack, noise);
        }
        let errors = [(a.std_error, b.std_error), (a.least_squares_std_error, b.least_squares_std_error)];
        for (p, q) in errors {
            assert_close("standard error", p.unwrap() * factor, q.unwrap(), slack, 0.0);
        }
        assert_close("bound", a.bias_bound * factor, b.bias_bound, slack, noise);
    }
    assert_all_close("eigenvalues", &one.spectrum.eigenvalues, &two.spectrum.eigenvalues, slack);
    let (a, b) = (&one.regularization, &two.regularization);
    assert_eq!((a.count, a.criterion), (b.count, b.criterion));
    if let (Some(p), Some(q)) = (a.lambda_star, b.lambda_star) {
        // The place of a flat minimum is known to half the digits only.
        assert_close("λ*", p, q, slack.max(1e-6).sqrt(), 0.0);
    }
    assert_all_close("f", &a.filter_factors, &b.filter_factors, slack.max(1e-6).sqrt());
    assert_close("bias", one.bias.norm * unit, two.bias.norm, slack.max(1e-6).sqrt(), 0.0);
    assert_close("r", one.bias.coefficient_norm_limit * unit, two.bias.coefficient_norm_limit, slack, 0.0);
    assert_close("rss", one.residuals.rss * unit * unit, two.residuals.rss, slack, 0.0);
    assert_close("σ", one.residuals.sigma.unwrap() * unit, two.residuals.sigma.unwrap(), slack, 0.0);
    assert_close("r²", one.residuals.r_squared.unwrap(), two.residuals.r_squared.unwrap(), slack, 0.0);
    let vifs = |r: &FitResult| r.collinearity.columns.iter().filter_map(|c| c.vif).collect::<Vec<f64>>();
    assert_all_close("vif", &vifs(one), &vifs(two), slack);
    let bounds = |r: &FitResult| r.perturbation.as_ref().unwrap().least_squares.first_order_bound.unwrap();
    assert_close("perturbation", bounds(one), bounds(two), slack.max(1e-6), 0.0);
}

fn spec(regularization: Regularization, unit: f64) -> FitSpec {
    FitSpec {
        regularization,
        node_uncertainty: Some(NodeUncertainty { position: 1e-6 * unit, height: 1e-4 * unit, kind: None }),
        ..polynomial(Degree::Both(2), PolynomialBasis::Monomial)
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn millimetres_and_inches(seed: u64, decay in 0.1f64..0.8, power in -8i32..9) {
        let surface = Surface::new(seed, [2, 2], decay, 5e-4);
        let fixed = Regularization::Ridge { parameter: Parameter::Fixed(1e-6) };
        let gcv = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Gcv) };
        for regularization in [Regularization::default(), Regularization::None, fixed, gcv] {
            let own = fit(&surface.scattered(), &spec(regularization.clone(), 1.0));
            // A power of 2 changes no digit; inches round every number once, which the small
            // eigenvalues feel.
            for (unit, slack) in [(2f64.powi(power), 1e-10), (1.0 / 25.4, 1e-7)] {
                let other = fit(&surface.scattered_in(unit), &spec(regularization.clone(), unit));
                compare(&own, &other, unit, slack);
            }
        }
    }
}
