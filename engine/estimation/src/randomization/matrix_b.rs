//! The regularising matrix as noise: size of B (Eq. 40) relative to the columns it is added to.
//!
//! Section 6.3 reads the columns of B as "supplementary, regularizing noise", and `k =
//! σ_noise/σ_signal` on the axes of Figs. 4 and 5. For `B = Σ cᵢ X Vᵢ Vᵢᵀ` column j has the length
//! `‖B_j‖² = Σ cᵢ² λᵢ V_ji²`, so that its noise-to-signal level is `√(‖B_j‖²/m)/σ_j`, σ_j the
//! deviation of column j of X. The level of B is the root mean square of those of all columns that
//! vary; noise of level k on every such column has level k by the same definition.
//!
//! The level rises with λ*, so that every k up to that of λ* = λₙ belongs to one λ*: B of level k
//! is compared with a random change of level k.

use super::references::Base;
use crate::selection::Rule;
use flankfit_numerics::root::root;

impl Base {
    /// σ_B/σ_X at λ*; `None` where no column varies, or for a rule without B.
    pub(super) fn noise_to_signal(&self, rule: Rule, lambda_star: f64) -> Option<f64> {
        let share: Vec<f64> = (0..self.lambda().len())
            .map(|i| {
                let lambda = self.lambda()[i];
                Some(rule.coefficient(i, lambda, lambda_star)?.powi(2) * lambda / self.rows as f64)
            })
            .collect::<Option<_>>()?;
        let varying = || self.deviation.iter().enumerate().filter(|(_, deviation)| **deviation > 0.0);
        let squares = varying().map(|(j, deviation)| {
            let column = share.iter().enumerate().map(|(i, share)| share * self.spectrum.v[(j, i)].powi(2));
            column.sum::<f64>() / (deviation * deviation)
        });
        let level = (squares.sum::<f64>() / varying().count() as f64).sqrt();
        level.is_finite().then_some(level)
    }

    /// λ* of the B whose level is `level`; `None` where no λ* up to λₙ has it.
    pub(super) fn lambda_star_of_level(&self, rule: Rule, level: f64) -> Option<f64> {
        let (low, high) = (self.lambda()[0], *self.lambda().last()?);
        let (from, to) = (libm::log(low), libm::log(high));
        if !(from < to && from.is_finite()) {
            return None;
        }
        let beyond = |x: f64| self.noise_to_signal(rule, libm::exp(x)).map_or(f64::NAN, |found| found - level);
        let ends = [(from, -level), (to, self.noise_to_signal(rule, high)? - level)];
        root(ends, |x| 4.0 * f64::EPSILON * x.abs(), beyond).map(|x| libm::exp(x).clamp(low, high))
    }
}
