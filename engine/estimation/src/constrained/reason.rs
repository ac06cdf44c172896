//! Errors in constraints on the shape.

use flankfit_numerics::fault::words::{Shown, counted};

/// Why constraints on the shape are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintReason {
    /// Constraints on a measurement matrix.
    #[error("a measurement matrix is no function of a place: it neither rises nor bends")]
    OfMatrix,
    /// Constraints on NURBS with weights.
    #[error("derivatives of NURBS are not polynomials in pieces: constraints are for models without weights")]
    Rational,
    /// A robust estimator.
    #[error("constraints are for least squares, whose sum of squares they keep least")]
    LeastSquaresOnly,
    /// A regularisation beside.
    #[error("constraints exclude regularisation: their proof of optimality needs Σ w r² alone")]
    Regularized,
    /// A prior beside.
    #[error("a prior and constraints exclude each other: the posterior would be that of a truncated distribution")]
    WithPrior,
    /// A model of the errors beside.
    #[error("constraints are for independent errors of one variance, by which Σ w r² measures what they cost")]
    WithErrors,
    /// A selection of models beside.
    #[error("constraints are for one model: criteria count the coefficients of least squares")]
    WithSelection,
    /// More coefficients than the search for the active constraints takes.
    #[error("constraints are for at most {most} coefficients, this model has {coefficients}")]
    TooMany {
        /// Number of coefficients of the model.
        coefficients: usize,
        /// At most.
        most: usize,
    },
    /// No axis told.
    #[error("missing: a surface rises or bends along u or along v")]
    AxisMissing,
    /// The second axis of a curve.
    #[error("a curve has no v; its x is u")]
    NoV,
    /// A derivative that is 0 whatever the coefficients.
    #[error("along {axis} the model has the degree {degree}: derivatives of order {order} are 0 in any case")]
    Degree {
        /// u or v.
        axis: &'static str,
        /// Degree of the model along the axis.
        degree: usize,
        /// Order of the derivative.
        order: usize,
    },
    /// A knot at which the derivative may jump.
    #[error(
        "the knot {} stands {}: the derivative below it may jump there, so that the pieces do not say it all; it may \
         stand {most}", Shown(*.knot), counted(*.given, "time", "times")
    )]
    Knot {
        /// Which.
        knot: f64,
        /// How often it stands.
        given: usize,
        /// How often it may.
        most: usize,
    },
    /// Ends that do not ascend.
    #[error("[{}, {}] is not a range from low to high", Shown(.0[0]), Shown(.0[1]))]
    Range([f64; 2]),
    /// A range beyond the domain.
    #[error(
        "[{}, {}] reaches beyond the domain of the fit, [{}, {}]", Shown(.range[0]), Shown(.range[1]),
        Shown(.domain[0]), Shown(.domain[1])
    )]
    Outside {
        /// The range.
        range: [f64; 2],
        /// The domain.
        domain: [f64; 2],
    },
    /// The opposite of another constraint.
    #[error("this is the opposite of constraint {other} (from 0), and the places of both touch")]
    Opposite {
        /// Its index, from 0.
        other: usize,
    },
    /// Constraints that exclude each other.
    #[error("no function of the model does all of this and more than just: the constraints exclude each other")]
    Exclusive,
    /// Dependent columns.
    #[error("the nodes do not determine every coefficient: take fewer terms")]
    Undetermined,
    /// No estimate of the noise.
    #[error("as many coefficients as nodes leave no estimate of the noise: give its standard deviation")]
    NoNoise,
}
