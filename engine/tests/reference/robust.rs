//! Robust estimates against references computed to 25 digits and more.

use crate::answers::{answer, at_least, curve, matrix, monomials, plain, std_errors, values};
use crate::folder::{decimals, number, numbers, reference};
use flankfit_engine::estimation::{
    FitSpec, Nodes,
    spec::{Estimator, Include, Loss, MEstimator, Model, ScaleRule},
};
use serde_json::Value;

/// Nodes and model of a reference.
fn problem(reference: &Value) -> (Nodes, FitSpec) {
    let data = |name: &str| numbers(&reference["data"][name]);
    if reference["response"] == "y" {
        (curve(&data("x"), &data("y")), plain(monomials(3)))
    } else {
        let columns = [data("AirFlow"), data("WaterTemp"), data("AcidConc")];
        let y = data("StackLoss");
        let x: Vec<Vec<f64>> =
            (0..y.len()).map(|k| std::iter::once(1.0).chain(columns.iter().map(|c| c[k])).collect()).collect();
        (matrix(&x, &y), plain(Model::Linear))
    }
}

/// The estimator that a reference names.
fn estimator(name: &str) -> MEstimator {
    let loss = match name.split('_').next() {
        Some("huber") => Loss::HUBER,
        Some("tukey") => Loss::TUKEY,
        Some("hampel") => Loss::HAMPEL,
        other => panic!("{other:?}"),
    };
    let scale = if name.ends_with("MAD0.6745") {
        ScaleRule::Mad06745
    } else if name.ends_with("MADexact") {
        ScaleRule::Mad
    } else if name.ends_with("prop2_1.345") {
        ScaleRule::Proposal2 { k2: 1.345 }
    } else if name.ends_with("huberscale_2.5") {
        // the same scale in other words, with k₂ = 2.5
        ScaleRule::Proposal2 { k2: 2.5 }
    } else {
        panic!("{name}")
    };
    MEstimator { scale, ..MEstimator::new(loss) }
}

fn m_estimators(name: &str) {
    let reference = reference(name);
    let (nodes, spec) = problem(&reference);
    for entry in reference["estimates"].as_array().expect("estimates") {
        let name = entry["estimator"].as_str().expect("a name");
        let asked = match name.strip_suffix("fixedscale") {
            Some(_) => MEstimator {
                scale: ScaleRule::Fixed(number(&entry["scale"])),
                ..MEstimator::new(if name.starts_with("huber") { Loss::HUBER } else { Loss::TUKEY })
            },
            None => estimator(name),
        };
        let include = Include { robust_weights: true, ..Include::default() };
        let result = answer(&nodes, &FitSpec { estimator: Estimator::M(asked), include, ..spec.clone() });
        let robust = result.robust.as_ref().expect("a robust fit");
        assert!(robust.converged, "{name}: {robust:?}");
        println!("{name}: {} iterations, {:?} reached", robust.iterations, robust.tolerance_reached);
        at_least(name, &values(&result), &decimals(&entry["coef_dec"]), 10.0);
        at_least(name, &robust.coefficients, &decimals(&entry["coef_dec"]), 10.0);
        let scale = number(&entry["scale"]);
        let found = robust.scale.unwrap();
        assert!((found / scale - 1.0).abs() < 1e-10, "{name}: scale {found} {scale}");
        // wider than the asymptotic ones by one factor
        let text = |error: &Value| error.as_str().expect("a decimal text").parse().expect("a number");
        let asymptotic: Vec<f64> =
            entry["se_statsmodels_H1_dec"].as_array().expect("errors").iter().map(text).collect();
        let errors = std_errors(&result);
        let factor = errors[0] / asymptotic[0];
        assert!((1.0..1.4).contains(&factor), "{name}: {factor}");
        for (error, asymptotic) in errors.iter().zip(&asymptotic) {
            assert!((error / (factor * asymptotic) - 1.0).abs() < 1e-9, "{name}: {error} {asymptotic}");
        }
        for (got, wanted) in robust.weights.as_ref().unwrap().iter().zip(numbers(&entry["weights"])) {
            assert!((got - wanted).abs() < 1e-9, "{name}: weight {got} {wanted}");
        }
        if let Some(objective) = entry["objective_sum_rho"].as_f64() {
            assert!((robust.objective / objective - 1.0).abs() < 1e-9, "{name}: {} {objective}", robust.objective);
        }
        let least_squares: Vec<f64> = result.coefficients.iter().map(|c| c.least_squares).collect();
        at_least(name, &least_squares, &decimals(&reference["ols"]["coef_dec"]), 12.0);
        let errors: Vec<f64> = result.coefficients.iter().map(|c| c.least_squares_std_error.unwrap()).collect();
        at_least(name, &errors, &decimals(&reference["ols"]["se_dec"]), 12.0);
    }
}

#[test]
fn m_estimators_of_the_cubic_with_outliers() {
    m_estimators("robust_cubic_outliers_m_estimators");
}

#[test]
fn m_estimators_of_the_stack_loss() {
    m_estimators("robust_stackloss_m_estimators");
}

#[test]
fn least_absolute_deviations_find_the_exact_vertex() {
    for name in ["robust_cubic_outliers_lad", "robust_stackloss_lad"] {
        let reference = reference(name);
        let (nodes, spec) = problem(&reference);
        let solution = &reference["solution"];
        for estimator in [Estimator::LeastAbsolute, Estimator::Lp { p: 1.0 }, Estimator::Quantile { tau: 0.5 }] {
            let result = answer(&nodes, &FitSpec { estimator, ..spec.clone() });
            let robust = result.robust.as_ref().expect("a robust fit");
            at_least(name, &values(&result), &decimals(&solution["coef_dec"]), 14.5);
            let vertex: Vec<f64> = robust.vertex.as_ref().unwrap().iter().map(|k| *k as f64).collect();
            assert_eq!(vertex, numbers(&solution["zero_residual_indices"]));
            let dual = solution["dual_on_zero_residuals"].as_object().unwrap();
            let largest = dual.values().map(|d| number(d).abs()).fold(0.0, f64::max);
            assert!(
                (robust.certificate.unwrap() - largest).abs() < 1e-10,
                "{name}: {:?} {largest}",
                robust.certificate
            );
            assert_eq!(robust.unique, Some(true));
            let half = if estimator == (Estimator::Quantile { tau: 0.5 }) { 0.5 } else { 1.0 };
            let objective = half * number(&solution["objective_sum_abs"]);
            assert!((robust.objective / objective - 1.0).abs() < 1e-13, "{name}: {} {objective}", robust.objective);
        }
    }
}
