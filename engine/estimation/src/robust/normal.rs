//! The standard normal distribution: density, upper tail, quantile.

use flankfit_numerics::root::boundary;

/// Limit below which the tail follows from a power series, and above from a continued fraction.
const SERIES: f64 = 2.5;

/// φ(x).
pub(super) fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

/// 1 − Φ(x), to nearly full precision for x ≥ 0.
pub(super) fn upper_tail(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 - upper_tail(-x);
    }
    if x < SERIES {
        // Φ(x) − 1/2 = φ(x) (x + x³/3 + x⁵/15 + …)
        let (mut term, mut sum, mut odd) = (x, x, 1.0);
        while term > 1e-18 * sum {
            odd += 2.0;
            term *= x * x / odd;
            sum += term;
        }
        return 0.5 - density(x) * sum;
    }
    // Mills' ratio, x + 1/(x + 2/(x + …)), from far out inwards
    let mut ratio = x;
    for i in (1..200).rev() {
        ratio = x + f64::from(i) / ratio;
    }
    density(x) / ratio
}

/// Φ⁻¹(p) for 0 < p < 1, by bisection; ±∞ at the ends.
pub(super) fn quantile(p: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if p >= 1.0 {
        return f64::INFINITY;
    }
    let [low, high] = boundary([-40.0, 40.0], 0.0, |x| upper_tail(x) > 1.0 - p);
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_the_tables() {
        for (x, tail) in [
            (0.0, 0.5),
            (1.0, 0.158_655_253_931_457_05),
            (2.5, 0.006_209_665_325_776_132),
            (6.0, 9.865_876_450_376_946e-10),
        ] {
            assert!((upper_tail(x) / tail - 1.0).abs() < 1e-13, "{x}");
            assert!((upper_tail(-x) - (1.0 - tail)).abs() < 1e-15);
        }
        assert!((quantile(0.75) - super::super::scale::NORMAL_QUARTILE).abs() < 1e-14);
    }
}
