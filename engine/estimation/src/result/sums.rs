//! Sums over the fitted curve or surface.

use super::{interval::Interval, term::Coefficient};

/// A weighted sum of heights of the fitted function, with the members of a coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedSum {
    /// Estimate.
    pub value: f64,
    /// Standard error as [`Coefficient::std_error`]; `None` without degrees of freedom.
    pub std_error: Option<f64>,
    /// Standard error like [`Coefficient::conditional_std_error`].
    pub conditional_std_error: Option<f64>,
    /// Most by which regularisation can have moved it.
    pub bias_bound: f64,
    /// Without regularisation.
    pub least_squares: f64,
    /// `None` where the noise is not known.
    pub interval: Option<Interval>,
}

impl WeightedSum {
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = [self.value, self.bias_bound, self.least_squares];
        numbers.into_iter().chain(self.std_error).chain(self.conditional_std_error).all(f64::is_finite)
            && self.interval.is_none_or(|interval| interval.is_finite())
    }
}

impl From<&Coefficient> for WeightedSum {
    fn from(coefficient: &Coefficient) -> Self {
        WeightedSum {
            value: coefficient.value,
            std_error: coefficient.std_error,
            conditional_std_error: coefficient.conditional_std_error,
            bias_bound: coefficient.bias_bound,
            least_squares: coefficient.least_squares,
            interval: coefficient.interval,
        }
    }
}
