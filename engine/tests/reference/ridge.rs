//! Ridge paths: Hald's cement (standardised, λ as in MASS) and a Hilbert matrix (no scaling).

use crate::answers::{answer, at_least, exact, judge_digits, matrix, matrix_floor, plain, std_errors, values};
use crate::folder::{decimals, number, numbers, reference};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::spec::{Criterion, FitSpec, Model, Parameter, Regularization, Scaling};
use serde_json::Value;

fn ridge(parameter: Parameter, scaling: Scaling) -> FitSpec {
    FitSpec { scaling, regularization: Regularization::Ridge { parameter }, ..FitSpec::new(Model::Linear) }
}

fn hald(file: &Value) -> (Vec<Vec<f64>>, Vec<f64>) {
    let columns: Vec<Vec<f64>> = (1..=4).map(|j| numbers(&file["data"][format!("x{j}")])).collect();
    let y = numbers(&file["data"]["y"]);
    ((0..y.len()).map(|k| columns.iter().map(|c| c[k]).collect()).collect(), y)
}

fn with_constant(x: &[Vec<f64>]) -> Vec<Vec<f64>> {
    x.iter().map(|row| [vec![1.0], row.clone()].concat()).collect()
}

#[track_caller]
fn near(what: &str, got: f64, truth: f64, slack: f64) {
    assert!((got - truth).abs() <= slack * truth.abs(), "{what}: {got:e}, in the reference {truth:e}");
}

#[test]
fn hald_standardised() {
    let file = reference("ridge_hald");
    let (x, y) = hald(&file);
    let x = with_constant(&x);
    let nodes = matrix(&x, &y);
    let truth = &file["exact"];

    let none = answer(&nodes, &FitSpec { scaling: Scaling::Standardized, ..plain(Model::Linear) });
    at_least("Hald, least squares", &values(&none), &decimals(&truth["ols_coef_dec"]), 13.0);
    at_least("Hald, standard errors", &std_errors(&none), &decimals(&truth["ols_se_dec"]), 10.0);
    let exact_ones = exact(&x, &y);
    judge_digits("Hald", &none, &exact_ones, matrix_floor(&exact_ones, &x, &y));
    for (eigenvalue, truth) in none.spectrum.eigenvalues.iter().zip(numbers(&truth["eigenvalues_ZtZ"]).iter().rev()) {
        near("eigenvalue", *eigenvalue, *truth, 1e-11);
    }
    assert_eq!(none.spectrum.eigenvalues.len(), 4);
    near("σ", none.residuals.sigma.unwrap(), number(&truth["ols_residual_sd"]), 1e-12);
    near("r²", none.residuals.r_squared.unwrap(), number(&truth["ols_r2"]), 1e-13);
    for (column, truth) in none.collinearity.columns[1..].iter().zip(numbers(&truth["vif"])) {
        near("vif", column.vif.unwrap(), truth, 1e-10);
    }

    for step in file["path"].as_array().expect("a path") {
        let lambda = number(&step["lambda"]);
        if lambda == 0.0 {
            continue;
        }
        let result = answer(&nodes, &ridge(Parameter::Fixed(lambda), Scaling::Standardized));
        at_least(&format!("Hald, λ = {lambda}"), &values(&result), &decimals(&step["coef_dec"]), 9.0);
        near("rss", result.residuals.rss, number(&step["rss"]), 1e-10);
        let factors = &result.regularization.filter_factors;
        assert_eq!(factors.len(), 4);
        near("edf", factors.iter().sum(), number(&step["edf"]), 1e-10);
    }
}

fn chosen(result: &FitResult) -> f64 {
    result.regularization.lambda_star.expect("a parameter")
}

#[test]
fn hald_selectors() {
    let file = reference("ridge_hald");
    let (x, y) = hald(&file);
    let nodes = matrix(&with_constant(&x), &y);
    let of = |criterion| answer(&nodes, &ridge(Parameter::Criterion(criterion), Scaling::Standardized));
    // The unpenalised constant counts 1 in Σf.
    let gcv = chosen(&of(Criterion::Gcv));
    near("gcv", gcv, number(&file["exact"]["gcv_min_with_intercept_df_lambda"]), 1e-5);
    let curve = chosen(&of(Criterion::LCurve));
    near("l_curve", curve, number(&file["exact"]["lcurve_corner_lambda"]), 1e-4);
}

#[test]
fn hald_centred_only() {
    let file = reference("ridge_hald");
    let (x, y) = hald(&file);
    let m = y.len() as f64;
    let means: Vec<f64> = (0..4).map(|j| x.iter().map(|row| row[j]).sum::<f64>() / m).collect();
    let height = y.iter().sum::<f64>() / m;
    let centred: Vec<Vec<f64>> = x.iter().map(|row| row.iter().zip(&means).map(|(x, c)| x - c).collect()).collect();
    let nodes = matrix(&centred, &y.iter().map(|y| y - height).collect::<Vec<f64>>());
    for step in file["path_unscaled_centred"]["path"].as_array().expect("a path") {
        let lambda = number(&step["lambda"]);
        let result = answer(&nodes, &ridge(Parameter::Fixed(lambda), Scaling::None));
        at_least(&format!("centred, λ = {lambda}"), &values(&result), &decimals(&step["coef_dec"])[1..], 9.0);
    }
}

#[test]
fn hilbert() {
    let file = reference("ridge_hilbert10");
    let x: Vec<Vec<f64>> = (0..10).map(|i| (0..10).map(|j| 1.0 / f64::from(i + j + 1)).collect()).collect();
    let nodes = matrix(&x, &[1.0; 10]);
    for step in file["path"].as_array().expect("a path") {
        let alpha = number(&step["alpha"]);
        let result = answer(&nodes, &ridge(Parameter::Fixed(alpha), Scaling::None));
        at_least(&format!("Hilbert, α = {alpha:e}"), &values(&result), &decimals(&step["coef_dec"]), 9.0);
        near("residual", result.residuals.rss.sqrt(), number(&step["residual_norm"]), 1e-8);
        let norm = values(&result).iter().map(|a| a * a).sum::<f64>().sqrt();
        near("norm", norm, number(&step["solution_norm"]), 1e-9);
    }
}
