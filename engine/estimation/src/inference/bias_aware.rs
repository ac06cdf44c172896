//! The shortest interval about a filtered estimate of a linear form `ℓᵀA` that holds for every A
//! with ‖A‖ ≤ r (Armstrong and Kolesár).
//!
//! Along the eigenvectors `ℓᵀA = c + Σ pᵢaᵢ`, c a constant that no filter acts on. The estimate is
//! `c + Σ fᵢpᵢaᵢ`; it has standard error `s = (s₀² + σ²Σ pᵢ²fᵢ²/λᵢ)^½` and a bias of at most
//! `b = r (Σ pᵢ²(1 − fᵢ)²)^½`, both attained. Of all filters `fᵢ = λᵢ/(λᵢ + k)` give the least s at
//! each b, so k is all there is to find. Along it `db² = 2r²k S dk` and `ds² = −2σ² S dk` with the
//! same S, so the half-width `h = s q(b/s)` is least where
//!
//! ```text
//! k = (σ/r)² · u (q(u)/q'(u) − u),  u = b/s
//! ```
//!
//! which is about (σ/r)² for u → 0 and grows with u from there on (at low levels after a fall by
//! half). Nothing in it depends on the heights but σ̂; what that costs in coverage is in the last
//! column of the table of docs/explanation/intervals.md, next to nothing.

use super::{
    noise::Noise,
    quantile::{half_width, with_slope},
};
use flankfit_numerics::root::root;

/// A linear form of the coefficients along the eigenvectors of the scaled columns.
#[derive(Clone, Copy, Debug)]
pub struct LinearForm<'a> {
    /// pᵢ.
    pub along: &'a [f64],
    /// λᵢ; 0 where the nodes say nothing.
    pub lambda: &'a [f64],
    /// aᵢ of least squares; 0 where λᵢ is.
    pub a: &'a [f64],
    /// c: the share of coefficients that no filter acts on.
    pub constant: f64,
    /// s₀²/σ²: the variance of c.
    pub constant_variance: f64,
}

/// An interval `value ± half_width`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasAware {
    /// k; infinite where r alone says more than the nodes.
    pub k: f64,
    /// The filtered estimate of the form.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
    /// The bias that it may have.
    pub bias_bound: f64,
    /// Half the width of the interval.
    pub half_width: f64,
}

/// k is looked for up to this multiple of the largest eigenvalue; farther the filter leaves
/// nothing.
const FARTHEST: f64 = 1e8;
/// … and from this multiple of (σ/r)² on.
const NEAREST: f64 = 1e-3;

/// The shortest interval for `form` with ‖A‖ ≤ `r`.
pub fn bias_aware(form: &LinearForm, r: f64, noise: &Noise) -> BiasAware {
    let least = (noise.sigma / r).powi(2);
    let most = FARTHEST * form.lambda.iter().fold(0.0f64, |most, &l| most.max(l));
    let (one_sided, two_sided) = (noise.student.upper_quantile(noise.miss), noise.quantile());
    let beyond = |ln_k: f64| {
        let k = ln_k.exp();
        let (error, bias) = form.spread(k, r, noise.sigma);
        let u = bias / error;
        let (q, slope) = with_slope(noise, u, one_sided, two_sided);
        // u → 0: q/q' → (ν + q²)/((ν + 1) u)
        let ratio = if u > 0.0 && slope > 0.0 { u * (q / slope - u) } else { 1.0 };
        ln_k - (least * ratio).ln()
    };
    let found = if !(least > 0.0) || !least.is_finite() || !(NEAREST * least < most) {
        None
    } else {
        let (low, high) = ((NEAREST * least).ln(), most.ln());
        root([(low, beyond(low)), (high, beyond(high))], |_| 1e-6, beyond)
    };
    let k = match found {
        Some(ln_k) => ln_k.exp(),
        // noise above all that r allows, or none at all
        None if least > 0.0 => f64::INFINITY,
        None => 0.0,
    };
    form.interval(k, r, noise)
}

impl LinearForm<'_> {
    /// fᵢ and 1 − fᵢ.
    fn filter(lambda: f64, k: f64) -> (f64, f64) {
        if k == f64::INFINITY {
            return (0.0, 1.0);
        }
        if k == 0.0 {
            return if lambda > 0.0 { (1.0, 0.0) } else { (0.0, 1.0) };
        }
        (lambda / (lambda + k), k / (lambda + k))
    }

    /// Standard error and bias bound at k.
    fn spread(&self, k: f64, r: f64, sigma: f64) -> (f64, f64) {
        let (mut variance, mut bias) = (self.constant_variance, 0.0);
        for (&p, &lambda) in self.along.iter().zip(self.lambda) {
            let (f, removed) = Self::filter(lambda, k);
            if lambda > 0.0 {
                variance += (p * f).powi(2) / lambda;
            }
            bias += (p * removed).powi(2);
        }
        (sigma * variance.sqrt(), r * bias.sqrt())
    }

    fn interval(&self, k: f64, r: f64, noise: &Noise) -> BiasAware {
        let (std_error, bias_bound) = self.spread(k, r, noise.sigma);
        let terms = self.along.iter().zip(self.lambda).zip(self.a);
        let value = terms.fold(self.constant, |sum, ((&p, &lambda), &a)| sum + p * Self::filter(lambda, k).0 * a);
        BiasAware { k, value, std_error, bias_bound, half_width: half_width(noise, std_error, bias_bound) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn form<'a>(along: &'a [f64], lambda: &'a [f64], a: &'a [f64]) -> LinearForm<'a> {
        LinearForm { along, lambda, a, constant: 0.0, constant_variance: 0.0 }
    }

    #[test]
    fn one_well_determined_direction_is_least_squares() {
        let noise = Noise::estimated(0.1, 36.0, 0.95);
        let found = bias_aware(&form(&[1.0], &[1e4], &[2.0]), 1e6, &noise);
        assert!((found.value - 2.0).abs() < 1e-9 && found.bias_bound < 1e-4 * found.std_error);
        assert!((found.half_width / (noise.quantile() * 0.1 / 100.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn where_the_nodes_say_nothing_the_limit_does() {
        let noise = Noise::estimated(1.0, 10.0, 0.95);
        let found = bias_aware(&form(&[1.0, 0.0], &[1e-20, 1.0], &[1e7, 0.3]), 2.0, &noise);
        assert!(found.value.abs() < 1e-6 && (found.half_width - 2.0).abs() < 1e-6, "{found:?}");
        let blind = bias_aware(&form(&[0.6, 0.8], &[0.0, 1e9], &[0.0, 0.5]), 2.0, &noise);
        assert!((blind.value - 0.4).abs() < 1e-3 && (blind.half_width - 1.2).abs() < 1e-3, "{blind:?}");
    }

    proptest! {
        /// No k of a fine grid does better; never worse than least squares or r alone.
        #[test]
        fn no_other_k_is_shorter(
            along in prop::collection::vec(-1.0..1.0f64, 1..7),
            logs in prop::collection::vec(-6.0..4.0f64, 7),
            (r, freedom, level) in (-2.0..3.0f64, 3.0..200.0f64, 0.6..0.999f64),
            constant_variance in prop::option::of(0.0..1.0f64),
        ) {
            let lambda: Vec<f64> = logs[..along.len()].iter().map(|l| 10f64.powf(*l)).collect();
            let zeros = vec![0.0; along.len()];
            let noise = Noise::estimated(0.7, freedom, level);
            let form = LinearForm {
                along: &along, lambda: &lambda, a: &zeros, constant: 0.0,
                constant_variance: constant_variance.unwrap_or(0.0),
            };
            let r = 10f64.powf(r);
            let found = bias_aware(&form, r, &noise).half_width;
            for step in -800..800 {
                let other = form.interval(10f64.powf(f64::from(step) / 50.0), r, &noise).half_width;
                prop_assert!(found <= other * (1.0 + 1e-9), "{found} {other}");
            }
            for k in [0.0, f64::INFINITY] {
                prop_assert!(found <= form.interval(k, r, &noise).half_width * (1.0 + 1e-9));
            }
        }
    }
}
