//! Standard errors with few nodes for each coefficient.
//!
//! Asymptotic standard errors are too small there: the n coefficients draw residuals towards 0, and
//! a robust estimator follows the n nodes that it fits best. κ = n/m; every factor tends to 1 with
//! κ, and least squares would have the factor 1.
//!
//! * M-estimators and Student's likelihood: `τ² = (1 − κ) s² Eψ²/(μ − κ)²`, ψ with slope 1 at 0
//!   and μ its mean slope. For ψ with slopes 0 and 1 that is the limit for m and n growing in
//!   proportion (El Karoui, Bean, Bickel, Lim and Yu, PNAS 110, 2013, which solves `1 − κ =
//!   E 1/(1 + cψ′)`); to first order in κ it has Huber's K of such a ψ. At μ ≤ κ the nodes that the
//!   weights leave do not determine the coefficients, and there are no standard errors.
//! * The rest (scale and weights vary with the nodes, a subset is the best of
//!   many) is measured: least factors with which intervals hold 0.92 to 0.98 with normal, Student's
//!   (ν = 3) and 10 % gross errors at 3.7 to 11 nodes a coefficient; `benches`, example
//!   `robust_coverage`.

use super::outcome::Measured;
use crate::spec::{Distribution, Estimator, Start};

/// Factor of the standard errors of M-estimators by their mean slope μ, as a share of that at 0; k
/// is the factor K that they have. `None` where there are no standard errors.
pub(super) fn by_slopes(mean: f64, k: f64, m: usize, n: usize) -> Option<f64> {
    let share = n as f64 / m as f64;
    (mean > share).then(|| (1.0 - share) * mean / ((mean - share) * k))
}

/// Measured factor for Student's likelihood with a given or estimated ν.
pub(super) fn of_student(nu: f64, m: usize, n: usize) -> f64 {
    1.0 + 2.0 * (n as f64 / m as f64) / (nu * nu)
}

/// Measured factor of the standard errors of the others; `subset` is the size of that of least
/// trimmed squares.
pub(super) fn measured(estimator: &Estimator, subset: Option<usize>, measured: &Measured) -> f64 {
    let (m, n) = (measured.sample.count() as f64, measured.linear.design.size() as f64);
    let share = n / m;
    match estimator {
        // a local solution near the best half of the nodes
        Estimator::M(asked) if asked.start == Start::LeastTrimmed => {
            (1.0 + 0.7 * share) * (1.0 + (5.0 * share).powi(3))
        }
        Estimator::M(_) | Estimator::Rank | Estimator::NormalScores => 1.0 + 0.7 * share,
        Estimator::L(_) => 1.0 + 0.3 * share,
        Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None }) => 1.0 + 0.4 * share,
        // the best subset of many, which leaves this share of the nodes out
        Estimator::LeastTrimmed { .. } => {
            let rest = 1.0 - subset.map_or(1.0, |size| size as f64 / m);
            1.0 + (10.0 * share * rest).powi(2)
        }
        _ => 1.0,
    }
}
