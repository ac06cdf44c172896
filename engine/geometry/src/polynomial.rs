//! Polynomial bases on one axis.
//!
//! Fits are computed in Chebyshev polynomials of the mapped abscissa, which stay well conditioned;
//! the caller's basis (raw monomials, or Chebyshev or Legendre polynomials on a domain) follows by
//! an upper triangular change of basis `T`, formed in double-double: column `j` holds the caller's
//! function `j` in the working Chebyshev polynomials, so that `X_caller = X_working · T`.

use nalgebra::DMatrix;

use super::Mapping;
use flankfit_numerics::{Dd, Real};

/// A family of polynomials on one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// `xʲ` of the raw abscissa.
    Monomial,
    /// `Tⱼ(τ)`, τ being the domain `[low, high]` mapped onto [-1, 1].
    Chebyshev {
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
    /// `Pⱼ(τ)` on the same map.
    Legendre {
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
}

/// `T₀(t) … T_d(t)` into `out` (length d + 1).
///
/// ```
/// use flankfit_geometry::polynomial::chebyshev_values;
///
/// // T₂ = 2t² − 1 and T₃ = 4t³ − 3t.
/// let mut values = [0.0; 4];
/// chebyshev_values(0.5, &mut values);
/// assert_eq!(values, [1.0, 0.5, -0.5, -1.0]);
/// ```
#[inline(always)]
pub fn chebyshev_values<T: Real>(t: T, out: &mut [T]) {
    for i in 0..out.len() {
        out[i] = match i {
            0 => T::of(1.0),
            1 => t,
            _ => (t + t).fma(out[i - 1], -out[i - 2]),
        };
    }
}

/// Derivatives by t of order `order` of `T₀(t) … T_d(t)` into `out` (length d + 1).
pub fn chebyshev_derivatives<T: Real>(order: usize, t: T, out: &mut [T]) {
    chebyshev_values(t, out);
    for d in 1..=order {
        // T⁽ᵈ⁾ⱼ₊₁ = 2t T⁽ᵈ⁾ⱼ + 2d T⁽ᵈ⁻¹⁾ⱼ − T⁽ᵈ⁾ⱼ₋₁; `out` holds order d − 1 ahead of j, order d
        // behind it
        let mut below = T::of(0.0);
        for j in 0..out.len() {
            let here = out[j];
            out[j] = match j {
                0 => T::of(0.0),
                1 => below.mul_f64(d as f64),
                _ => (t + t) * out[j - 1] + below.mul_f64(2.0 * d as f64) - out[j - 2],
            };
            below = here;
        }
    }
}

/// Values and first derivatives (by x) of a family at `x`.
pub fn values_and_derivatives(family: Family, x: f64, values: &mut [f64], derivatives: &mut [f64]) {
    let (t, slope) = match family {
        Family::Monomial => (x, 1.0),
        Family::Chebyshev { low, high } | Family::Legendre { low, high } => {
            if high > low {
                ((x - low - (high - x)) / (high - low), 2.0 / (high - low))
            } else {
                (0.0, 1.0)
            }
        }
    };
    for i in 0..values.len() {
        let (value, derivative) = match (family, i) {
            (_, 0) => (1.0, 0.0),
            (_, 1) => (t, 1.0),
            (Family::Monomial, _) => (t * values[i - 1], t * derivatives[i - 1] + values[i - 1]),
            (Family::Chebyshev { .. }, _) => (
                2.0 * t * values[i - 1] - values[i - 2],
                2.0 * (values[i - 1] + t * derivatives[i - 1]) - derivatives[i - 2],
            ),
            (Family::Legendre { .. }, _) => {
                let k = i as f64;
                (
                    ((2.0 * k - 1.0) * t * values[i - 1] - (k - 1.0) * values[i - 2]) / k,
                    ((2.0 * k - 1.0) * (values[i - 1] + t * derivatives[i - 1]) - (k - 1.0) * derivatives[i - 2]) / k,
                )
            }
        };
        values[i] = value;
        derivatives[i] = derivative;
    }
    for derivative in derivatives {
        *derivative *= slope;
    }
}

/// The change of basis `T` (upper triangular, `size × size`) from `family` to Chebyshev polynomials
/// of `working`.
pub fn change_of_basis(family: Family, working: Mapping, size: usize) -> DMatrix<Dd> {
    // τ = offset + gain · t
    let x_gain = Dd::ONE / working.scale;
    let (offset, gain) = match family {
        Family::Monomial => (Dd::from(working.center), x_gain),
        Family::Chebyshev { low, high } | Family::Legendre { low, high } => {
            if high > low {
                let width = Dd::diff(high, low);
                let shift = Dd::diff(working.center, low) - Dd::diff(high, working.center);
                (shift / width, (x_gain + x_gain) / width)
            } else {
                (Dd::diff(working.center, low), x_gain)
            }
        }
    };
    let mut t = DMatrix::from_element(size, size, Dd::ZERO);
    for j in 0..size {
        if j == 0 {
            t[(0, 0)] = Dd::ONE;
            continue;
        }
        // τ · (function j − 1), in Chebyshev polynomials
        let mut product = vec![Dd::ZERO; size + 1];
        for i in 0..j {
            let c = t[(i, j - 1)];
            product[i] += c * offset;
            let moved = c * gain;
            if i == 0 {
                product[1] += moved;
            } else {
                let half = moved.mul_f64(0.5);
                product[i + 1] += half;
                product[i - 1] += half;
            }
        }
        let k = j as f64;
        for i in 0..=j {
            let previous = if j >= 2 { t[(i, j - 2)] } else { Dd::ZERO };
            t[(i, j)] = match family {
                _ if j == 1 => product[i],
                Family::Monomial => product[i],
                Family::Chebyshev { .. } => product[i] + product[i] - previous,
                Family::Legendre { .. } => (product[i] * (2.0 * k - 1.0) - previous * (k - 1.0)) / k,
            };
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The caller's functions evaluated directly agree with their expansion in the working
    /// polynomials.
    #[test]
    fn change_of_basis_reproduces_the_functions() {
        let working = Mapping::over(30.3, 33.9);
        for family in
            [Family::Monomial, Family::Chebyshev { low: 29.0, high: 35.5 }, Family::Legendre { low: 30.0, high: 34.0 }]
        {
            let t = change_of_basis(family, working, 6);
            for x in [30.3, 31.7, 33.25] {
                let mut direct = [0.0; 6];
                let mut slopes = [0.0; 6];
                values_and_derivatives(family, x, &mut direct, &mut slopes);
                let mut chebyshev = [Dd::ZERO; 6];
                chebyshev_values(working.map::<Dd>(x), &mut chebyshev);
                for j in 0..6 {
                    let mut sum = Dd::ZERO;
                    for i in 0..6 {
                        sum += t[(i, j)] * chebyshev[i];
                    }
                    assert!((sum.to_f64() - direct[j]).abs() <= 1e-13 * direct[j].abs().max(1.0), "{family:?} {j}");
                }
            }
        }
    }

    #[test]
    fn derivatives_of_chebyshev_polynomials() {
        let t = 0.3;
        let mut out = [0.0; 5];
        chebyshev_derivatives(2, t, &mut out);
        // T₂″ = 4, T₃″ = 24t, T₄″ = 96t² − 16
        for (got, want) in out.iter().zip([0.0, 0.0, 4.0, 24.0 * t, 96.0 * t * t - 16.0]) {
            assert!((got - want).abs() < 1e-13, "{out:?}");
        }
        chebyshev_derivatives(3, t, &mut out);
        assert!((out[3] - 24.0).abs() < 1e-13 && (out[4] - 192.0 * t).abs() < 1e-12, "{out:?}");
        assert_eq!(out[..3], [0.0; 3]);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for family in
            [Family::Monomial, Family::Chebyshev { low: -1.0, high: 2.0 }, Family::Legendre { low: -1.0, high: 2.0 }]
        {
            let (x, h) = (0.7, 1e-6);
            let at = |x: f64| {
                let (mut v, mut d) = ([0.0; 6], [0.0; 6]);
                values_and_derivatives(family, x, &mut v, &mut d);
                (v, d)
            };
            for j in 0..6 {
                let difference = (at(x + h).0[j] - at(x - h).0[j]) / (2.0 * h);
                assert!((difference - at(x).1[j]).abs() < 1e-7, "{family:?} {j}");
            }
        }
    }
}
