//! The tests' own oracle against the reference files: this justifies its use where it is the only
//! reference.

use crate::answers::{exact, exact_of};
use crate::folder::{decimals, number, numbers, reference, table};
use crate::oracle::big::{Big, digits};
use crate::oracle::design::{self, Basis};
use crate::oracle::matrix::{eigen, gram, rows, vector};
use crate::oracle::spectral::{Columns, Filter, Spectrum, brute_force_minimum};

#[track_caller]
fn agree(got: &[Big], truth: &[Big], wanted: f64) {
    assert_eq!(got.len(), truth.len());
    for (g, t) in got.iter().zip(truth) {
        let error = (g - t).log10() - t.log10();
        assert!(g == t || error < -wanted, "{g:?} and {t:?}: {error}");
    }
}

#[test]
fn exact_solutions_of_doubles() {
    for (name, degree) in [("nist_norris", 1), ("nist_pontius", 2), ("nist_wampler2", 5), ("nist_wampler4", 5)] {
        let file = reference(name);
        let (x, y) = (numbers(&file["data"]["x"]), numbers(&file["data"]["y"]));
        let own = exact_of(&design::curve(Basis::Monomial, degree, &x), &y);
        agree(&own, &decimals(&file["exact_for_f64_inputs"]["coef_dec"]), 28.0);
    }
    let file = reference("nist_longley");
    let column = |k: usize| numbers(&file["data"][format!("x{k}")]);
    let columns: Vec<Vec<f64>> = (1..=6).map(column).collect();
    let x: Vec<Vec<f64>> = (0..16).map(|k| [vec![1.0], columns.iter().map(|c| c[k]).collect()].concat()).collect();
    let own = exact(&x, &numbers(&file["data"]["y"]));
    agree(&own, &decimals(&file["exact_for_f64_inputs"]["coef_dec"]), 28.0);
}

#[test]
fn spectra() {
    for name in
        ["spectral_hilbert5", "spectral_vander01_deg10", "spectral_lauchli_2m20", "spectral_near_duplicate_1e-5"]
    {
        let file = reference(name);
        let own = file.get("eigenvalues_XtX_f64_design_dec").unwrap_or(&file["eigenvalues_XtX_exact_design_dec"]);
        let mut truth = decimals(own);
        truth.reverse();
        agree(&eigen(&gram(&rows(&table(&file["design"])))).0, &truth, 20.0);
    }
}

#[test]
fn ridge_path_and_its_selectors() {
    let file = reference("ridge_hald");
    let column = |k: usize| numbers(&file["data"][format!("x{k}")]);
    let columns: Vec<Vec<f64>> = (1..=4).map(column).collect();
    let x: Vec<Vec<f64>> = (0..13).map(|k| [vec![1.0], columns.iter().map(|c| c[k]).collect()].concat()).collect();
    let y = vector(&numbers(&file["data"]["y"]));
    let spectrum = Spectrum::new(&rows(&x), &y, None, Columns::Standardized(0));
    let sums = spectrum.sums();
    for step in file["path"].as_array().expect("a path") {
        let lambda = number(&step["lambda"]);
        let own = spectrum.coefficients(&sums.factors(Filter::Ridge, lambda));
        for (own, truth) in own.iter().zip(decimals(&step["coef_dec"])) {
            assert!(digits(own.to_f64(), &truth) > 11.0, "λ = {lambda}: {own:?} {truth:?}");
        }
        let near = |a: f64, b: &str| (a - number(&step[b])).abs() <= 1e-11 * number(&step[b]);
        assert!(near(sums.rss_at(Filter::Ridge, lambda), "rss"));
        // The file leaves 1/m out of its definition.
        assert!(near(sums.gcv(Filter::Ridge, lambda) / 13.0, "gcv_with_intercept_df"), "λ = {lambda}");
    }
    let [low, high] = [1e-8 * sums.lambda[0], 1e4 * sums.lambda[3]];
    let (gcv, _) = brute_force_minimum(low, high, |t| sums.gcv(Filter::Ridge, t));
    let truth = number(&file["exact"]["gcv_min_with_intercept_df_lambda"]);
    assert!((gcv / truth - 1.0).abs() < 1e-6, "{gcv} {truth}");
    let (corner, curvature) = brute_force_minimum(low, high, |t| -sums.curvature(Filter::Ridge, t));
    let truth = number(&file["exact"]["lcurve_corner_lambda"]);
    assert!((corner / truth - 1.0).abs() < 1e-6, "{corner} {truth}");
    assert!((-curvature / number(&file["exact"]["lcurve_max_curvature"]) - 1.0).abs() < 1e-9, "{curvature}");
}
