//! Why there is no such grid.

use crate::{NoInvolute, fault::NoSuchTooth};
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted},
};

/// Most nodes of one grid.
pub const MOST_NODES: usize = 2_000_000;

/// A part of what is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridField {
    /// Places along the profile.
    Profile,
    /// One of them.
    ProfileValue {
        /// From 0.
        index: usize,
    },
    /// Places along the axis.
    Positions,
    /// One of them.
    Position {
        /// From 0.
        index: usize,
    },
    /// The tooth.
    Tooth,
}

/// Why there is no such grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridReason {
    /// An axis without a place.
    #[error("at least one place is needed")]
    Empty,
    /// So many nodes are too many.
    #[error("{}; a grid has at most {MOST_NODES}", counted(*.0, "node", "nodes"))]
    TooMany(usize),
    /// No z.
    #[error("{} is not a place on the axis", Shown(*.0))]
    NotOnAxis(f64),
    /// A tooth that the gear has not got.
    #[error(transparent)]
    Tooth(#[from] NoSuchTooth),
    /// A place without an involute.
    #[error(transparent)]
    NoInvolute(#[from] NoInvolute),
}

/// Faults of a grid.
pub type GridFaults = Faults<GridField, GridReason>;
