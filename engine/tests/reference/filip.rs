//! Sets like the hardest of the NIST collection, made here: 82 nodes on [-9, -3], degree 10,
//! cond(X) about 1.8e15, where the best packages keep 8 digits and double precision determines 13
//! to 14. Needs no reference folder.

use crate::answers::{
    answer, at_least, curve, curve_floor, exact_of, judge_digits, monomials, plain, std_errors, values,
};
use crate::oracle::design::{self, Basis};
use crate::oracle::matrix::{least_squares, vector};
use crate::oracle::random::Random;

/// A rational bump like a spectrometer's, on abscissae given to three decimals, with noise rounded
/// to four.
fn nodes(seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut random = Random::new(seed);
    let x: Vec<f64> = (0..82)
        .map(|i| ((-9.0 + 6.0 * f64::from(i) / 81.0 + 0.01 * random.between(-1.0, 1.0)) * 1e3).round() / 1e3)
        .map(|x: f64| x.clamp(-9.0, -3.0))
        .collect();
    let y = x.iter().map(|x| ((0.85 + 0.07 * (x + 6.0).sin() + 0.003 * random.normal()) * 1e4).round() / 1e4).collect();
    (x, y)
}

#[test]
fn ten_powers_of_raw_abscissae() {
    for seed in 0..6 {
        let (x, y) = nodes(seed);
        let truth = exact_of(&design::curve(Basis::Monomial, 10, &x), &y);
        let result = answer(&curve(&x, &y), &plain(monomials(10)));
        at_least(&format!("degree 10, seed {seed}"), &values(&result), &truth, 13.0);
        judge_digits(&format!("degree 10, seed {seed}"), &result, &truth, curve_floor(&truth, 10, &x, &y));

        let all = least_squares(&design::curve(Basis::Monomial, 10, &x), &vector(&y));
        let variance = &all.rss / &crate::oracle::big::Big::from(82 - 11);
        let errors: Vec<_> = (0..11).map(|j| (&variance * &all.covariance[j][j]).sqrt()).collect();
        at_least("standard errors", &std_errors(&result), &errors, 8.0);
        at_least("rss", &[result.residuals.rss], &[all.rss], 10.0);
        assert_eq!(result.spectrum.rank, 11);
    }
}

#[test]
fn harder_and_harder() {
    // Raw powers far from 0: every degree adds two decades of condition.
    let mut random = Random::new(77);
    let x: Vec<f64> = (0..60).map(|i| 30.0 + 4.0 * f64::from(i) / 59.0).collect();
    let y: Vec<f64> = x.iter().map(|x| 0.01 * (x - 32.0).powi(2) + 1e-3 * random.normal()).collect();
    for degree in 1..=9 {
        let truth = exact_of(&design::curve(Basis::Monomial, degree, &x), &y);
        let result = answer(&curve(&x, &y), &plain(monomials(degree)));
        at_least(&format!("degree {degree} on [30, 34]"), &values(&result), &truth, 11.0);
        let floor = curve_floor(&truth, degree, &x, &y);
        judge_digits(&format!("degree {degree} on [30, 34]"), &result, &truth, floor);
        assert_eq!(result.spectrum.rank, degree + 1);
    }
}
