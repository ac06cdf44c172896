//! The incomplete beta function, which Fisher's F and Student's t are made of, and ratios of gamma
//! functions.

use std::f64::consts::PI;

/// I_x(p, q) for p, q > 0. `y` is 1 − x, kept separately so that both keep their digits.
pub(super) fn incomplete_beta(x: f64, y: f64, p: f64, q: f64) -> f64 {
    if x <= 0.0 || y <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // the continued fraction converges quickly on this side of the mean
    if x > (p + 1.0) / (p + q + 2.0) {
        return 1.0 - incomplete_beta(y, x, q, p);
    }
    density_term(x, y, p, q) * fraction(x, p, q) / p
}

/// `x^p y^q / B(p, q)` with x + y = 1, as Loader computes binomial probabilities: no difference of
/// large logarithms, whatever p and q.
fn density_term(x: f64, y: f64, p: f64, q: f64) -> f64 {
    let n = p + q;
    let exponent = stirling_error(n) - stirling_error(p) - stirling_error(q) - deviance(p, n * x) - deviance(q, n * y);
    (p * q / (2.0 * PI * n)).sqrt() * libm::exp(exponent)
}

/// ln Γ(z + 1) less Stirling's formula √(2πz) (z/e)^z.
fn stirling_error(z: f64) -> f64 {
    const FROM: f64 = 15.0;
    if z < FROM {
        return libm::lgamma(z + 1.0) - (z + 0.5) * libm::log(z) + z - 0.5 * libm::log(2.0 * PI);
    }
    let square = 1.0 / (z * z);
    (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square * (1.0 / 1680.0 - square * (1.0 / 1188.0)))))
        / z
}

/// `x ln(x / m) + m − x`, without cancellation where x is near m.
fn deviance(x: f64, m: f64) -> f64 {
    if (x - m).abs() >= 0.1 * (x + m) {
        return x * libm::log(x / m) + m - x;
    }
    let v = (x - m) / (x + m);
    let mut sum = (x - m) * v;
    let mut term = 2.0 * x * v;
    for j in 1..1000 {
        term *= v * v;
        let next = sum + term / f64::from(2 * j + 1);
        if next == sum {
            break;
        }
        sum = next;
    }
    sum
}

/// The continued fraction of I_x(p, q), by Lentz's method.
pub(super) fn fraction(x: f64, p: f64, q: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let away = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut c, mut d) = (1.0, 1.0 / away(1.0 - (p + q) * x / (p + 1.0)));
    let mut value = d;
    for m in 1..20_000 {
        let m = f64::from(m);
        let even = m * (q - m) * x / ((p + 2.0 * m - 1.0) * (p + 2.0 * m));
        let odd = -(p + m) * (p + q + m) * x / ((p + 2.0 * m) * (p + 2.0 * m + 1.0));
        let mut step = 1.0;
        for term in [even, odd] {
            d = 1.0 / away(1.0 + term * d);
            c = away(1.0 + term / c);
            step = c * d;
            value *= step;
        }
        if (step - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

/// Γ(x + ½) / Γ(x) for x > 0.
pub(super) fn half_step(x: f64) -> f64 {
    // the series of the logarithm has odd powers only; below 10 by Γ(x + 1) = x Γ(x)
    let (mut x, mut product) = (x, 1.0);
    while x < 10.0 {
        product *= x / (x + 0.5);
        x += 1.0;
    }
    let square = 1.0 / (x * x);
    let series = (1.0 / 8.0
        - square
            * (1.0 / 192.0
                - square
                    * (1.0 / 640.0
                        - square * (17.0 / 14336.0 - square * (31.0 / 18432.0 - square * (691.0 / 180_224.0))))))
        / x;
    product * x.sqrt() * libm::exp(-series)
}
