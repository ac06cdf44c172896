//! Errors in numbers and lists of any meaning.

use super::words::{Shown, counted, entries};

/// A reason that many fields share.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Common {
    /// NaN or infinite.
    #[error("the number is not finite in double precision")]
    NotFinite,
    /// Not above the number before it.
    #[error("{} does not ascend: it follows {}", Shown(*.value), Shown(*.before))]
    NotAscending {
        /// The number.
        value: f64,
        /// The one before it.
        before: f64,
    },
    /// Below 0 or not finite.
    #[error("{} is not a finite number of at least 0", Shown(*.value))]
    Negative {
        /// The number.
        value: f64,
    },
    /// 0, below 0 or not finite.
    #[error("{} is not a finite number above 0", Shown(*.value))]
    NotPositive {
        /// The number.
        value: f64,
    },
    /// A list with another number of entries than there are nodes.
    #[error("{} for {}", entries(*.given), counted(*.nodes, "node", "nodes"))]
    PerNode {
        /// Entries.
        given: usize,
        /// Nodes.
        nodes: usize,
    },
    /// A list of another length than the positions that it belongs to.
    #[error("{}, but {positions} would match the positions", entries(*.given))]
    PerPosition {
        /// Entries.
        given: usize,
        /// Positions.
        positions: usize,
    },
    /// A deviation beyond what is measured.
    #[error("{} is beyond {} µm: check the unit", Shown(*.value), Shown(*.most))]
    DeviationBeyond {
        /// The deviation, µm.
        value: f64,
        /// The most, µm.
        most: f64,
    },
    /// A length beyond what is measured.
    #[error("{} is beyond {} mm: check the unit", Shown(*.value), Shown(*.most))]
    LengthBeyond {
        /// The length, mm.
        value: f64,
        /// The most, mm.
        most: f64,
    },
    /// Ends of a range that do not ascend.
    #[error("{} to {} mm is not an ascending range", Shown(.range[0]), Shown(.range[1]))]
    Range {
        /// Both ends, mm.
        range: [f64; 2],
    },
}
