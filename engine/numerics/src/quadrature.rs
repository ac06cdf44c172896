//! Gauss–Legendre quadrature to double-double precision: exact for polynomials, so that penalties
//! are integrals and no approximations of them.

use super::dd::Dd;

/// Newton steps; each doubles the digits of a start that has a few.
const STEPS: usize = 8;

/// Nodes and weights on [-1, 1], exact for polynomials up to degree `2 points − 1`.
///
/// ```
/// use flankfit_numerics::quadrature::gauss_legendre;
///
/// // Two points integrate cubics: ∫ x² over [-1, 1] is 2/3, at ±1/√3.
/// let rule = gauss_legendre(2);
/// let integral: f64 = rule.iter().map(|(x, w)| w.to_f64() * x.to_f64() * x.to_f64()).sum();
/// assert!((integral - 2.0 / 3.0).abs() < 1e-15);
/// ```
pub fn gauss_legendre(points: usize) -> Vec<(Dd, Dd)> {
    let n = points as f64;
    (0..points)
        .map(|i| {
            // Tricomi's start, right to O(n⁻⁴)
            let angle = std::f64::consts::PI * (4.0 * i as f64 + 3.0) / (4.0 * n + 2.0);
            let mut x = Dd::from((1.0 - (n - 1.0) / (8.0 * n * n * n)) * angle.cos());
            let mut slope = Dd::ONE;
            for _ in 0..STEPS {
                let (value, derivative) = legendre(points, x);
                slope = derivative;
                let step = value / derivative;
                x -= step;
                if step.to_f64().abs() < 1e-31 {
                    break;
                }
            }
            let weight = (Dd::ONE + Dd::ONE) / ((Dd::ONE - x * x) * slope * slope);
            (x, weight)
        })
        .collect()
}

/// `P_n(x)` and its derivative, for n ≥ 1 and |x| < 1.
fn legendre(n: usize, x: Dd) -> (Dd, Dd) {
    let (mut before, mut here) = (Dd::ONE, x);
    for k in 2..=n {
        let k = k as f64;
        let next = (x * here * (2.0 * k - 1.0) - before * (k - 1.0)) / k;
        (before, here) = (here, next);
    }
    (here, (before - x * here) * (n as f64) / (Dd::ONE - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_integrated_exactly() {
        for points in [1usize, 2, 3, 7, 24] {
            let rule = gauss_legendre(points);
            for power in 0..2 * points as i32 {
                let sum = rule.iter().fold(Dd::ZERO, |sum, &(x, w)| sum + w * x.powi(power));
                let exact = if power % 2 == 0 { Dd::from(2.0) / f64::from(power + 1) } else { Dd::ZERO };
                assert!(
                    (sum - exact).abs().to_f64() < 1e-29,
                    "{points} points, power {power}: {:e}",
                    (sum - exact).to_f64()
                );
            }
        }
    }

    #[test]
    fn many_points_add_up_to_the_length() {
        let sum = gauss_legendre(600).iter().fold(Dd::ZERO, |sum, &(_, w)| sum + w);
        assert!((sum.to_f64() - 2.0).abs() < 1e-15);
    }
}
