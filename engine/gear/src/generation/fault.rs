//! Errors in a tooth's steps and in the profile of a tool.

use crate::{GearField, GearReason};
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted},
};

/// Most points of a profile.
pub const MOST_TOOTH_POINTS: usize = 2_000_000;
/// Most points of a profile, those of its steps and corners with them.
pub const MOST_POINTS: usize = 200_000;
/// Most points tried between those of the profile, so that the envelope has no gaps.
pub const MOST_BETWEEN: usize = 200_000;

/// What a tooth is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToothField {
    /// Steps of its parts.
    Steps,
    /// A datum of the gear.
    Gear(GearField),
}

/// Why a tooth has no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToothReason {
    /// A part without a step, or more points than a gear may have; how many there are for each
    /// tooth.
    #[error(
        "{} for each tooth; every part has a step, and a gear {} points at most",
        counted(*.0, "point", "points"), MOST_TOOTH_POINTS
    )]
    Steps(usize),
    /// The gear leaves no tooth.
    #[error(transparent)]
    Gear(#[from] GearReason),
}

/// Faults of a tooth.
pub type ToothFaults = Faults<ToothField, ToothReason>;

/// A part of a tool's profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolField {
    /// All points.
    Points,
    /// One of them.
    Point {
        /// From 0.
        index: usize,
    },
}

/// Why a tool has no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToolReason {
    /// So many points make no profile.
    #[error("{}; a profile has at least 2", counted(*.0, "point", "points"))]
    TooFew(usize),
    /// So many points are too many.
    #[error("{} points; at most {} are taken", .0, MOST_POINTS)]
    TooMany(usize),
    /// Too many steps between the points.
    #[error("{points} in {parts} parts each; at most {} in all", MOST_POINTS)]
    TooManyParts {
        /// Points given.
        points: usize,
        /// Steps from each to the next.
        parts: usize,
    },
    /// Too many normals at the corners, with so many parts.
    #[error(
        "with the normals at their corners these points in {} parts each are more than {}: give fewer points or \
         parts, or join them by a spline",
        .0, MOST_POINTS
    )]
    Corners(usize),
    /// A coordinate that no tool has.
    #[error("{} is not a place on a tool, in mm", Shown(*.0))]
    NoPlace(f64),
    /// A point that stands twice.
    #[error("the same point as the one before it")]
    Repeated,
    /// A point or a normal that is none.
    #[error("a point and a direction other than 0 are needed, in mm")]
    NoDirection,
    /// No curve goes through the points.
    #[error("{0}")]
    Curve(String),
}

/// Faults of a tool's profile.
pub type ToolFaults = Faults<ToolField, ToolReason>;
