//! Errors in a filter for given nodes.

use crate::spec::Filter;
use flankfit_numerics::fault::words::Shown;

/// Why a filter is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterReason {
    /// A filter of scattered nodes.
    #[error("scattered nodes lie on no lines along which a {} filter could run; send a grid or a curve", .0.name())]
    Scattered(Filter),
    /// A filter along an axis of a measurement matrix.
    #[error("a measurement matrix has no axis along which a {} filter could run", .0.name())]
    MatrixHasNoAxis(Filter),
    /// An axis of windows over a measurement matrix.
    #[error("a measurement matrix has no axis: windows lie along its rows")]
    WindowsLieAlongRows,
    /// The second axis of a curve.
    #[error("a curve has no v; its x is u")]
    NoV,
    /// A grid whose axis is not given.
    #[error("missing; a grid needs u or v")]
    AxisMissing,
    /// Windows that are too much work.
    #[error("windows of {window} nodes around {nodes} nodes are too much work")]
    Windows {
        /// Nodes of a window.
        window: usize,
        /// Nodes.
        nodes: usize,
    },
    /// Weighted sums that are too much work.
    #[error(
        "the windows hold {products} nodes all together, more than the {most} that this filter may have; choose a \
         shorter cut-off, thin the nodes out, or take a spline filter, whose work does not grow with the cut-off"
    )]
    Products {
        /// Nodes of all windows.
        products: usize,
        /// At most.
        most: usize,
    },
    /// A cut-off below the spacing.
    #[error(
        "{} is not longer than twice the closest spacing {}: no wave so short can be seen there",
        Shown(*.cutoff), Shown(*.closest)
    )]
    Cutoff {
        /// λc.
        cutoff: f64,
        /// The closest spacing.
        closest: f64,
    },
}
