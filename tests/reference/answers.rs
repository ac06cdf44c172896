//! Shorthands for posting reference problems, and the judgement of `numerics.correct_digits`.

use crate::oracle::big::{Big, digits, worst_digits};
use crate::oracle::matrix::{Rows, least_squares, rows, vector};
use flankfit::estimation::spec::{Degree, FitSpec, Model, PolynomialBasis, Regularization, Terms};
use flankfit::estimation::{FitResult, Nodes, fit};

pub fn answer(nodes: &Nodes, spec: &FitSpec) -> FitResult {
    fit(nodes, spec).unwrap_or_else(|error| panic!("no fit: {error}"))
}

pub fn plain(model: Model) -> FitSpec {
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

pub fn monomials(degree: usize) -> Model {
    let (degree, basis) = (Degree::Both(degree), PolynomialBasis::Monomial);
    Model::Polynomial { degree, basis, terms: Terms::Tensor }
}

pub fn curve(x: &[f64], y: &[f64]) -> Nodes {
    Nodes::curve(x.to_vec(), y.to_vec(), None).expect("checked nodes")
}

pub fn matrix(x: &[Vec<f64>], y: &[f64]) -> Nodes {
    Nodes::matrix(x.concat(), x[0].len(), y.to_vec(), None, None).expect("checked nodes")
}

pub fn values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.value).collect()
}

pub fn std_errors(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.std_error.expect("a standard error")).collect()
}

/// Exact coefficients of the doubles of a measurement matrix.
pub fn exact(x: &[Vec<f64>], y: &[f64]) -> Vec<Big> {
    least_squares(&rows(x), &vector(y)).coefficients
}

/// Exact coefficients of columns in the oracle's numbers.
pub fn exact_of(x: &Rows, y: &[f64]) -> Vec<Big> {
    least_squares(x, &vector(y)).coefficients
}

/// `numerics.correct_digits` must not promise more than there is, nor be so shy that nobody can use it.
/// Coefficients that are 0 (but for what the oracle's own rounding leaves) have no relative digits and do not count.
#[track_caller]
pub fn judge_digits(name: &str, result: &FitResult, exact: &[Big]) {
    let largest = exact.iter().map(Big::log10).fold(f64::NEG_INFINITY, f64::max);
    let counted = result.coefficients.iter().zip(exact).filter(|(_, e)| e.log10() > largest - 60.0);
    let reached = counted.map(|(c, e)| digits(c.least_squares, e)).fold(f64::INFINITY, f64::min);
    let claimed = result.numerics.correct_digits;
    println!("{name}: {reached:.2} digits reached, {claimed:.2} claimed ({:?})", result.numerics.arithmetic);
    assert!(claimed.is_finite() && claimed >= 0.0, "{name}: {claimed} digits");
    // An exact hit shows no more than the 16 digits of a double.
    assert!(claimed <= reached.min(15.95) + 0.3, "{name}: claims {claimed:.2} digits, has {reached:.2}");
    if reached < 15.0 {
        assert!(claimed >= reached - 5.0, "{name}: claims {claimed:.2} digits, has {reached:.2}");
    }
}

#[track_caller]
pub fn at_least(what: &str, got: &[f64], truth: &[Big], wanted: f64) {
    let reached = worst_digits(got, truth);
    println!("{what}: {reached:.2} digits (wanted {wanted})");
    assert!(reached >= wanted, "{what}: {reached:.2} digits, {wanted} wanted\n{got:?}\n{truth:?}");
}
