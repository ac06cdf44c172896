//! Errors in a registration.

use super::Motion;
use crate::{
    Side,
    deviation::{NoFoot, foot::word},
};
use flankfit_numerics::fault::{
    Common, Faults,
    words::{Counted, Shown, counted},
};

/// A part of what is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegistrationField {
    /// The motions that are free.
    Motions,
    /// One of them.
    Motion {
        /// From 0.
        index: usize,
    },
    /// z of the pivot.
    Pivot,
    /// The teeth that points are said to be of.
    Teeth,
    /// All points.
    Points,
    /// One of them.
    Point {
        /// From 0.
        index: usize,
    },
    /// The weights of points.
    Weights,
    /// One of them.
    Weight {
        /// From 0.
        index: usize,
    },
}

/// Why a registration is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistrationReason {
    /// Nothing moves.
    #[error("no motion is free")]
    NoMotion,
    /// A motion is there twice.
    #[error("`{}` occurs twice; give it once", .0.name())]
    Twice(Motion),
    /// On a spur gear the axial shift alone.
    #[error("the flanks of a spur gear are the same along the axis: no point determines an axial shift")]
    SpurAxialShift,
    /// Another number of weights than of points.
    #[error("{given}, but {points} would match the points")]
    Weights {
        /// Given.
        given: usize,
        /// How many there are.
        points: usize,
    },
    /// A point where the modification has no value.
    #[error("the modification has no value here")]
    NoRelief,
    /// Fewer points than motions.
    #[error(
        "{} part, too few for {}",
        counted(*.points, "measured point takes", "measured points take"), counted(*.motions, "motion", "motions")
    )]
    TooFew {
        /// Points that take part.
        points: usize,
        /// Motions that are free.
        motions: usize,
    },
    /// A point that a motion carries off its flank.
    #[error("carried back to the {} flank of tooth {tooth} it is lost: {stray}", word(*.side))]
    Lost {
        /// Tooth of the flank.
        tooth: u32,
        /// Side of the flank.
        side: Side,
        /// Why it has no foot there.
        stray: NoFoot,
    },
    /// Teeth of which most are wrong however the part is turned; the best share.
    #[error(
        "the teeth contradict each other: however the part is turned, at most {} % of the points lie on the teeth that \
         they are said to be of. Count teeth clockwise from 1, or leave them out",
        Shown((100.0 * .0).round())
    )]
    TeethContradict(f64),
    /// Teeth that all lie some pitches away, where no rotation is free.
    #[error(
        "the points lie {} from the teeth that they are said to be of, and rotation is not among the motions: free it, \
         or correct the teeth",
        pitches(*.0)
    )]
    TurnedOn(u32),
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// So many pitches, in words.
pub fn pitches(count: u32) -> Counted {
    counted(count as usize, "pitch", "pitches")
}

/// Faults of a registration.
pub type RegistrationFaults = Faults<RegistrationField, RegistrationReason>;

/// Why there is no registration.
pub type RegistrationRefused = crate::Refused<RegistrationField, RegistrationReason>;
