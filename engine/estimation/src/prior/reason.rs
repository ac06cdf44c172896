//! Errors in a prior.

use flankfit_numerics::fault::words::{Shown, counted, entries};

/// Why a prior is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PriorReason {
    /// Iterations where there is no job that has them.
    #[error("earlier iterations are those of a job, and this request has none: give mean and spread")]
    NoJob,
    /// A regularisation beside a prior.
    #[error("a prior excludes regularisation: take `none`")]
    FilterOnTop,
    /// An estimator other than least squares.
    #[error("a prior is for least squares, whose errors it is weighed against")]
    LeastSquaresOnly,
    /// Standardised columns.
    #[error("a prior is of all coefficients, the constant too, which standardised columns exclude")]
    Standardized,
    /// A limit of the norm beside a prior.
    #[error("the prior says how large the coefficients are: a limit of their norm cannot be given as well")]
    NormLimit,
    /// A wrong number of entries.
    #[error(
        "{}; the model has {}, in the order of the answer", entries(*.given),
        counted(*.coefficients, "coefficient", "coefficients")
    )]
    Count {
        /// Entries.
        given: usize,
        /// Coefficients of the model.
        coefficients: usize,
    },
    /// A row of a triangle with a wrong number of entries.
    #[error("row {row} of a lower triangle has {}; this one has {given}", counted(*.row + 1, "number", "numbers"))]
    Row {
        /// Which, from 0.
        row: usize,
        /// Its entries.
        given: usize,
    },
    /// A standard deviation that is not one.
    #[error("{} is not a standard deviation: above 0", Shown(*.0))]
    StdError(f64),
    /// A covariance matrix that is not one.
    #[error("the covariance matrix is not positive definite: no coefficients have it")]
    NotPositive,
    /// A comparison that doubles do not hold.
    #[error("the prior and these nodes are so far apart, or one is so much surer, that doubles do not hold both")]
    BeyondDouble,
    /// Nodes that leave coefficients free.
    #[error("the nodes themselves do not determine every coefficient: take fewer terms")]
    Undetermined,
    /// Earlier nodes that leave coefficients free.
    #[error("the earlier nodes do not determine every coefficient of this model")]
    EarlierUndetermined,
    /// Earlier nodes of another model.
    #[error("its nodes are of another model")]
    OtherModel,
    /// No estimate of the noise.
    #[error("there is no estimate of the noise to weigh the prior against: give its value, σ")]
    NoNoise,
    /// More work than a request may ask for.
    #[error("{iterations} earlier iterations are too many for {coefficients} coefficients: at most {most}")]
    TooMuchWork {
        /// Earlier iterations.
        iterations: usize,
        /// Coefficients of the model.
        coefficients: usize,
        /// Iterations at most.
        most: usize,
    },
}
