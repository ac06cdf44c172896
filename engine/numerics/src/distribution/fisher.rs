//! Quantiles of Fisher's F, by the regularised incomplete beta function.
//!
//! With a and b degrees of freedom `P(F > f) = I_x(b/2, a/2)`, `x = b / (b + a f)`. Student's t of
//! b degrees of freedom is the square root of F with 1 and b.

use super::{Student, beta::incomplete_beta};
use crate::root::boundary;

/// P(F > f) of `a` and `b` degrees of freedom.
///
/// ```
/// use flankfit_numerics::distribution::fisher::upper_tail;
///
/// assert!((upper_tail(4.103, 2.0, 10.0) - 0.05).abs() < 1e-5);
/// ```
pub fn upper_tail(f: f64, a: f64, b: f64) -> f64 {
    let whole = b + a * f;
    incomplete_beta(b / whole, a * f / whole, 0.5 * b, 0.5 * a)
}

/// f with `P(F > f) = tail` for F of `a` and `b` degrees of freedom, both at least 1 and 0 < tail <
/// 1: by bisection.
///
/// ```
/// use flankfit_numerics::distribution::fisher::upper_quantile;
///
/// // Of tables: F(0.05; 2, 10) = 4.103.
/// assert!((upper_quantile(0.05, 2.0, 10.0) - 4.103).abs() < 5e-4);
/// ```
pub fn upper_quantile(tail: f64, a: f64, b: f64) -> f64 {
    // I grows with x, and f falls with it
    let [low, high] = boundary([0.0, 1.0], 0.0, |x| incomplete_beta(x, 1.0 - x, 0.5 * b, 0.5 * a) < tail);
    let x = 0.5 * (low + high);
    b * (1.0 - x) / (a * x)
}

/// |t| that Student's t of `freedom` degrees of freedom exceeds with the probability `tail`, on
/// either side.
///
/// ```
/// use flankfit_numerics::distribution::fisher::student_two_sided;
///
/// // Of tables: t(0.975; 10) = 2.228.
/// assert!((student_two_sided(0.05, 10.0) - 2.228).abs() < 5e-4);
/// ```
pub fn student_two_sided(tail: f64, freedom: f64) -> f64 {
    Student::new(freedom).upper_quantile(0.5 * tail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        for (tail, a, b, want) in [
            (0.05, 3.0, 10.0, 3.708_264_819_046_844_4),
            (0.001, 10.0, 10.0, 8.753_866_275_447_301),
            (0.01, 40.0, 60.0, 1.936_018_471_584_351),
            (0.05, 9.0, 36.0, 2.152_607_472_458_077_7),
            (0.05, 9.0, 1e6, 1.879_895_723_805_639_5),
        ] {
            let found = upper_quantile(tail, a, b);
            assert!((found / want - 1.0).abs() < 1e-9, "{found} is not {want}");
            assert!((upper_tail(want, a, b) / tail - 1.0).abs() < 1e-10);
        }
        for (freedom, want) in [(2.0, 31.599), (5.0, 6.8688), (30.0, 3.6460), (1e6, 3.290_54)] {
            let found = student_two_sided(0.001, freedom);
            assert!((found / want - 1.0).abs() < 2e-5, "{found} is not {want}");
        }
        // many nodes: F tends to χ² over its degrees of freedom, 0.999 quantile of 100,000
        let many = upper_quantile(0.001, 1e5, 1e9);
        assert!((many - 1.013_87).abs() < 2e-4, "{many}");
    }
}
