//! Reasons why there is no fit.

use flankfit_numerics::check::Faults;

/// Reason why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Something in the request is impossible (too few nodes, an unsorted axis, a domain that
    /// leaves nodes out).
    #[error("the requested fit is impossible: {0}")]
    Invalid(Faults),
    /// Numbers on the way, or figures of the answer, leave the range of double precision.
    #[error("the requested fit is impossible: {0}")]
    ExceedsDouble(Faults),
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
    #[error(transparent)]
    NotConverged(#[from] Unconverged),
}

/// Iteration that did not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unconverged {
    /// Singular values of scaled columns.
    #[error("the singular value decomposition did not converge: use fewer terms or another basis")]
    SingularValues,
    /// The decomposition of matrix and penalty.
    #[error("the decomposition of matrix and penalty did not converge: use another penalty or basis")]
    PenaltyPair,
    /// The iterative refinement of a surface's coefficients.
    #[error("corrections of the coefficients did not converge: use fewer spans, or regularise more")]
    Refinement,
    /// Knots placed by residuals.
    #[error("no knots were tried: give the knots, or allow more of them")]
    KnotPlacement,
    /// The simplex of least absolute deviations.
    #[error("the nodes determine no vertex of least absolute deviations: use fewer terms or another estimator")]
    AbsoluteDeviations,
    /// The simplex of the rank dispersion.
    #[error("pairs of nodes determine no vertex of the rank dispersion: use fewer terms or another estimator")]
    RankDispersion,
    /// Positions of nodes that are off.
    #[error(
        "the positions of the nodes did not converge: they are too uncertain for this model; use fewer terms, or \
            `nominal`"
    )]
    Positions,
    /// The registration of a measured flank.
    #[error("the registration diverged to tilts above 0.1 rad: free fewer motions, or regularise")]
    Registration,
    /// The quadratic surface of a flank.
    #[error("the fit has other terms than those of second order")]
    SecondOrder,
    /// Singular values of a sensitivity matrix.
    #[error("the singular values of the sensitivity matrix did not converge")]
    Sensitivity,
    /// Settings of a machine held at their limits.
    #[error("the settings at their limits did not settle within the rounds allowed")]
    Limits,
    /// The comparison of two corrections.
    #[error("the changes of the settings are too great to be compared")]
    Comparison,
}

impl Unconverged {
    /// Path to the part of the request to be changed, where it is one.
    pub fn path(self) -> Option<&'static str> {
        match self {
            Unconverged::SingularValues | Unconverged::SecondOrder | Unconverged::KnotPlacement => Some("model"),
            Unconverged::PenaltyPair | Unconverged::Refinement => Some("regularization"),
            Unconverged::AbsoluteDeviations | Unconverged::RankDispersion => Some("estimator"),
            Unconverged::Positions => Some("node_uncertainty"),
            Unconverged::Registration | Unconverged::Sensitivity | Unconverged::Limits | Unconverged::Comparison => {
                None
            }
        }
    }
}

impl FitError {
    /// Errors of the request, if it was refused for these.
    pub fn faults(&self) -> Option<&Faults> {
        match self {
            FitError::Invalid(faults) | FitError::ExceedsDouble(faults) => Some(faults),
            FitError::RankDeficient { .. } | FitError::NotConverged(_) => None,
        }
    }
}

impl From<Faults> for FitError {
    fn from(faults: Faults) -> Self {
        FitError::Invalid(faults)
    }
}
