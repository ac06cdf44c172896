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
//!   weights leave do not determine the coefficients, and near it hardly: with a factor above
//!   [`MOST`] there are no standard errors.
//! * The rest (scale and weights vary with the nodes, a subset is the best of many) is measured:
//!   least factors with which intervals hold 0.92 to 0.98 with normal, Student's (ν = 3) and 10 %
//!   gross errors at 3.7 to 11 nodes a coefficient; `benches`, example `robust_coverage`.

use super::outcome::{Measured, Outcome, Slopes};
use crate::spec::{Distribution, Estimator, Start};

/// Greatest factor by theory.
const MOST: f64 = 10.0;

/// Factor of the standard errors; `None` where there are none.
pub(super) fn widening(estimator: &Estimator, outcome: &Outcome, measured: &Measured) -> Option<f64> {
    let (m, n) = (measured.sample.count() as f64, measured.linear.design.size() as f64);
    let share = n / m;
    let shape = outcome.likelihood.as_ref().and_then(|report| report.shape);
    let factor = match estimator {
        // a local solution near the best half of the nodes
        Estimator::M(asked) if asked.start == Start::LeastTrimmed => {
            (1.0 + 0.7 * share) * (1.0 + (5.0 * share).powi(3))
        }
        Estimator::M(_) | Estimator::Rank | Estimator::NormalScores => 1.0 + 0.7 * share,
        Estimator::L(_) => 1.0 + 0.3 * share,
        Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None }) => 1.0 + 0.4 * share,
        // an exact fit has no ν, and no standard errors
        Estimator::Likelihood(Distribution::Student { .. }) => shape.map_or(1.0, |nu| 1.0 + 2.0 * share / (nu * nu)),
        // the best subset of many, which leaves this share of the nodes out
        Estimator::LeastTrimmed { .. } => {
            let rest = 1.0 - outcome.subset_size.map_or(1.0, |size| size as f64 / m);
            1.0 + (10.0 * share * rest).powi(2)
        }
        _ => 1.0,
    };
    let Some(Slopes { mean, k }) = outcome.slopes else { return Some(factor) };
    // ψ of Student's likelihood has the slope (ν + 1)/ν at 0
    let mean = shape.map_or(mean, |nu| mean * nu / (nu + 1.0));
    Some(factor * by_slopes(mean, k, share)?)
}

/// Factor by theory, for a mean slope μ as a share of that at 0; k is the factor K that the
/// standard errors have.
fn by_slopes(mean: f64, k: f64, share: f64) -> Option<f64> {
    let factor = (1.0 - share) * mean / ((mean - share) * k);
    (mean > share && factor <= MOST).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (1 − κ)μ/(μ − κ) = 10 at μ = 10κ/(9 + κ).
    #[test]
    fn weights_that_hardly_determine_the_coefficients_have_no_factor() {
        let share: f64 = 0.25;
        let edge = 10.0 * share / (9.0 + share);
        assert_eq!(by_slopes(1.0, 1.0, share), Some(1.0));
        assert!(by_slopes(1.0001 * edge, 1.0, share).is_some_and(|factor| (9.9..=10.0).contains(&factor)));
        assert_eq!([0.9999 * edge, share, 0.1, -0.2].map(|mean| by_slopes(mean, 1.0, share)), [None; 4]);
    }
}
