//! Why there is no fit.

use std::fmt;

use super::fault::Faults;
use crate::fault;

/// Why no fit could be given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Something in the request is impossible (too few nodes, an unsorted axis, a domain that
    /// leaves nodes out).
    #[error("the fit is impossible as asked: {0}")]
    Invalid(Faults),
    /// Spectral regularisation divides by λ₁ (Eq. 39); with dependent columns λ₁ is 0.
    #[error("the columns are linearly dependent (rank {rank} of {columns}): {}", terms.join(", "))]
    RankDeficient {
        /// Numerically nonzero singular values.
        rank: usize,
        /// Columns of X.
        columns: usize,
        /// The terms that depend on each other.
        terms: Vec<String>,
    },
    /// An iteration did not end within its limit; nothing was returned rather than something
    /// unsure.
    #[error("{0}")]
    NotConverged(&'static str),
}

impl From<Faults> for FitError {
    fn from(faults: Faults) -> Self {
        FitError::Invalid(faults)
    }
}

/// Why something that is made by a fit was refused: by checks of its own, or by the fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused<F: fmt::Debug, R: fmt::Debug + fmt::Display> {
    /// Something in what was asked for is impossible.
    #[error(transparent)]
    Invalid(fault::Faults<F, R>),
    /// The fit was refused.
    #[error(transparent)]
    Fit(FitError),
}

impl<F: fmt::Debug, R: fmt::Debug + fmt::Display> From<fault::Faults<F, R>> for Refused<F, R> {
    fn from(faults: fault::Faults<F, R>) -> Self {
        Refused::Invalid(faults)
    }
}

impl<F: fmt::Debug, R: fmt::Debug + fmt::Display> From<FitError> for Refused<F, R> {
    fn from(error: FitError) -> Self {
        Refused::Fit(error)
    }
}
