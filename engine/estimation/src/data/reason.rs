//! Errors in nodes.

use std::fmt;

use flankfit_numerics::fault::words::{Shown, counted, entries};

/// What a list has an entry for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Each abscissa of a curve.
    X,
    /// Each first abscissa of scattered nodes.
    U,
    /// Each node of a grid.
    Grid,
    /// Each row of a measurement matrix.
    Rows,
    /// Each column of a measurement matrix.
    Columns,
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Extent::X => "x",
            Extent::U => "u",
            Extent::Grid => "u times v",
            Extent::Rows => "the rows of x",
            Extent::Columns => "the columns of x",
        })
    }
}

/// Why nodes are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NodesReason {
    /// No node at all.
    #[error("there are no nodes")]
    Empty,
    /// An axis of a grid without positions.
    #[error("the axis has no positions")]
    EmptyAxis,
    /// A matrix without rows or columns.
    #[error("the matrix is empty")]
    EmptyMatrix,
    /// A list of the wrong length.
    #[error("{}, but {wanted} would match {of}", entries(*.given))]
    Count {
        /// Entries.
        given: usize,
        /// Entries that it should have.
        wanted: usize,
        /// What it has an entry for.
        of: Extent,
    },
    /// A column without a name.
    #[error("a column name is empty")]
    EmptyName,
    /// Two columns of one name.
    #[error("the name `{name}` occurs twice")]
    RepeatedName {
        /// The caller's name.
        name: String,
    },
    /// A weight below 0.
    #[error("the weight {} is negative; 0 leaves a node out", Shown(*.0))]
    NegativeWeight(f64),
    /// Nothing that counts.
    #[error("every node is missing or of weight 0")]
    NoneCounts,
    /// An excluded node that was not posted.
    #[error("there is no such node: {posted} were posted, numbers count from 0")]
    NoSuchNode {
        /// Number of posted nodes.
        posted: usize,
    },
    /// An excluded cell outside the grid.
    #[error("the grid has {rows} rows and {columns} columns, which count from 0")]
    NoSuchCell {
        /// Positions along u.
        rows: usize,
        /// Positions along v.
        columns: usize,
    },
    /// A cell given for nodes that are not a grid.
    #[error("only the nodes of a grid have a row and a column: give the node's index")]
    NoCells,
    /// An excluded node that is missing or of weight 0 already.
    #[error("this node is missing or of weight 0 already: leave it out of the list")]
    CountsNot,
    /// A node that is excluded twice.
    #[error("this node is already excluded by entry {0}: name it once")]
    ExcludedTwice(usize),
    /// Too few nodes left for the model.
    #[error("{left} nodes are left for {coefficients} coefficients: leave fewer out, or lower the degree")]
    TooFewLeft {
        /// Nodes that count and are not excluded.
        left: usize,
        /// Coefficients of the model.
        coefficients: usize,
    },
    /// No node left.
    #[error("no node is left: leave fewer out")]
    NoneLeft,
    /// A block with other columns than the first one of its stream.
    #[error("{}, but the stream has {stream}", counted(*.given, "column", "columns"))]
    ColumnsOfStream {
        /// Columns of the block.
        given: usize,
        /// Columns of the stream.
        stream: usize,
    },
    /// A block whose columns have other names.
    #[error("not the names of the stream's first block")]
    NamesOfStream,
    /// Another block where curves are taken.
    #[error("the stream's blocks are curves")]
    BlocksAreCurves,
    /// Another block where nodes of a surface are taken.
    #[error("the stream's blocks are nodes of a surface (scattered or grid)")]
    BlocksAreSurfaces,
    /// Another block where rows of a matrix are taken.
    #[error("the stream's blocks are rows of a measurement matrix")]
    BlocksAreRows,
}
