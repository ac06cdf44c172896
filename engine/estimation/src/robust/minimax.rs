//! Huber's minimax estimator (Eq. 10): which k is best against a share ε of gross errors.
//!
//! Of all distributions (1 − ε)Φ + εH, H symmetric and otherwise unknown, the one that is hardest
//! to estimate in has the density (1 − ε)/√(2π)·exp(−ρ_k(u)), normal in the middle and exponential
//! outside ±k, with `2φ(k)/k − 2Φ(−k) = ε/(1 − ε)`. Huber's ψ_k is its maximum-likelihood
//! estimator, and no estimator has a smaller greatest asymptotic variance over the class (Huber
//! 1964; 1981, section 4.5). That variance is `1/((1 − ε)(1 − 2Φ(−k)))`, in squares of the scale.
//!
//! ε that is not known is estimated by maximum likelihood among these least favourable
//! distributions, the residuals in scales being given.

use crate::{
    result::MinimaxReport,
    spec::{Contamination, Loss},
};
use flankfit_numerics::{cancel::Asking, distribution::normal, root::root};

/// k between which ε is looked for: ε = 0.91 and 5.6e-8.
const RANGE: [f64; 2] = [0.05, 5.0];
/// Places at which the likelihood is looked at before the best one is refined.
const PLACES: usize = 48;

/// ∫ exp(−ρ_k).
fn mass(k: f64) -> f64 {
    (2.0 * std::f64::consts::PI).sqrt() * (1.0 - 2.0 * normal::upper_tail(k)) + 2.0 / k * libm::exp(-0.5 * k * k)
}

/// ε of which k is the best.
fn epsilon(k: f64) -> f64 {
    1.0 - (2.0 * std::f64::consts::PI).sqrt() / mass(k)
}

/// The greatest variance of Huber's estimator over the class, in squares of the scale.
fn variance(k: f64) -> f64 {
    1.0 / ((1.0 - epsilon(k)) * (1.0 - 2.0 * normal::upper_tail(k)))
}

/// k of the least favourable distribution in which residuals `u` (in scales) are likeliest.
pub(super) fn likeliest_k(u: &[f64]) -> f64 {
    let count = u.len() as f64;
    let mean = |f: &dyn Fn(f64) -> f64| u.iter().asking(50).map(|u| f(u.abs())).sum::<f64>() / count;
    let cost = |k: f64| mean(&|u| Loss::Huber { k }.rho(u)) + libm::log(mass(k));
    // derivative: Σ(|u| − k)₊/m against ∫(|u| − k)₊ e^−ρ/∫e^−ρ
    let slope = |k: f64| mean(&|u| (u - k).max(0.0)) - 2.0 * libm::exp(-0.5 * k * k) / (k * k * mass(k));
    let place = |i: usize| RANGE[0] * libm::pow(RANGE[1] / RANGE[0], i as f64 / (PLACES - 1) as f64);
    let best = (0..PLACES).min_by(|&a, &b| cost(place(a)).total_cmp(&cost(place(b)))).unwrap_or(0);
    let (low, high) = (place(best.saturating_sub(1)), place((best + 1).min(PLACES - 1)));
    let ends = [(low, slope(low)), (high, slope(high))];
    // a cost that falls to the end of the range has no root there
    root(ends, |k| 2.0 * f64::EPSILON * k, slope).unwrap_or_else(|| place(best))
}

/// Report on the loss.
pub(super) fn report(contamination: Contamination, loss: Loss) -> Option<MinimaxReport> {
    let Loss::Huber { k } = loss else { return None };
    let (share, estimated) = match contamination {
        Contamination::Share(share) => (share, false),
        Contamination::Estimated => (epsilon(k), true),
    };
    Some(MinimaxReport { contamination: share, estimated, k, variance: variance(k) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::minimax_k;

    /// Huber (1981), exhibit 4.3 (k and the variance to what is printed there), and mpmath 1.3 with
    /// 30 digits: `findroot(lambda k: 2*npdf(k)/k - 2*ncdf(-k) - e/(1-e), 1)`.
    #[test]
    fn k_and_variance_are_those_of_the_table() {
        for (share, k, greatest) in [
            (0.001, 2.6328799010108295, 1.0095482686511459),
            (0.01, 1.9451113746544708, 1.0652394837317007),
            (0.05, 1.398377124675959, 1.2561233758727577),
            (0.1, 1.140171145835742, 1.4898544756719656),
            (0.25, 0.7657750662336879, 2.397262984098376),
            (0.5, 0.4363265637936516, 5.927678963000261),
            (0.8, 0.16165750674585444, 38.93340201000239),
        ] {
            let found = minimax_k(share);
            assert!((found / k - 1.0).abs() < 1e-13, "{share}: {found}");
            assert!((variance(found) / greatest - 1.0).abs() < 1e-13, "{share}");
            assert!((epsilon(found) / share - 1.0).abs() < 1e-11, "{share}");
        }
    }

    /// Quantiles of the least favourable distribution itself are likeliest at its own k.
    #[test]
    fn the_least_favourable_distribution_is_found_again() {
        for k in [0.6, 1.0, 1.5, 2.0] {
            let (middle, count) = (0.5 * (1.0 - epsilon(k)) * (1.0 - 2.0 * normal::upper_tail(k)), 20_000);
            let u: Vec<f64> = (0..count)
                .map(|i| {
                    // P(0 < u < x), inverted
                    let p = 0.5 * (f64::from(i) + 0.5) / f64::from(count);
                    if p < middle {
                        normal::upper_quantile(0.5 - p / (1.0 - epsilon(k)))
                    } else {
                        let rest = (0.5 - p) * mass(k);
                        (0.5 * k * k - libm::log(rest * k)) / k
                    }
                })
                .collect();
            let found = likeliest_k(&u);
            assert!((found - k).abs() < 0.01, "{k}: {found}");
        }
        // nothing above any k: no gross errors
        assert_eq!(likeliest_k(&[0.1; 50]), RANGE[1]);
    }
}
