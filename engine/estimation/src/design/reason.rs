//! Errors in a model for given nodes.

use std::fmt;

use flankfit_geometry::{KnotFault, rational::WeightFault};
use flankfit_numerics::fault::words::Shown;

/// What nodes must lie within.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// The domain of the caller.
    Domain,
    /// The span of the knots.
    Knots,
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Bound::Domain => "the domain",
            Bound::Knots => "the span of the knots",
        })
    }
}

/// Why a model is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelReason {
    /// A domain of a measurement matrix.
    #[error("a measurement matrix has no domain")]
    MatrixHasNoDomain,
    /// A linear model of nodes that are no matrix.
    #[error("a linear model is for a measurement matrix")]
    LinearIsForMatrix,
    /// A measurement matrix with another model.
    #[error("a measurement matrix takes a linear model")]
    MatrixTakesLinear,
    /// Fewer nodes than coefficients.
    #[error(
        "{coefficients} coefficients cannot be determined from {nodes} counted nodes: lower the degree or measure more \
            nodes"
    )]
    TooFewNodes {
        /// Coefficients of the model.
        coefficients: usize,
        /// Nodes that count.
        nodes: usize,
    },
    /// More coefficients than a fit may have; `None` where they cannot be counted.
    #[error(
        "{} coefficients are more than the {most} that a fit may have: take fewer",
        .count.map_or("so many".to_owned(), |count| count.to_string())
    )]
    TooManyCoefficients {
        /// Coefficients of the model.
        count: Option<usize>,
        /// At most.
        most: usize,
    },
    /// Two degrees of a curve.
    #[error("a curve has one degree, not one for each of two axes")]
    OneDegree,
    /// Two degrees where the total one is limited.
    #[error("total degree wants one degree, not two different ones")]
    OneTotalDegree,
    /// Products listed for a curve.
    #[error("a curve has every power up to its degree: products are listed for surfaces")]
    TermsOfCurve,
    /// No product at all.
    #[error("at least one term")]
    NoTerms,
    /// A product beyond the degrees.
    #[error("[{}, {}] is beyond the degrees [{}, {}]", .term[0], .term[1], .degree[0], .degree[1])]
    TermBeyondDegree {
        /// Its powers.
        term: [usize; 2],
        /// Degrees of the model.
        degree: [usize; 2],
    },
    /// A product that is listed twice.
    #[error("[{}, {}] is listed before", .0[0], .0[1])]
    RepeatedTerm([usize; 2]),
    /// A product without one that divides it.
    #[error(
        "[{}, {}] without [{}, {}], which divides it: the fit would depend on the origin of u and v",
        .term[0], .term[1], .divisor[0], .divisor[1]
    )]
    MissingDivisor {
        /// Its powers.
        term: [usize; 2],
        /// Those that are missing.
        divisor: [usize; 2],
    },
    /// Ends of a domain that do not ascend.
    #[error("[{}, {}] is not a range from low to high", Shown(.0[0]), Shown(.0[1]))]
    Range([f64; 2]),
    /// A second axis of a curve.
    #[error("a curve has no v")]
    NoV,
    /// A node out of bounds.
    #[error("{} lies outside {of} [{}, {}]", Shown(*.value), Shown(.range[0]), Shown(.range[1]))]
    Outside {
        /// Its abscissa.
        value: f64,
        /// Which bounds these are.
        of: Bound,
        /// The bounds.
        range: [f64; 2],
    },
    /// No span.
    #[error("at least one span")]
    NoSpan,
    /// Two numbers of spans of a curve.
    #[error("a curve has one number of spans")]
    OneNumberOfSpans,
    /// One knot vector of a surface.
    #[error("a surface wants two knot vectors, one for u and one for v")]
    TwoKnotVectors,
    /// Two knot vectors of a curve.
    #[error("a curve has one knot vector")]
    OneKnotVector,
    /// What is wrong with knots.
    #[error(transparent)]
    Knots(#[from] KnotFault),
    /// What is wrong with weights of NURBS.
    #[error(transparent)]
    Weights(#[from] WeightFault),
}
