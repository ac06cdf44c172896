//! Quantiles of Fisher's F, by the regularised incomplete beta function.
//!
//! With a and b degrees of freedom `P(F > f) = I_x(b/2, a/2)`, `x = b / (b + a f)`. Student's t of
//! b degrees of freedom is the square root of F with 1 and b.

use super::root::boundary;

/// f with `P(F > f) = tail` for F of `a` and `b` degrees of freedom, both at least 1 and 0 < tail <
/// 1: by bisection.
///
/// ```
/// use flankfit_engine::numerics::fisher::upper_quantile;
///
/// // Of tables: F(0.05; 2, 10) = 4.103.
/// assert!((upper_quantile(0.05, 2.0, 10.0) - 4.103).abs() < 5e-4);
/// ```
pub fn upper_quantile(tail: f64, a: f64, b: f64) -> f64 {
    // I grows with x, and f falls with it
    let [low, high] = boundary([0.0, 1.0], 0.0, |x| incomplete_beta(x, 0.5 * b, 0.5 * a) < tail);
    let x = 0.5 * (low + high);
    b * (1.0 - x) / (a * x)
}

/// |t| that Student's t of `freedom` degrees of freedom exceeds with the probability `tail`, on
/// either side.
///
/// ```
/// use flankfit_engine::numerics::fisher::student_two_sided;
///
/// // Of tables: t(0.975; 10) = 2.228.
/// assert!((student_two_sided(0.05, 10.0) - 2.228).abs() < 5e-4);
/// ```
pub fn student_two_sided(tail: f64, freedom: f64) -> f64 {
    upper_quantile(tail, 1.0, freedom).sqrt()
}

/// I_x(p, q).
fn incomplete_beta(x: f64, p: f64, q: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // the continued fraction converges quickly on this side of the mean
    if x > (p + 1.0) / (p + q + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, q, p);
    }
    let front = ln_gamma(p + q) - ln_gamma(p) - ln_gamma(q) + p * x.ln() + q * (-x).ln_1p();
    front.exp() * fraction(x, p, q) / p
}

/// The continued fraction of I_x(p, q), by Lentz's method.
fn fraction(x: f64, p: f64, q: f64) -> f64 {
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

/// ln Γ(x) for x > 0: Stirling's series from 10 on, below it by Γ(x + 1) = x Γ(x).
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0);
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    let square = 1.0 / (x * x);
    let series = (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series - product.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        for (tail, a, b, want) in [
            (0.05, 3.0, 10.0, 3.7083),
            (0.001, 5.0, 2.0, 999.30),
            (0.001, 10.0, 10.0, 8.7539),
            (0.01, 40.0, 60.0, 1.9360),
        ] {
            let found = upper_quantile(tail, a, b);
            assert!((found / want - 1.0).abs() < 1e-4, "{found} is not {want}");
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
