//! Errors in a robust estimator for given nodes.

/// Why it is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobustReason {
    /// More numbers than memory should hold.
    #[error(
        "this estimator holds {nodes} nodes × {coefficients} coefficients at once; at most {most} numbers are taken: \
         use an M-estimator, or fewer nodes"
    )]
    TooLarge {
        /// Nodes that count.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
        /// Numbers at most.
        most: usize,
    },
    /// Nodes times the square of the coefficients, of which least trimmed squares takes many steps.
    #[error(
        "least trimmed squares of {nodes} nodes and {coefficients} coefficients is too much work: use an M-estimator, \
         or fewer nodes"
    )]
    TooMuchWork {
        /// Nodes that count.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
    /// Least trimmed squares with nothing to leave out.
    #[error(
        "least trimmed squares needs more nodes than coefficients to leave any out: there are {nodes} for \
         {coefficients} coefficients"
    )]
    NothingToTrim {
        /// Nodes that count.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
    /// A trimmed sum that does not determine the coefficients.
    #[error(
        "the {nodes} nodes of the least trimmed sum do not determine {coefficients} coefficients: raise the coverage"
    )]
    Trimmed {
        /// Nodes of the sum.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
    /// No iteration.
    #[error("at least one iteration is needed")]
    NoIteration,
    /// Weights that leave too few nodes.
    #[error(
        "{left} of {nodes} nodes keep a weight, which do not determine {coefficients} coefficients: choose a larger \
         scale or tuning constant, or start from least trimmed squares"
    )]
    FewWeights {
        /// Nodes that keep a weight.
        left: usize,
        /// All nodes.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
}
