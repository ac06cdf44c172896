//! The NIST StRD linear sets, posted as doubles the way a client would: raw monomials, or the
//! matrix itself.

use crate::answers::{
    answer, at_least, curve, curve_floor, exact, exact_of, judge_digits, matrix, matrix_floor, monomials, plain,
    std_errors, values,
};
use crate::folder::{decimals, number, numbers, reference};
use crate::oracle::big::{Big, digits, worst_digits};
use crate::oracle::design::{self, Basis};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::spec::{FitSpec, Model};
use serde_json::Value;

/// Compares a fit with the certified values: `wanted` digits of the worst coefficient.
fn certified(file: &Value, nodes: &Nodes, model: Model, (exact, floor): (&[Big], f64), wanted: f64) {
    let name = file["name"].as_str().expect("a name");
    let certified = &file["certified"];
    let coefficients = decimals(&certified["coef_text"]);
    let result = answer(nodes, &plain(model.clone()));
    at_least(name, &values(&result), &coefficients, wanted);
    // The doubles as posted determine more than the printed digits show.
    at_least(&format!("{name}, of its doubles"), &values(&result), exact, wanted);
    judge_digits(name, &result, exact, floor);

    let heights = numbers(&file["data"]["y"]).iter().fold(0.0f64, |s, y| s.max(y.abs()));
    let spread = Big::parse(certified["residual_sd_text"].as_str().expect("a text"));
    let residual = &result.residuals;
    if spread.is_zero() {
        assert!(std_errors(&result).iter().all(|s| *s <= 1e-12 * heights), "{name}: {:?}", std_errors(&result));
        assert!(residual.sigma.unwrap() <= 1e-12 * heights, "{name}: {:?}", residual.sigma);
        assert!(residual.rss <= (1e-12 * heights).powi(2) * residual.count as f64);
        assert!((residual.r_squared.unwrap() - 1.0).abs() < 1e-14);
    } else {
        at_least(&format!("{name}, standard errors"), &std_errors(&result), &decimals(&certified["se_text"]), 8.0);
        assert!(digits(residual.sigma.unwrap(), &spread) >= 10.0, "{name}: σ {:?}", residual.sigma);
        let rss = Big::parse(certified["anova"]["residual_ss_text"].as_str().expect("a text"));
        assert!(digits(residual.rss, &rss) >= 10.0, "{name}: rss {}", residual.rss);
        let r_squared = number(&certified["r2"]);
        assert!((residual.r_squared.unwrap() - r_squared).abs() < 2e-15, "{name}: r² {:?}", residual.r_squared);
    }
    assert_eq!(residual.degrees_of_freedom as u64, file["df"].as_u64().expect("degrees of freedom"));

    // The default regularisation leaves the least-squares figures as they are.
    let default = answer(nodes, &FitSpec::new(model));
    for (a, b) in default.coefficients.iter().zip(&result.coefficients) {
        assert_eq!(a.least_squares, b.value, "{name}: {}", a.term);
        assert_eq!(a.least_squares_std_error, b.std_error, "{name}: {}", a.term);
    }
    assert_eq!(default.residuals.least_squares_rss, residual.rss, "{name}");
}

/// Checks a curve, and the same powers as a matrix (they are exact doubles, or nearly).
fn polynomial(name: &str, degree: usize, wanted: f64) {
    let file = reference(name);
    let (x, y) = (numbers(&file["data"]["x"]), numbers(&file["data"]["y"]));
    let truth = exact_of(&design::curve(Basis::Monomial, degree, &x), &y);
    let floor = curve_floor(&truth, degree, &x, &y);
    certified(&file, &curve(&x, &y), monomials(degree), (&truth, floor), wanted);

    let powers: Vec<Vec<f64>> = x.iter().map(|x| (0..=degree as i32).map(|p| x.powi(p)).collect()).collect();
    let result = answer(&matrix(&powers, &y), &plain(Model::Linear));
    let truth = exact(&powers, &y);
    let reached = worst_digits(&values(&result), &truth);
    println!("{name} as a matrix: {reached:.2} digits");
    assert!(reached >= 13.0, "{name} as a matrix: {reached:.2} digits");
    judge_digits(&format!("{name} as a matrix"), &result, &truth, matrix_floor(&truth, &powers, &y));
}

#[test]
fn norris() {
    polynomial("nist_norris", 1, 13.5);
}

#[test]
fn pontius() {
    polynomial("nist_pontius", 2, 13.0);
}

#[test]
fn wampler1() {
    polynomial("nist_wampler1", 5, 14.5);
}

#[test]
fn wampler2() {
    polynomial("nist_wampler2", 5, 12.7);
}

#[test]
fn wampler4() {
    polynomial("nist_wampler4", 5, 14.5);
}

#[test]
fn noint1() {
    let file = reference("nist_noint1");
    let x: Vec<Vec<f64>> = numbers(&file["data"]["x"]).iter().map(|x| vec![*x]).collect();
    let y = numbers(&file["data"]["y"]);
    let truth = exact(&x, &y);
    certified(&file, &matrix(&x, &y), Model::Linear, (&truth, matrix_floor(&truth, &x, &y)), 14.2);
}

#[test]
fn longley() {
    let file = reference("nist_longley");
    let columns: Vec<Vec<f64>> = (1..=6).map(|j| numbers(&file["data"][format!("x{j}")])).collect();
    let y = numbers(&file["data"]["y"]);
    let x: Vec<Vec<f64>> =
        (0..y.len()).map(|k| std::iter::once(1.0).chain(columns.iter().map(|c| c[k])).collect()).collect();
    let truth = exact(&x, &y);
    certified(&file, &matrix(&x, &y), Model::Linear, (&truth, matrix_floor(&truth, &x, &y)), 14.0);
}
