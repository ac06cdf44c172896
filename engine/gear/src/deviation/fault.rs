//! Errors in a measurement, a topography of deviations, or borders.

use super::NoFoot;
use crate::fault::NoSuchTooth;
use flankfit_numerics::fault::{
    Common, Faults,
    words::{Shown, counted, entries},
};

/// A part of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureField {
    /// Radius of the ball.
    BallRadius,
    /// How far a point may lie from its flank.
    Reach,
    /// A measured point.
    Point {
        /// From 0.
        index: usize,
    },
    /// The tooth that a point is said to be of.
    Tooth {
        /// From 0.
        index: usize,
    },
}

/// Why a measurement is refused. Lengths in mm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureReason {
    /// No radius.
    #[error("{} is not a radius of 0 to 1000 mm", Shown(*.0))]
    BallRadius(f64),
    /// A reach beyond half the base pitch.
    #[error("{} is not above 0 and up to half the base pitch, {most:.4} mm", Shown(*.reach))]
    Reach {
        /// Given.
        reach: f64,
        /// Half the base pitch.
        most: f64,
    },
    /// A coordinate beyond what is measured.
    #[error("a coordinate is beyond {} mm", Shown(*.0))]
    Coordinate(f64),
    /// A tooth that the gear has not got.
    #[error(transparent)]
    Tooth(#[from] NoSuchTooth),
    /// A point that belongs to no flank.
    #[error(transparent)]
    NoFoot(#[from] NoFoot),
}

/// Faults of a measurement.
pub type MeasureFaults = Faults<MeasureField, MeasureReason>;

/// A part of a topography of deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopographyField {
    /// The tooth.
    Tooth,
    /// The roll lengths.
    RollLengths,
    /// One of them.
    RollLength {
        /// From 0.
        index: usize,
    },
    /// The axial positions.
    Positions,
    /// One of them.
    Position {
        /// From 0.
        index: usize,
    },
    /// All deviations.
    Deviations,
    /// A row of them.
    Row {
        /// From 0.
        row: usize,
    },
    /// One of them.
    Deviation {
        /// From 0.
        row: usize,
        /// From 0.
        column: usize,
    },
}

/// Why a topography of deviations is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TopographyReason {
    /// A tooth that the gear has not got.
    #[error(transparent)]
    Tooth(#[from] NoSuchTooth),
    /// An axis without a position.
    #[error("the axis has no positions")]
    EmptyAxis,
    /// A roll length below 0.
    #[error("{} mm is below 0, the start of the involute", Shown(*.0))]
    BelowBase(f64),
    /// A number of rows that is not that of the roll lengths.
    #[error("{}, but {roll_lengths} would match the roll lengths", counted(*.rows, "row", "rows"))]
    Rows {
        /// Given.
        rows: usize,
        /// How many there are.
        roll_lengths: usize,
    },
    /// A row with another number of entries than there are positions.
    #[error("{}, but {positions} would match the axial positions", entries(*.given))]
    Columns {
        /// Given.
        given: usize,
        /// How many there are.
        positions: usize,
    },
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// Faults of a topography of deviations.
pub type TopographyFaults = Faults<TopographyField, TopographyReason>;

/// A part of the borders of a flank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BorderField {
    /// Both together.
    Whole,
    /// Along the profile.
    Profile,
    /// Along the face width.
    Face,
}

/// Why borders are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BorderReason {
    /// Ends that do not ascend.
    #[error(transparent)]
    Range(#[from] Common),
    /// Shares that leave nothing, percent.
    #[error("{} % and {} % leave nothing between the edges", Shown(*.low), Shown(*.high))]
    Nothing {
        /// At the lower end.
        low: f64,
        /// At the upper end.
        high: f64,
    },
    /// No node takes part.
    #[error("no measured node lies inside these borders")]
    NoNode,
}

/// Faults of borders.
pub type BorderFaults = Faults<BorderField, BorderReason>;
