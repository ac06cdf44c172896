//! What is wrong with radial readings, and what a notice about them speaks of.

use super::pitch::PitchReason;
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, entries},
};

/// A part of what a run-out is found from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunoutField {
    /// All readings.
    Readings,
    /// One of them.
    Reading {
        /// From 0.
        index: usize,
    },
    /// Pitches of the left flank.
    Left,
    /// Pitches of the right flank.
    Right,
}

/// Why there is no run-out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunoutReason {
    /// Not one reading for each space.
    #[error("{}, but the gear has {teeth} tooth spaces", entries(*.given))]
    Readings {
        /// Given.
        given: usize,
        /// z.
        teeth: usize,
    },
    /// Every reading is missing.
    #[error("no space was measured")]
    NotMeasured,
    /// Both flanks were not measured on one circle, mm.
    #[error("measured on {} mm, the left flank on {} mm", Shown(*.right), Shown(*.left))]
    Circles {
        /// Of the right flank.
        right: f64,
        /// Of the left flank.
        left: f64,
    },
    /// A measuring circle within the base circle, mm.
    #[error("the measuring circle of {} mm is not above the base circle of {} mm", Shown(*.diameter), Shown(*.base))]
    WithinBase {
        /// Of the measuring circle.
        diameter: f64,
        /// d_b.
        base: f64,
    },
    /// A space that no ball fits into.
    #[error("no ball touches both flanks of a space on the measuring circle")]
    NoBall,
    /// Nowhere are both flanks known.
    #[error("no space has index deviations of both of its flanks")]
    NoSpace,
    /// What is wrong with the pitches.
    #[error(transparent)]
    Pitch(#[from] PitchReason),
}

/// Faults of a run-out.
pub type RunoutFaults = Faults<RunoutField, RunoutReason>;
