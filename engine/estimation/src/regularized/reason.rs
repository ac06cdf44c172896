//! Errors in a scaling or a regularisation for a given model.

use std::fmt;

use crate::spec::Criterion;
use flankfit_numerics::fault::words::{Shown, counted, entries};

/// Of what so many are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RankOf {
    /// All that the model can have.
    Directions,
    /// Those that are numerically nonzero.
    SingularValues,
}

impl fmt::Display for RankOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RankOf::Directions => "directions",
            RankOf::SingularValues => "singular values above rounding",
        })
    }
}

/// Why a scaling or a regularisation is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegularizationReason {
    /// Standardised columns without a single constant one.
    #[error("standardising needs exactly one constant column or term, which it leaves unpenalised")]
    NoConstant,
    /// Standardised columns of which only the constant is there.
    #[error("standardising leaves one column aside, and there is no other")]
    OnlyConstant,
    /// Standardised columns whose constant is penalised.
    #[error("standardising needs a constant that the penalty leaves free")]
    PenalisedMean,
    /// A penalty of order 0 on standardised columns.
    #[error("order 0 penalises the constant, which standardising leaves unpenalised: take another scaling or order")]
    PenalisedConstant,
    /// An order of derivatives that is not offered.
    #[error("{order} is not one of 0 to {highest}")]
    Order {
        /// The order.
        order: usize,
        /// The highest one.
        highest: usize,
    },
    /// A piece of an iteration where there is no job.
    #[error("iterations are those of a job, and this request has none: give the piece itself")]
    NoJob,
    /// A representative piece for standardised columns.
    #[error("a representative piece is of columns that are not standardised, which its matrix B is added to")]
    PieceOfStandardized,
    /// A representative piece of another model.
    #[error("the piece is of another model: its directions mean nothing here")]
    OtherModel,
    /// A representative piece of another domain.
    #[error("the piece has another domain, on which the functions are others: give that of the piece")]
    OtherDomain,
    /// A list of a piece with a wrong number of entries.
    #[error("{}; there are {wanted}", entries(*.given))]
    PieceCount {
        /// Entries.
        given: usize,
        /// As many as there have to be.
        wanted: usize,
    },
    /// Too few or too many eigenvalues of a piece.
    #[error("from 1 to {coefficients} eigenvalues, as many as are raised")]
    PieceEigenvalues {
        /// Coefficients of the model.
        coefficients: usize,
    },
    /// A number of a piece that no fit could have.
    #[error("what follows from it leaves the range of double precision: send what a fit has answered")]
    PieceBeyondDouble,
    /// A number that has to be above 0.
    #[error("{} is not greater than 0", Shown(*.0))]
    NotPositive(f64),
    /// Directions that are not orthonormal.
    #[error("directions are of length 1 and at right angles to each other; this one is not")]
    NotOrthonormal,
    /// Dependent columns.
    #[error("the nodes do not determine every coefficient, and no piece changes that: take fewer terms")]
    PieceUndetermined,
    /// Differences of too few coefficients.
    #[error(
        "differences of order {order} need at least {} coefficients; there {}", *.order + 1,
        if *.size == 1 { "is 1".to_owned() } else { format!("are {}", .size) }
    )]
    Differences {
        /// Their order.
        order: usize,
        /// Coefficients that are penalised.
        size: usize,
    },
    /// Derivatives that the model does not have.
    #[error("derivatives of order {0} vanish for every function of this model: nothing would be penalised")]
    VanishingDerivatives(usize),
    /// A wrong number of weights of the penalty.
    #[error(
        "{}; {}", counted(*.given, "weight", "weights"),
        if *.surface { "a surface takes two, [w_u, w_v]" } else { "a curve or a linear model takes one" }
    )]
    PenaltyWeightCount {
        /// Weights.
        given: usize,
        /// Whether the model is of two axes.
        surface: bool,
    },
    /// A weight of the penalty below 0.
    #[error("{} is negative or not finite", Shown(*.0))]
    PenaltyWeight(f64),
    /// Weights of the penalty that are all 0.
    #[error("at least one weight must be greater than 0")]
    NoPenaltyWeight,
    /// Coefficients that neither nodes nor penalty determine.
    #[error("nodes and penalty together leave a combination of coefficients free: take a lower order or more nodes")]
    Undetermined,
    /// Too few directions for James–Stein.
    #[error("James–Stein needs three directions to shrink; there are {0} here (the grand mean takes one)")]
    FewDirections(usize),
    /// A truncation to none, or to more than there are.
    #[error("{}", rank_in_words(*.rank, *.there, *.of))]
    Rank {
        /// How many are to be kept.
        rank: usize,
        /// How many there are.
        there: usize,
        /// The quantity.
        of: RankOf,
    },
    /// All eigenvalues are to be regularised.
    #[error(
        "{count} of {all} eigenvalues: the largest one cannot be regularised, so at most {}",
        .all.saturating_sub(1)
    )]
    Count {
        /// How many are to be regularised.
        count: usize,
        /// How many there are.
        all: usize,
    },
    /// A target of another length than the coefficients.
    #[error(
        "{}; the model has {}, in the order of the answer", entries(*.given),
        counted(*.coefficients, "coefficient", "coefficients")
    )]
    Target {
        /// Entries.
        given: usize,
        /// Coefficients of the model.
        coefficients: usize,
    },
    /// Columns that do not span the constant.
    #[error("Efron and Morris shrink to the grand mean, which these columns cannot make: give a target")]
    NoGrandMean,
    /// A matrix B that is too large to be answered.
    #[error("B has {rows} × {columns} entries here; at most {most} are answered")]
    MatrixB {
        /// Nodes that count.
        rows: usize,
        /// Coefficients.
        columns: usize,
        /// Entries at most.
        most: usize,
    },
    /// A condition without a minimum.
    #[error("there is no parameter of least condition: the condition falls for ever, or does not change at all")]
    NoLeastCondition,
    /// A closed form of ridge where it does not apply.
    #[error(
        "{} is for ridge, and needs coefficients that are not all 0 (hkb_1975 one, the others three)", .0.name()
    )]
    RidgeOnly(Criterion),
    /// A criterion that looks at every node, of a stream.
    #[error("{} looks at every node, and a stream keeps sums only: take another criterion", .0.name())]
    NodesNotKept(Criterion),
    /// A criterion that looks at every node, of columns that depend on each other.
    #[error("{} leaves out one node after the other, which takes columns that do not depend on each other", .0.name())]
    DependentColumns(Criterion),
    /// A criterion that looks at every node, of too many.
    #[error(
        "{} looks at every node: {nodes} are more than the {most} that it may be asked for with so many coefficients; \
         gcv is close to it there", .criterion.name()
    )]
    ManyNodes {
        /// Which criterion.
        criterion: Criterion,
        /// Counted nodes.
        nodes: usize,
        /// Nodes at most.
        most: usize,
    },
    /// A criterion that chooses no rank.
    #[error("{} does not choose a rank: gcv, reml and discrepancy do", .0.name())]
    NotOfRank(Criterion),
    /// A criterion of other regularisations.
    #[error("{} is not for this regularisation", .0.name())]
    Criterion(Criterion),
}

/// Why `rank` of `there` directions cannot be kept.
fn rank_in_words(rank: usize, there: usize, of: RankOf) -> String {
    match there {
        0 => "every column is 0 at these nodes: there is no direction that could be kept".to_owned(),
        _ => format!("{rank} of {there} {of} in the scaled columns: at least 1, at most all"),
    }
}
