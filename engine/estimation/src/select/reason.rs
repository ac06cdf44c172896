//! Errors in a selection of models.

use crate::spec::ModelCriterion;
use flankfit_numerics::fault::words::{Shown, counted};

/// Why a selection is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectionReason {
    /// Degrees of another model than polynomials.
    #[error("degrees are chosen of polynomials: take the model polynomial, or choose terms of a linear model")]
    PolynomialsOnly,
    /// Terms of B-splines.
    #[error(
        "functions of a B-spline cannot be selected one by one: choose degrees or terms of polynomials, or \
        columns"
    )]
    NotOfSplines,
    /// Powers without those that divide them.
    #[error(
        "without the powers that divide it a term would depend on where u and v are 0: only the columns of a linear \
         model are chosen without a hierarchy"
    )]
    Hierarchy,
    /// α beyond its range.
    #[error("{} is not above 0 and at most 1", Shown(*.0))]
    Alpha(f64),
    /// Something known before.
    #[error("a prior is of the coefficients of one model: choose the model first, then give the prior")]
    WithPrior,
    /// Errors that are not white.
    #[error("the figures of models are those of independent errors of one variance: choose the model first")]
    WithErrors,
    /// Another estimator than least squares.
    #[error("likelihoods and leverages are those of least squares: a robust estimator has none to choose by")]
    LeastSquaresOnly,
    /// Two degrees for a curve.
    #[error("a curve takes one degree, not one for each axis")]
    OneDegree,
    /// Two degrees that differ, for products of a total degree.
    #[error("products up to a total degree take one degree for both axes")]
    OneTotalDegree,
    /// More candidates than are looked at.
    #[error("these degrees make {candidates} models, more than the {most} that are looked at")]
    ManyCandidates {
        /// Models.
        candidates: usize,
        /// At most.
        most: usize,
    },
    /// More work than a request may ask for.
    #[error("{coefficients} coefficients and {nodes} nodes are too much work: take fewer of them")]
    TooMuchWork {
        /// Number of coefficients of the largest model.
        coefficients: usize,
        /// Counted nodes.
        nodes: usize,
    },
    /// More coefficients than nodes.
    #[error("the largest model has {}, of {nodes} counted \
        nodes", counted(*.coefficients, "coefficient", "coefficients"))]
    TooFewNodes {
        /// Number of coefficients of the largest model.
        coefficients: usize,
        /// Counted ones.
        nodes: usize,
    },
    /// Columns of the largest model that depend on each other.
    #[error("the nodes do not determine the largest model: its columns depend on each other; leave some out")]
    Dependent,
    /// No candidate has the figure.
    #[error("no model has {}: there are too few nodes, or the heights leave no residuals", .0.name())]
    NoFigure(ModelCriterion),
    /// A stream, whose nodes are gone.
    #[error("models are compared node by node, and a stream keeps sums only")]
    OfStream,
}
