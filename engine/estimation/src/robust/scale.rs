//! Scale of residuals, in the unit of the heights (times √weight, where nodes carry weights).
//!
//! * MAD about 0, divided by 0.6745 or by Φ⁻¹(0.75) to be σ at normal errors;
//! * Huber's proposal 2 (Huber 1981, section 7.7): the s of `Σ min(r², (k₂s)²) = (m − n) γ s²` with
//!   `γ = E min(Z², k₂²)`, Z standard normal;
//! * fixed by the caller.

use super::normal;
use crate::spec::ScaleRule;
use flankfit_numerics::cancel;

/// Φ⁻¹(0.75).
pub(super) const NORMAL_QUARTILE: f64 = 0.674_489_750_196_081_7;

/// Median of |r|; of an even number the mean of the middle two.
pub(super) fn median_abs(residuals: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    median(&mut sizes)
}

/// Median; orders `values` partly. 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    let odd = values.len() % 2 == 1;
    let (below, upper, _) = values.select_nth_unstable_by(middle, cancel::comparing(f64::total_cmp));
    if odd { *upper } else { 0.5 * (*upper + below.iter().copied().fold(f64::NEG_INFINITY, f64::max)) }
}

/// `E min(Z², k²)` of a standard normal Z: θ + k²(1 − θ) − 2kφ(k), θ = 2Φ(k) − 1.
pub(super) fn proposal2_gamma(k: f64) -> f64 {
    let theta = 1.0 - 2.0 * normal::upper_tail(k);
    theta + k * k * (1.0 - theta) - 2.0 * k * normal::density(k)
}

/// The scale of `residuals` by `rule`; `last` is that of the iteration before, `n` the number of
/// coefficients.
///
/// Proposal 2 takes one step from `last` (from the MAD at first), so that its fixed point is
/// reached together with that of the coefficients.
pub(super) fn scale(rule: ScaleRule, residuals: &[f64], last: Option<f64>, n: usize) -> f64 {
    match rule {
        ScaleRule::Mad06745 => median_abs(residuals) / 0.6745,
        ScaleRule::Mad => median_abs(residuals) / NORMAL_QUARTILE,
        ScaleRule::Fixed(value) => value,
        ScaleRule::Proposal2 { k2 } => {
            let free = residuals.len().saturating_sub(n);
            if free == 0 {
                return 0.0;
            }
            let largest = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
            let start = last.unwrap_or_else(|| match median_abs(residuals) / NORMAL_QUARTILE {
                // most residuals are 0: any scale above the root leads to it
                0.0 => largest,
                mad => mad,
            });
            let limit = k2 * start;
            let sum: f64 = residuals.iter().map(|r| r.abs().min(limit)).map(|x| x * x).sum();
            (sum / (free as f64 * proposal2_gamma(k2))).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_counts() {
        assert_eq!(median_abs(&[-3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median_abs(&[4.0, -3.0, 1.0, 2.0]), 2.5);
        assert_eq!(median_abs(&[]), 0.0);
    }

    #[test]
    fn gamma_tends_to_the_whole_variance() {
        assert!((proposal2_gamma(1.345) - 0.7101645).abs() < 1e-6);
        assert!((proposal2_gamma(9.0) - 1.0).abs() < 1e-12);
    }
}
