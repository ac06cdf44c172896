//! Why nodes on a grid are refused.

use crate::KnotFault;
use flankfit_numerics::fault::words::{Shown, counted};

const AXES: [&str; 2] = ["u", "v"];

/// Why nodes on a grid, or a surface asked of them, are refused. Axis 0 is u, axis 1 is v.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridFault {
    /// Too few nodes along an axis.
    #[error("{} along {}; at least {least} are needed", counted(*.given, "node", "nodes"), AXES[*axis])]
    TooFew {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Nodes given along it.
        given: usize,
        /// Nodes at least needed.
        least: usize,
    },
    /// Heights that are not as many as the grid has nodes.
    #[error("{} for {rows} × {columns} nodes", counted(*.given, "value", "values"))]
    Count {
        /// Heights given.
        given: usize,
        /// Nodes along u.
        rows: usize,
        /// Nodes along v.
        columns: usize,
    },
    /// Rows of unequal length.
    #[error("row {row} has {}, the first one {wanted}", counted(*.given, "point", "points"))]
    Ragged {
        /// Index of the row, from 0.
        row: usize,
        /// Points in it.
        given: usize,
        /// Points in the first row.
        wanted: usize,
    },
    /// A value that is NaN or infinite.
    #[error("the value at ({row}, {column}) is not finite")]
    NotFinite {
        /// Its row, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// A place on an axis that is NaN or infinite.
    #[error("{} number {index} is not finite", AXES[*axis])]
    ParameterNotFinite {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Its index, from 0.
        index: usize,
    },
    /// A place on an axis not above the one before it.
    #[error(
        "{} number {index} ({}) does not lie above the one before it ({})",
        AXES[*axis], Shown(*.value), Shown(*.before)
    )]
    NotAscending {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Its index, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// The value before it.
        before: f64,
    },
    /// Two neighbouring points that coincide, so that no parameter lies between them.
    #[error("the points ({row}, {column}) and the one before it along {} are one, so that no parameter lies between \
        them", AXES[*axis])]
    Coincident {
        /// The axis along which they are neighbours: 0 for u, 1 for v.
        axis: usize,
        /// Its row, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// Points that coincide on every line along an axis.
    #[error("along {} all points of every line are one", AXES[*axis])]
    NoExtent {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
    },
    /// A degree that the nodes do not allow.
    #[error("degree {degree} along {} is not within 1 to {most}", AXES[*axis])]
    Degree {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Degree asked for along it.
        degree: usize,
        /// Highest degree that the nodes along it allow.
        most: usize,
    },
    /// More spans than the nodes determine.
    #[error("{spans} spans along {} ask for more functions than the {nodes} nodes there determine at degree {degree}",
        AXES[*axis])]
    Spans {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Spans asked for.
        spans: usize,
        /// Nodes along it.
        nodes: usize,
        /// Degree asked for along it.
        degree: usize,
    },
    /// The knots along an axis are refused.
    #[error("knots along {}: {fault}", AXES[*axis])]
    Knots {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Why they are refused.
        fault: KnotFault,
    },
    /// More basis functions than nodes along an axis.
    #[error("{functions} functions along {} for {nodes} nodes", AXES[*axis])]
    Functions {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Basis functions along it.
        functions: usize,
        /// Nodes along it.
        nodes: usize,
    },
    /// A node outside of the domain of the knots.
    #[error(
        "node {index} along {} ({}) lies outside of the knots' domain, [{}, {}]",
        AXES[*axis], Shown(*.value), Shown(*.low), Shown(*.high)
    )]
    OutOfDomain {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Index of the node along it, from 0.
        index: usize,
        /// Its place.
        value: f64,
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
    /// A basis function without a node of its own in its support (condition of Schoenberg and
    /// Whitney).
    #[error(
        "no node along {} is left for function {function}, which lives between knots {} and {} (the condition of \
         Schoenberg and Whitney)", AXES[*axis], Shown(*.low), Shown(*.high)
    )]
    SchoenbergWhitney {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Index of the function along it, from 0.
        function: usize,
        /// Lower end of its support.
        low: f64,
        /// Upper end of its support.
        high: f64,
    },
    /// A basis function that the nodes determine no better than rounding.
    #[error(
        "the nodes along {} determine function {function}, which lives between knots {} and {}, no better than \
         rounding",
        AXES[*axis], Shown(*.low), Shown(*.high)
    )]
    Rank {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Index of the function along it, from 0.
        function: usize,
        /// Lower end of its support.
        low: f64,
        /// Upper end of its support.
        high: f64,
    },
    /// A control point beyond the range of a double.
    #[error("control point {index} is beyond the range of a double")]
    NotRepresentable {
        /// Its index, counted by rows from 0.
        index: usize,
    },
}
