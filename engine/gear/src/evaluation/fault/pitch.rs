//! What is wrong with pitch deviations, and what a notice about them speaks of.

use flankfit_numerics::fault::{
    Faults,
    words::{Shown, entries},
};

/// A part of pitch deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PitchField {
    /// The numbers of the teeth.
    Deviations,
    /// One of them.
    Deviation {
        /// From 0.
        index: usize,
    },
    /// The measuring circle.
    Diameter,
    /// k of F_pk and F_pSk.
    Sector,
}

/// Why pitch deviations are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PitchReason {
    /// Not one number for each tooth.
    #[error("{}, but the gear has {teeth} teeth", entries(*.given))]
    Count {
        /// Given.
        given: usize,
        /// z.
        teeth: usize,
    },
    /// A deviation beyond what is measured, µm.
    #[error("{} µm: beyond {} µm", Shown(*.value), Shown(*.most))]
    Deviation {
        /// Given.
        value: f64,
        /// The most.
        most: f64,
    },
    /// An angle beyond what is measured, rad.
    #[error("{} rad: beyond {} rad", Shown(*.value), Shown(*.most))]
    Angle {
        /// Given.
        value: f64,
        /// The most.
        most: f64,
    },
    /// A flank more than half a pitch from its place; how far, µm.
    #[error(
        "the flank is {} µm from its place, more than half a pitch: angles run in the direction in which teeth are \
         counted",
        Shown(*.0)
    )]
    OtherTooth(f64),
    /// Every number is missing.
    #[error("no tooth was measured")]
    NotMeasured,
    /// No diameter.
    #[error("{} is not a diameter above 0 mm (and up to a kilometre)", Shown(*.0))]
    Diameter(f64),
    /// A sector that is not within the gear.
    #[error("{pitches} pitches; a sector has 1 to {most}")]
    Sector {
        /// Given.
        pitches: usize,
        /// One less than teeth.
        most: usize,
    },
}

/// Faults of pitch deviations.
pub type PitchFaults = Faults<PitchField, PitchReason>;
