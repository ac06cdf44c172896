//! Factors and probabilities in messages.

use std::fmt;

/// A factor, in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Times(pub f64);

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            factor if factor < 1e4 => write!(f, "{factor:.2} times"),
            factor if factor.is_finite() => write!(f, "{factor:.1e} times"),
            _ => f.write_str("infinitely many times"),
        }
    }
}

/// A small probability; one that no double holds is not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Probability(pub f64);

impl fmt::Display for Probability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            p if p < 1e-300 => f.write_str("less than 1e-300"),
            p => write!(f, "{p:.1e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        result::{ResidualWarning, Warning},
        spec::Along,
    };

    #[test]
    fn no_probability_is_written_as_0() {
        let none = "less than 1e-300";
        for (p, said) in [(0.0, none), (1e-310, none), (2.34e-9, "2.3e-9"), (0.01, "1.0e-2")] {
            assert_eq!(Probability(p).to_string(), said);
            let (along, correlation, factor) = (Along::U, 0.9, 4.0);
            let residuals =
                ResidualWarning::CorrelatedResiduals { along: Some(along), model: Some(along), correlation, p, factor }
                    .into();
            let prior = Warning::PriorConflict { statistic: 9.5, p };
            for warning in [residuals, prior] {
                assert!(warning.to_string().contains(&format!("a probability of {said}")), "{warning}");
            }
        }
    }
}
