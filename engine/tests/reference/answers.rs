//! Shorthands for posting reference problems, and the judgement of `numerics.correct_digits`.

use crate::oracle::big::{Big, digits, worst_digits};
use crate::oracle::design::{self, Basis};
use crate::oracle::matrix::{Rows, least_squares, rows, vector};
use crate::oracle::random::Random;
use flankfit_engine::estimation::spec::{Degree, FitSpec, Model, PolynomialBasis, Regularization, Terms};
use flankfit_engine::estimation::{FitResult, Nodes, fit};

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
    result.coefficients.iter().map(|c| c.error_given_lambda().expect("a standard error")).collect()
}

/// Exact coefficients of the doubles of a measurement matrix.
pub fn exact(x: &[Vec<f64>], y: &[f64]) -> Vec<Big> {
    least_squares(&rows(x), &vector(y)).coefficients
}

/// Exact coefficients of columns in the oracle's numbers.
pub fn exact_of(x: &Rows, y: &[f64]) -> Vec<Big> {
    least_squares(x, &vector(y)).coefficients
}

/// Digits that the posted doubles leave undetermined when they are themselves roundings of
/// something: how far the exact solution moves when every number that is not a short binary
/// fraction is moved by up to one unit in its last place.
pub fn data_floor(exact: &[Big], solve: impl Fn(&mut dyn FnMut(f64) -> f64) -> Vec<Big>) -> f64 {
    let mut random = Random::new(11);
    let mut floor = f64::INFINITY;
    for _ in 0..3 {
        let moved = solve(&mut |value: f64| {
            let short = value == 0.0 || value.to_bits().trailing_zeros() >= 16;
            let step = if short { 0 } else { random.below(3) as i64 - 1 };
            f64::from_bits((value.to_bits() as i64 + step) as u64)
        });
        for (moved, exact) in moved.iter().zip(exact) {
            floor = floor.min(exact.log10() - (moved - exact).log10());
        }
    }
    floor
}

/// The floor of a curve in raw monomials.
pub fn curve_floor(exact: &[Big], degree: usize, x: &[f64], y: &[f64]) -> f64 {
    data_floor(exact, |round| {
        let x: Vec<f64> = x.iter().map(|v| round(*v)).collect();
        let y: Vec<f64> = y.iter().map(|v| round(*v)).collect();
        exact_of(&design::curve(Basis::Monomial, degree, &x), &y)
    })
}

/// The floor of a measurement matrix.
pub fn matrix_floor(coefficients: &[Big], x: &[Vec<f64>], y: &[f64]) -> f64 {
    data_floor(coefficients, |round| {
        let x: Vec<Vec<f64>> = x.iter().map(|row| row.iter().map(|v| round(*v)).collect()).collect();
        let y: Vec<f64> = y.iter().map(|v| round(*v)).collect();
        exact(&x, &y)
    })
}

/// `numerics.correct_digits` must not promise more than there is, nor be so shy that nobody can use
/// it: at most five digits below what is reached of the doubles, or below what the data determine,
/// where that is less (`floor`). Coefficients that are 0 (but for what the oracle's own rounding
/// leaves) have no relative digits and do not count.
#[track_caller]
pub fn judge_digits(name: &str, result: &FitResult, exact: &[Big], floor: f64) {
    let largest = exact.iter().map(Big::log10).fold(f64::NEG_INFINITY, f64::max);
    let counted = || result.coefficients.iter().zip(exact).filter(|(_, e)| e.log10() > largest - 60.0);
    let reached = counted().map(|(c, e)| digits(c.least_squares, e)).fold(f64::INFINITY, f64::min);
    let claimed = result.numerics.correct_digits;
    let arithmetic = result.numerics.arithmetic;
    println!("{name}: {reached:.2} digits reached, {floor:.2} in the data, {claimed:.2} claimed ({arithmetic:?})");
    assert!((0.0..=16.0).contains(&claimed), "{name}: {claimed} digits");
    // An exact hit shows no more than the 16 digits of a double.
    assert!(claimed <= reached.min(15.95) + 0.3, "{name}: claims {claimed:.2} digits, has {reached:.2}");
    if counted().count() == exact.len() {
        let least = reached.min(floor).min(15.0) - 5.0;
        assert!(claimed >= least, "{name}: claims {claimed:.2} digits, has {reached:.2}, the data {floor:.2}");
    }
}

#[track_caller]
pub fn at_least(what: &str, got: &[f64], truth: &[Big], wanted: f64) {
    let reached = worst_digits(got, truth);
    println!("{what}: {reached:.2} digits (wanted {wanted})");
    assert!(reached >= wanted, "{what}: {reached:.2} digits, {wanted} wanted\n{got:?}\n{truth:?}");
}
