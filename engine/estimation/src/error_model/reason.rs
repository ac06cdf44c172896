//! Errors in a model of the errors for given nodes.

use crate::spec::Along;
use flankfit_numerics::fault::words::{Shown, counted, entries};

/// Why it is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorsReason {
    /// A grid without a direction.
    #[error("the nodes of a grid lie on lines along u and along v: say which of them were scanned")]
    WhichWay,
    /// A direction of nodes without axes.
    #[error("only the nodes of a grid lie on lines along {}: take the order", .0.name())]
    NoLines(Along),
    /// Lines of nodes that are in order by themselves.
    #[error("curves and grids already define their lines")]
    LinesGiven,
    /// A list with an entry for each posted node.
    #[error("{}, but there are {nodes} nodes", entries(*.given))]
    Count {
        /// Entries.
        given: usize,
        /// Posted nodes.
        nodes: usize,
    },
    /// A correlation of a process that is not stationary.
    #[error("{} is no correlation of neighbours: above -1 and below 1", Shown(*.0))]
    Correlation(f64),
    /// Coefficients of a process that is not stationary.
    #[error(
        "no stationary process has φ₁ = {} and φ₂ = {}: -1 < φ₂ < 1 - |φ₁|", Shown(.0[0]), Shown(.0[1])
    )]
    NotStationary([f64; 2]),
    /// A length that is none.
    #[error("{} is no length: above 0 and finite", Shown(*.0))]
    Length(f64),
    /// A share that is none.
    #[error("{} is no share: at least 0 and below 1", Shown(*.0))]
    Nugget(f64),
    /// Heights that determine each other.
    #[error("with these parameters heights determine their neighbours to rounding: give a weaker correlation")]
    Singular,
    /// Residuals that tell no correlation.
    #[error("the residuals determine no correlation: give its parameters, or take the errors as independent")]
    Undetermined,
    /// Lines without neighbours.
    #[error("{}", few_neighbours(*.pairs, *.least))]
    FewNeighbours {
        /// Pairs of neighbours on one line.
        pairs: usize,
        /// Pairs that an estimate takes at least.
        least: usize,
    },
    /// Lines with neighbours, but too short for what two parameters differ in.
    #[error("{}", short_lines(*.found, *.least))]
    ShortLines {
        /// Nodes with two others before them on their line.
        found: usize,
        /// So many that an estimate takes at least.
        least: usize,
    },
    /// Nothing is left of the heights.
    #[error("the model fits every height exactly, so the errors cannot be estimated: leave this out")]
    NoResiduals,
    /// Too little is left to estimate from.
    #[error("{nodes} nodes for {coefficients} coefficients leave too little to estimate the errors from")]
    FewNodes {
        /// Counted nodes.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
    /// More work than a request may ask for.
    #[error("{nodes} nodes with {coefficients} coefficients are too much work for this model of the errors")]
    TooLarge {
        /// Counted nodes.
        nodes: usize,
        /// Coefficients.
        coefficients: usize,
    },
    /// An estimator that has a model of the errors of its own.
    #[error("a model of the errors is for least squares: this estimator has one of its own")]
    Robust,
    /// A scaling by means.
    #[error("white rows have no means to be centred by")]
    Standardized,
    /// Bounds for independent nodes.
    #[error("perturbation bounds are those of independent errors of equal variance")]
    Uncertainty,
    /// Nodes left out.
    #[error("press and blocked_cv need independent nodes: take another criterion")]
    Press,
    /// A prior beside parameters that are estimated.
    #[error("a prior needs errors with given correlations or variances: they cannot be estimated with it")]
    Prior,
    /// Earlier iterations, whose errors nothing is said of.
    #[error("earlier iterations are weighed with independent errors of one variance")]
    Chain,
    /// Two models at once.
    #[error("either correlated errors or unequal variances, not both")]
    Both,
    /// A σ beside variances that are taken from the residuals.
    #[error("variances are estimated from the residuals: leave out the given σ")]
    Sigma,
    /// More groups than are kept apart.
    #[error("{groups} groups, but a fit with so many coefficients estimates the variances of up to {most}")]
    ManyGroups {
        /// Groups.
        groups: usize,
        /// Groups at most.
        most: usize,
    },
    /// A node that determines a coefficient alone.
    #[error("a coefficient depends on one node alone: its residual does not show its variance")]
    Alone,
    /// A group whose variance is not determined.
    #[error("the residuals do not determine the variance of every group: join small groups")]
    Group,
    /// A coordinate that is 0.
    #[error("a node lies at 0, where a power of the coordinate gives no variance")]
    Zero,
    /// A coordinate that is the same at every node.
    #[error(
        "the coordinate is the same at every node, so no power of it can be estimated: take another, groups or \
        hc3"
    )]
    Level,
    /// A power that is not determined.
    #[error("the residuals determine no power between -6 and 6")]
    Power,
    /// A coordinate that the nodes have not.
    #[error("{0} have no such coordinate, of which the variance could be a power: take groups or hc3")]
    NoCoordinate(&'static str),
    /// A power of a coordinate that runs from -1 to 1.
    #[error("the flank's coordinates are mapped to -1 … 1, of which errors are no power: take groups or hc3")]
    Mapped,
    /// The pose of a part.
    #[error("a part is registered with independent errors of one variance")]
    Registration,
    /// Positions of rows of a matrix.
    #[error("the columns of a measurement matrix have no positions that could be off")]
    PositionsOfMatrix,
    /// Positions that alone are off.
    #[error("where the surface is level positions explain no height: give the uncertainty of the heights too")]
    HeightsExact,
    /// Positions of streams and of points near shapes.
    #[error("streams and shapes near points take positions as exact")]
    PositionsExact,
    /// Positions beside constraints.
    #[error("a fit with constraints takes positions as exact: leave one of both out")]
    PositionsConstrained,
    /// Positions beside blocks that are left out.
    #[error("a fit that leaves out blocks of nodes takes positions as exact: leave one of both out")]
    PositionsFolds,
    /// Positions over columns that depend on each other.
    #[error(
        "the columns depend on each other over these nodes, and positions are then taken as exact: take fewer terms, \
         or leave this out"
    )]
    PositionsDependent,
    /// Curves and surfaces near points.
    #[error("shapes near points are fitted with independent errors of one variance")]
    Shape,
    /// A stream keeps no nodes.
    #[error("a stream keeps no nodes, whose lines and residuals a model of the errors needs")]
    Stream,
}

fn few_neighbours(pairs: usize, least: usize) -> String {
    let known = match pairs {
        0 => "every line has a single node".to_owned(),
        _ => format!(
            "{} on one line, fewer than {least}",
            counted(pairs, "pair of neighbours is", "pairs of neighbours are")
        ),
    };
    format!("{known}, so nothing tells how neighbours correlate: take the other axis or order, or tell the parameters")
}

fn short_lines(found: usize, least: usize) -> String {
    let known = match found {
        0 => "no line has three nodes".to_owned(),
        _ => format!(
            "{} two others before on the same line, fewer than {least}",
            counted(found, "node has", "nodes have")
        ),
    };
    format!(
        "{known}, so nothing tells the two parameters of these errors apart: take ar1, the other axis or order, or \
         tell the parameters"
    )
}
