//! The standard normal distribution.

use std::f64::consts::{PI, SQRT_2};

/// φ(z).
pub fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt()
}

/// P(Z > z).
///
/// ```
/// use flankfit_numerics::distribution::normal::upper_tail;
///
/// assert!((upper_tail(1.959_963_984_540_054) - 0.025).abs() < 1e-16);
/// ```
pub fn upper_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z / SQRT_2)
}

/// z with P(Z > z) = `tail`, 0 < tail < 1.
///
/// ```
/// use flankfit_numerics::distribution::normal::upper_quantile;
///
/// assert!((upper_quantile(0.025) - 1.959_963_984_540_054).abs() < 1e-14);
/// ```
pub fn upper_quantile(tail: f64) -> f64 {
    if tail > 0.5 {
        return -upper_quantile(1.0 - tail);
    }
    // Abramowitz and Stegun 26.2.23, right to 4.5e-4, and two steps of the third order
    let t = (-2.0 * libm::log(tail)).sqrt();
    let mut z =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    for _ in 0..2 {
        let step = (upper_tail(z) - tail) / density(z);
        z += step / (1.0 - 0.5 * z * step);
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values of mpmath with 40 digits.
    #[test]
    fn quantiles_to_the_last_digits() {
        for (tail, want) in [
            (0.5, 0.0),
            (0.4, 0.253_347_103_135_799_8),
            (0.05, 1.644_853_626_951_472_6),
            (0.005, 2.575_829_303_548_901),
            (1e-9, 5.997_807_015_007_686),
            (1e-100, 21.273_453_560_965_326),
            (0.975, -1.959_963_984_540_054),
        ] {
            let found = upper_quantile(tail);
            assert!((found - want).abs() <= 4e-15 * want.abs().max(0.1), "{tail}: {found} is not {want}");
        }
    }
}
