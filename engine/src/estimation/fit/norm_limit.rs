//! How well r is known where it is the norm of the estimate.

use super::conclude::Solved;
use crate::estimation::{
    regularized::Applied,
    result::{NormLimitSource, Warning},
};

impl Solved<'_> {
    /// Beside r = ‖Â‖ of a regularised fit, by the linear expansion of the norm: `‖Â‖ + t σ̂ (Σ
    /// aᵢ²/λᵢ)^½ / ‖Â‖` with t of one tail. In simulation it holds in 0.86 of the draws at worst
    /// where 0.95 is said, so it bounds nothing.
    pub(super) fn norm_limit(&self, applied: &mut Applied, warnings: &mut Vec<Warning>) {
        let estimated = applied.bias.coefficient_norm_limit_source == NormLimitSource::Estimate;
        // without regularisation there is no bias to bound
        if !estimated || applied.bounds.iter().all(|bound| *bound == 0.0) {
            return;
        }
        let Some(noise) = self.noise(self.spec.level) else { return };
        let (a, lambda) = (&self.spectrum.a, &self.spectrum.lambda);
        let told = || a.iter().zip(lambda).filter(|(_, lambda)| **lambda > 0.0);
        let norm = applied.bias.coefficient_norm_limit;
        let spread = told().map(|(a, lambda)| a * a / lambda).sum::<f64>().sqrt();
        let above = noise.one_sided() * noise.sigma * spread / norm;
        applied.bias.upper_confidence = Some(norm + above).filter(|limit| limit.is_finite());
        if let Some((&along, &least)) = told().next() {
            let error = noise.sigma / least.sqrt();
            if along.abs() < noise.quantile() * error {
                warnings.push(Warning::NormLimitIsEstimate { norm, along, error });
            }
        }
    }
}
