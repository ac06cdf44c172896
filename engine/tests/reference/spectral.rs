//! Small eigenvalues, where forming XᵀX in doubles has no digit left.

use crate::answers::{
    answer, at_least, curve, curve_floor, exact, exact_of, judge_digits, matrix, matrix_floor, monomials, plain,
};
use crate::folder::{decimals, number, numbers, reference, table};
use crate::oracle::big::{Big, digits};
use crate::oracle::design::{self, Basis};
use crate::oracle::matrix::{eigen, gram, rows};
use flankfit_engine::estimation::spec::{FitSpec, Model, Parameter, Regularization, Scaling};
use flankfit_engine::estimation::{FitResult, Nodes};
use serde_json::Value;

fn unscaled(nodes: &Nodes, model: Model) -> FitResult {
    answer(nodes, &FitSpec { scaling: Scaling::None, ..plain(model) })
}

/// Reverses reference eigenvalues, which are largest first.
fn ascending(mut values: Vec<Big>) -> Vec<Big> {
    values.reverse();
    values
}

#[track_caller]
fn check(name: &str, result: &FitResult, truth: &[Big]) {
    at_least(name, &result.spectrum.eigenvalues, truth, 9.0);
    let condition = &truth[truth.len() - 1] / &truth[0];
    let log = result.spectrum.log10_condition.expect("a condition");
    assert!((log - condition.log10()).abs() < 1e-8, "{name}: log10 condition {log}");
    assert!(digits(result.spectrum.condition.expect("a condition"), &condition) > 9.0, "{name}");
    let determinant: f64 = truth.iter().map(Big::log10).sum();
    let log = result.spectrum.log10_determinant.expect("a determinant");
    assert!((log - determinant).abs() < 1e-8, "{name}: log10 determinant {log}");
    assert_eq!(result.spectrum.rank, truth.len());
}

/// The design as a matrix; where it is not exact in doubles, against the spectrum of the doubles.
fn design_matrix(name: &str) -> Value {
    let file = reference(name);
    let x = table(&file["design"]);
    let own = file.get("eigenvalues_XtX_f64_design_dec").unwrap_or(&file["eigenvalues_XtX_exact_design_dec"]);
    let y = numbers(&file["y"]);
    let result = unscaled(&matrix(&x, &y), Model::Linear);
    check(name, &result, &ascending(decimals(own)));
    // The reference and the tests' own oracle agree, so that either may be trusted elsewhere.
    check(&format!("{name}, by the oracle"), &result, &eigen(&gram(&rows(&x))).0);
    let truth = exact(&x, &y);
    judge_digits(name, &result, &truth, matrix_floor(&truth, &x, &y));
    if file["design_entries_exact_in_f64"].as_bool() == Some(true) {
        ridge_solutions(name, &file, &matrix(&x, &y), Model::Linear);
    }
    file
}

/// The file's `tikhonov_…` solutions: ridge without scaling, k relative to the largest eigenvalue.
fn ridge_solutions(name: &str, file: &Value, nodes: &Nodes, model: Model) {
    let largest = number(&file["eigenvalues_XtX_exact_design"][0]);
    for (key, relative) in [("tikhonov_1e-4", 1e-4), ("tikhonov_1e-8", 1e-8), ("tikhonov_1e-12", 1e-12)] {
        let solution = &file["regularised_solutions"][key];
        let k = Parameter::Fixed(relative * largest);
        let regularization = Regularization::Ridge { parameter: k };
        let spec = FitSpec { scaling: Scaling::None, regularization, ..FitSpec::new(model.clone()) };
        let result = answer(nodes, &spec);
        let norm = number(&solution["norm"]);
        for (c, truth) in result.coefficients.iter().zip(decimals(&solution["coef_dec"])) {
            let error = (&Big::from(c.value) - &truth).to_f64().abs();
            assert!(error <= 1e-9 * norm, "{name} {key}: {} is off by {error:e} of {norm:e}", c.term);
        }
        let rss = number(&solution["rss"]);
        assert!((result.residuals.rss - rss).abs() <= 1e-9 * rss, "{name} {key}: rss {}", result.residuals.rss);
    }
}

/// The same spectrum from a curve in raw monomials.
fn vandermonde(name: &str, degree: usize) {
    let file = design_matrix(name);
    let x: Vec<f64> = table(&file["design"]).iter().map(|row| row[1]).collect();
    let y = numbers(&file["y"]);
    let result = unscaled(&curve(&x, &y), monomials(degree));
    let truth = if file["design_entries_exact_in_f64"].as_bool() == Some(true) {
        ascending(decimals(&file["eigenvalues_XtX_exact_design_dec"]))
    } else {
        // The powers of the abscissae as doubles, which no file lists.
        eigen(&gram(&design::curve(Basis::Monomial, degree, &x))).0
    };
    check(&format!("{name}, as a curve"), &result, &truth);
    let truth = exact_of(&design::curve(Basis::Monomial, degree, &x), &y);
    judge_digits(name, &result, &truth, curve_floor(&truth, degree, &x, &y));
    if file["design_entries_exact_in_f64"].as_bool() == Some(true) {
        ridge_solutions(name, &file, &curve(&x, &y), monomials(degree));
    }
}

#[test]
fn hilbert() {
    design_matrix("spectral_hilbert5");
}

#[test]
fn lauchli() {
    design_matrix("spectral_lauchli_2m20");
}

#[test]
fn nearly_duplicate_columns() {
    design_matrix("spectral_near_duplicate_1e-5");
}

#[test]
fn vandermonde_on_the_unit_interval() {
    vandermonde("spectral_vander01_deg5", 5);
    vandermonde("spectral_vander01_deg10", 10);
}

#[test]
fn vandermonde_in_millimetres() {
    vandermonde("spectral_vander30_40mm_deg3", 3);
    vandermonde("spectral_vander30_40mm_scaled_deg3", 3);
}

#[test]
fn designs_of_the_nist_sets() {
    for (name, degree) in
        [("nist_norris", 1), ("nist_pontius", 2), ("nist_wampler1", 5), ("nist_wampler2", 5), ("nist_wampler4", 5)]
    {
        let file = reference(name);
        let result = unscaled(&curve(&numbers(&file["data"]["x"]), &numbers(&file["data"]["y"])), monomials(degree));
        let spectrum = &file["spectrum_raw_design"];
        // Beyond 1e20 nothing is promised, and Pontius (2e26) is met all the same.
        check(name, &result, &ascending(decimals(&spectrum["eigenvalues_XtX_dec"])));
    }
}

#[test]
fn hard_matrices_made_here() {
    // Hilbert 7 and 8, Vandermonde 12, nearly equal columns: cond(XᵀX) up to 1e20, no better basis
    // to flee to.
    let hilbert = |n: usize| -> Vec<Vec<f64>> {
        (0..n + 3).map(|i| (0..n).map(|j| 1.0 / (i + j + 1) as f64).collect()).collect()
    };
    let vandermonde = |degree: i32| -> Vec<Vec<f64>> {
        (0..40).map(|k| (0..=degree).map(|p| (f64::from(k) / 39.0).powi(p)).collect()).collect()
    };
    let near = |gap: f64| -> Vec<Vec<f64>> {
        (0..17)
            .map(|k| {
                let t = f64::from(k - 8) / 8.0;
                vec![1.0, t, t + gap * t * t]
            })
            .collect()
    };
    let cases = [
        ("Hilbert 5", hilbert(5)),
        ("Hilbert 7", hilbert(7)),
        ("Vandermonde 8", vandermonde(8)),
        ("Vandermonde 12", vandermonde(12)),
        ("near 1e-6", near(1e-6)),
        ("near 1e-8", near(1e-8)),
        ("near 1e-9", near(1e-9)),
    ];
    for (name, x) in cases {
        let (truth, _) = eigen(&gram(&rows(&x)));
        let condition = truth[truth.len() - 1].log10() - truth[0].log10();
        assert!(condition <= 20.5, "{name}: 1e{condition}");
        let y: Vec<f64> = (0..x.len()).map(|k| (k as f64 * 0.7).sin()).collect();
        let result = unscaled(&matrix(&x, &y), Model::Linear);
        check(&format!("{name} (1e{condition:.1})"), &result, &truth);
        let truth = exact(&x, &y);
        judge_digits(name, &result, &truth, matrix_floor(&truth, &x, &y));
    }
}
