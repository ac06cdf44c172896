//! Which part of a request for a fit is at fault, and why.

pub use super::{
    constrained::reason::ConstraintReason,
    data::folds::FoldsReason,
    data::reason::{Extent, NodesReason},
    design::reason::{Bound, ModelReason},
    diagnostics::reason::RangeReason,
    error_model::reason::ErrorsReason,
    filtering::reason::FilterReason,
    inference::reason::InferenceReason,
    near::reason::{NearReason, OpenCoefficient},
    prior::reason::PriorReason,
    recursive::reason::StreamReason,
    regularized::reason::{RankOf, RegularizationReason},
    robust::reason::RobustReason,
    select::reason::SelectionReason,
};

use flankfit_numerics::fault::{self, Common};

/// A list that nodes consist of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeList {
    /// Abscissae of a curve, or rows of a measurement matrix.
    X,
    /// Heights of a curve or of a measurement matrix.
    Y,
    /// First abscissae of a surface.
    U,
    /// Second abscissae of a surface.
    V,
    /// Heights of a surface.
    Z,
    /// Weights.
    Weight,
    /// Which nodes of a grid are there.
    Valid,
    /// Names of columns.
    Names,
}

/// A part of what is asked for; indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The nodes.
    Nodes,
    /// Which kind of nodes they are.
    NodesType,
    /// One of their lists.
    List(NodeList),
    /// An entry of a list.
    Entry(NodeList, usize),
    /// An entry of a list in rows: row and column.
    Cell(NodeList, usize, usize),
    /// The domain.
    Domain,
    /// Its range of u, or of x.
    DomainU,
    /// Its range of v.
    DomainV,
    /// The model.
    Model,
    /// Which kind of model it is.
    ModelType,
    /// Its degree.
    Degree,
    /// Its products of powers.
    Terms,
    /// One of them.
    Term(usize),
    /// Its knots.
    Knots,
    /// A knot of a curve.
    Knot(usize),
    /// The knots of an axis of a surface.
    AxisKnots(usize),
    /// A knot of an axis: axis and knot.
    AxisKnot(usize, usize),
    /// Its number of spans.
    Spans,
    /// The number of spans of an axis.
    AxisSpans(usize),
    /// The weights of NURBS.
    ControlWeights,
    /// A weight of a curve.
    ControlWeight(usize),
    /// A weight of a surface: row and column.
    NetWeight(usize, usize),
    /// The scaling of columns.
    Scaling,
    /// The regularisation.
    Regularization,
    /// Which kind of regularisation it is.
    RegularizationType,
    /// The order of a penalty.
    Order,
    /// The weights of a penalty.
    PenaltyWeights,
    /// A weight of a penalty.
    PenaltyWeight(usize),
    /// The parameter.
    Parameter,
    /// The criterion that chooses it.
    Criterion,
    /// The criterion that chooses λ* of a spectral scheme.
    LambdaCriterion,
    /// How many singular values are kept.
    Rank,
    /// How many eigenvalues are regularised.
    Count,
    /// What coefficients are drawn to.
    Target,
    /// The iteration that a representative piece is.
    PieceIteration,
    /// The model of a representative piece.
    PieceModel,
    /// Its domain.
    PieceDomain,
    /// Its λ*.
    PieceLambdaStar,
    /// Its eigenvalues.
    PieceEigenvalues,
    /// One of them.
    PieceEigenvalue(usize),
    /// Its directions.
    PieceDirections,
    /// One of them.
    PieceDirection(usize),
    /// Its scales.
    PieceScale,
    /// The scale of a column.
    PieceScaleOf(usize),
    /// Which variant of shrinkage.
    Variant,
    /// The estimator.
    Estimator,
    /// Which kind of estimator it is.
    EstimatorType,
    /// The share of nodes that a trimmed sum keeps.
    Coverage,
    /// The limit of iterations.
    MaxIterations,
    /// The tuning constant.
    Tuning,
    /// The share of the nodes that an L-estimator trims or winsorizes.
    Share,
    /// A scale that is given.
    ScaleValue,
    /// r of Ineq. 51.
    CoefficientNormLimit,
    /// σ.
    NoiseSigma,
    /// Uncertainty of the nodes.
    NodeUncertainty,
    /// Whether positions were measured or aimed at.
    PositionKind,
    /// Correlations of the errors.
    Errors,
    /// Which way their lines run.
    ErrorsAlong,
    /// The line of every node.
    ErrorsLine,
    /// Their parameters.
    ErrorsParameters,
    /// The correlation of neighbours.
    ErrorsRho,
    /// The coefficients of the autoregression of second order.
    ErrorsPhi,
    /// The length of the correlation.
    ErrorsLength,
    /// The white share.
    ErrorsNugget,
    /// Variances of the errors.
    Variance,
    /// The groups of nodes of one variance.
    VarianceGroups,
    /// The coordinate of which the variance is a power.
    VariancePowerOf,
    /// The level of intervals.
    Level,
    /// The level of predictions.
    PredictLevel,
    /// Where heights are asked for.
    PredictAt,
    /// A row at which a linear model is asked for, from 0.
    PredictRow(usize),
    /// Whether slopes are asked for.
    PredictSlopes,
    /// What was known before.
    Prior,
    /// Its mean.
    PriorMean,
    /// Its standard deviations.
    PriorStdError,
    /// One of them.
    PriorStdErrorOf(usize),
    /// Its covariance matrix.
    PriorCovariance,
    /// A row of that.
    PriorRow(usize),
    /// Its iterations.
    PriorIterations,
    /// One of them.
    PriorIteration(usize),
    /// How far the flank moves between them.
    PriorMove,
    /// How far one of its coefficients does.
    PriorMoveOf(usize),
    /// Which of several models is fitted.
    Select,
    /// The largest degrees that are looked at.
    SelectDegrees,
    /// How terms are chosen.
    SelectTerms,
    /// The share of the absolute values in the penalty of the elastic net.
    SelectAlpha,
    /// Whether terms stand with all that divide them.
    SelectHierarchical,
    /// The criterion that chooses a model.
    SelectCriterion,
    /// The blocks of nodes that are left out.
    Folds,
    /// What is never torn apart.
    FoldsBy,
    /// How many blocks there are.
    FoldsCount,
    /// The scan line of each node.
    FoldsLine,
    /// How the function has to rise, fall or bend.
    Constraints,
    /// One constraint of its shape.
    Constraint(usize),
    /// Along which axis it is.
    ConstraintAlong(usize),
    /// Where along an axis it is: constraint and axis.
    ConstraintRange(usize, usize),
    /// What is answered only when asked for.
    Include,
    /// The filters.
    Filters,
    /// One of them.
    Filter(usize),
    /// Which kind of filter it is.
    FilterType(usize),
    /// The axis that it runs along.
    FilterAxis(usize),
    /// Its window.
    FilterWindow(usize),
    /// Its cut-off.
    FilterCutoff(usize),
    /// The list of excluded nodes.
    Exclude,
    /// An entry of that list.
    Excluded(usize),
    /// The forgetting factor of a stream.
    ForgettingFactor,
}

impl Field {
    /// Whether it is of the nodes.
    pub fn is_of_nodes(self) -> bool {
        use Field::*;
        matches!(self, Nodes | NodesType | List(_) | Entry(..) | Cell(..))
    }

    /// Whether it is of the model.
    pub fn is_of_model(self) -> bool {
        use Field::*;
        matches!(
            self,
            Model
                | ModelType
                | Degree
                | Terms
                | Term(_)
                | Knots
                | Knot(_)
                | AxisKnots(_)
                | AxisKnot(..)
                | Spans
                | AxisSpans(_)
                | ControlWeights
                | ControlWeight(_)
                | NetWeight(..)
        )
    }

    /// Whether it is of the regularisation.
    pub fn is_of_regularization(self) -> bool {
        use Field::*;
        matches!(
            self,
            Regularization
                | RegularizationType
                | Order
                | PenaltyWeights
                | PenaltyWeight(_)
                | Parameter
                | Criterion
                | LambdaCriterion
                | Rank
                | Count
                | Target
                | Variant
        )
    }

    /// The list that it is or belongs to.
    pub fn list(self) -> Option<NodeList> {
        match self {
            Field::List(list) | Field::Entry(list, _) | Field::Cell(list, ..) => Some(list),
            _ => None,
        }
    }
}

/// Why it is at fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
    /// What is wrong with nodes.
    #[error(transparent)]
    Nodes(#[from] NodesReason),
    /// What is wrong with a model.
    #[error(transparent)]
    Model(#[from] ModelReason),
    /// Numbers that leave the range of double precision.
    #[error(transparent)]
    Range(#[from] RangeReason),
    /// What is wrong with a scaling or a regularisation.
    #[error(transparent)]
    Regularization(#[from] RegularizationReason),
    /// What is wrong with a robust estimator.
    #[error(transparent)]
    Robust(#[from] RobustReason),
    /// What is wrong with a filter.
    #[error(transparent)]
    Filter(#[from] FilterReason),
    /// What is wrong with intervals and predictions.
    #[error(transparent)]
    Inference(#[from] InferenceReason),
    /// What is wrong with a prior.
    #[error(transparent)]
    Prior(#[from] PriorReason),
    /// What is wrong with a model of the errors.
    #[error(transparent)]
    Errors(#[from] ErrorsReason),
    /// What is wrong with a selection of models.
    #[error(transparent)]
    Selection(#[from] SelectionReason),
    /// What is wrong with blocks of nodes.
    #[error(transparent)]
    Folds(#[from] FoldsReason),
    /// What is wrong with constraints on the shape.
    #[error(transparent)]
    Constraint(#[from] ConstraintReason),
    /// What is wrong with a stream.
    #[error(transparent)]
    Stream(#[from] StreamReason),
    /// What is wrong with a curve near points, or with a big surface.
    #[error(transparent)]
    Near(#[from] NearReason),
    /// What is wrong with the nodes of an earlier iteration.
    #[error("iteration {number}: {reason}")]
    Earlier {
        /// Its number.
        number: u32,
        /// Why.
        reason: Box<Reason>,
    },
    /// A part of a stream's request that suits neither curves nor surfaces: this is wrong for one.
    #[error("for {}: {reason}", if *.surface { "a surface" } else { "a curve" })]
    For {
        /// Whether for a surface.
        surface: bool,
        /// Why.
        reason: Box<Reason>,
    },
    /// A part of a stream's request that its nodes turn out not to fit.
    #[error("the stream's {field:?} does not suit these nodes: {reason}")]
    Unsuited {
        /// The part.
        field: Field,
        /// Why not.
        reason: Box<Reason>,
    },
}

/// A fault of a request for a fit.
pub type Fault = fault::Fault<Field, Reason>;

/// Faults of a request for a fit.
pub type Faults = fault::Faults<Field, Reason>;
