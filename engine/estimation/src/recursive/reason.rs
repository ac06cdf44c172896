//! Errors in the settings of a stream.

use flankfit_numerics::fault::words::Shown;

/// Why it is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StreamReason {
    /// A forgetting factor out of its range.
    #[error("{} is not in (0, 1]", Shown(*.0))]
    ForgettingFactor(f64),
    /// A robust estimator.
    #[error("a stream is estimated by least squares; refit its iteration with others")]
    LeastSquaresOnly,
    /// Constraints on the shape.
    #[error("a stream is estimated without constraints; refit its iteration with them")]
    NoConstraints,
    /// A prior of earlier iterations.
    #[error(
        "a stream does not look at earlier iterations: give mean and spread, or refit its iteration with this prior \
         when the stream is finished"
    )]
    NoEarlierIterations,
    /// The matrix B of another fit, by where that is to be found.
    #[error("a stream does not look at other fits: give the piece itself, which the spec of a fit by it holds")]
    NoOtherFit,
    /// Filters of heights.
    #[error("a stream has no neighbours to filter by; refit its iteration with filters")]
    NoFilters,
    /// Nodes to exclude.
    #[error("a stream takes every node; leave nodes out by a refit of its iteration")]
    NoExclusion,
    /// A block of another model.
    #[error("model and domain of the stream are those of {}", if *.surface { "a surface" } else { "a curve" })]
    Model {
        /// Whether the stream is of a surface.
        surface: bool,
    },
    /// Nodes that are no matrix, of a linear model.
    #[error("a linear model takes a measurement matrix")]
    LinearTakesMatrix,
    /// No domain where the working basis needs one.
    #[error("missing; a stream must know beforehand where a mapped basis or equal spans live")]
    DomainMissing,
}
