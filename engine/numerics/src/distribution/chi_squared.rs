//! χ², by the regularised incomplete gamma function.

use crate::root::boundary;

/// P(χ² > x) of `freedom` degrees of freedom.
///
/// ```
/// use flankfit_numerics::distribution::chi_squared::upper_tail;
///
/// // With two degrees of freedom it is exponential.
/// assert!((upper_tail(6.0, 2.0) - (-3.0f64).exp()).abs() < 1e-16);
/// ```
pub fn upper_tail(x: f64, freedom: f64) -> f64 {
    let (a, x) = (0.5 * freedom, 0.5 * x);
    if x <= 0.0 {
        return 1.0;
    }
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 { 1.0 - front * series(a, x) } else { front * fraction(a, x) }
}

/// x with P(χ² > x) = `tail`, 0 < tail < 1: by bisection.
///
/// ```
/// use flankfit_numerics::distribution::chi_squared::upper_quantile;
///
/// assert!((upper_quantile(0.05, 1.0) - 3.841_458_820_694_124).abs() < 1e-12);
/// ```
pub fn upper_quantile(tail: f64, freedom: f64) -> f64 {
    let mut high = freedom.max(1.0);
    while upper_tail(high, freedom) > tail {
        high *= 2.0;
    }
    boundary([0.0, high], 0.0, |x| upper_tail(x, freedom) > tail)[1]
}

/// Σ xᵏ / (a (a + 1) … (a + k)).
fn series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
    for _ in 0..100_000 {
        k += 1.0;
        term *= x / k;
        sum += term;
        if term < sum * 1e-17 {
            break;
        }
    }
    sum
}

/// The continued fraction of Γ(a, x) eˣ x⁻ᵃ, by Lentz's method.
fn fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let away = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / TINY, 1.0 / away(b));
    let mut value = d;
    for k in 1..100_000 {
        let k = f64::from(k);
        let term = -k * (k - a);
        b += 2.0;
        d = 1.0 / away(term * d + b);
        c = away(b + term / c);
        let step = c * d;
        value *= step;
        if (step - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values of mpmath with 40 digits.
    #[test]
    fn tails_of_mpmath() {
        for (x, freedom, want) in [
            (3.841_458_820_694_124, 1.0, 0.05),
            (0.1, 1.0, 0.751_829_634_045_849_2),
            (30.0, 10.0, 8.566_412_107_753_004e-4),
            (5.0, 20.0, 0.999_722_647_905_379_1),
            (1200.0, 1000.0, 1.225_594_233_062_290_5e-5),
        ] {
            let found = upper_tail(x, freedom);
            assert!((found / want - 1.0).abs() < 1e-12, "{x} of {freedom}: {found} is not {want}");
        }
    }
}
