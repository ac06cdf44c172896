//! What is wrong with traces, pitches and readings, and with what they are evaluated by; and what a
//! notice speaks of.

use crate::{
    fault::{
        Common, Faults,
        words::{Shown, entries},
    },
    gear::{Kind, NoInvolute},
};

/// The most samples of all traces together.
pub const MOST_SAMPLES: usize = 20_000_000;

/// A setting of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingField {
    /// The diameters of the profile's evaluation range.
    ProfileRange,
    /// One of them.
    ProfileRangeEnd {
        /// 0 or 1.
        index: usize,
    },
    /// What profile slopes are extended to.
    ProfileReference,
    /// Its length.
    ProfileReferenceLength,
    /// The z of the helix's evaluation range.
    HelixRange,
    /// The length that helix slopes are extended to.
    HelixReferenceLength,
    /// Which way deviations count.
    DeviationSign,
}

impl SettingField {
    /// The evaluation range of a kind of trace.
    pub(super) fn range(kind: Kind) -> Self {
        match kind {
            Kind::Profile => SettingField::ProfileRange,
            Kind::Helix => SettingField::HelixRange,
        }
    }

    /// The length that slopes of a kind of trace are extended to.
    pub(super) fn reference_length(kind: Kind) -> Self {
        match kind {
            Kind::Profile => SettingField::ProfileReferenceLength,
            Kind::Helix => SettingField::HelixReferenceLength,
        }
    }
}

/// Why a setting is refused. Lengths in mm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingReason {
    /// A diameter within the base circle.
    #[error("{} mm is not a diameter on the involute, which starts at {} mm", Shown(*.diameter), Shown(*.base))]
    NotOnInvolute {
        /// Given.
        diameter: f64,
        /// d_b.
        base: f64,
    },
    /// Ends that do not ascend, or lie too far apart.
    #[error(
        "{} to {} mm is not an ascending range (of a µm at least, and within a kilometre)",
        Shown(.0[0]), Shown(.0[1])
    )]
    Range([f64; 2]),
    /// No length.
    #[error("{} is not a length above 0 mm (and up to a kilometre)", Shown(*.0))]
    Length(f64),
    /// A tip circle before the start of the range; its diameter.
    #[error("the tip circle of {} mm has no roll length beyond the start of the evaluation range", Shown(*.0))]
    NoWayToTip(f64),
    /// A face width that is asked for and not known.
    #[error("the gear has no face width that slopes could be extended to; give one, or the length")]
    NoFaceWidth,
    /// Traces without a range; the first of them.
    #[error("trace {} needs an evaluation range, and none is given", .0)]
    NoRange(usize),
}

/// Faults of settings.
pub type SettingFaults = Faults<SettingField, SettingReason>;

/// A part of what is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceField {
    /// All traces.
    Traces,
    /// The positions of a trace.
    Position {
        /// The trace, from 0.
        trace: usize,
        /// Of the trace.
        kind: Kind,
        /// The sample, from 0.
        index: usize,
    },
    /// The deviations of a trace.
    Deviations {
        /// The trace, from 0.
        trace: usize,
    },
    /// One of them.
    Deviation {
        /// The trace, from 0.
        trace: usize,
        /// The sample, from 0.
        index: usize,
    },
    /// The design line of a trace.
    Design {
        /// The trace, from 0.
        trace: usize,
    },
    /// A number of it.
    DesignAt {
        /// The trace, from 0.
        trace: usize,
        /// The sample, from 0.
        index: usize,
    },
    /// A setting.
    Setting(SettingField),
    /// The face width of the gear.
    FaceWidth,
}

impl From<SettingField> for TraceField {
    fn from(field: SettingField) -> Self {
        TraceField::Setting(field)
    }
}

/// Why traces are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TraceReason {
    /// There is none.
    #[error("there are no traces")]
    None,
    /// So many samples are too many.
    #[error("{} samples; at most {MOST_SAMPLES} are evaluated at once", .0)]
    TooMany(usize),
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
    /// What is wrong with a setting.
    #[error(transparent)]
    Setting(#[from] SettingReason),
}

/// Faults of an evaluation.
pub type TraceFaults = Faults<TraceField, TraceReason>;

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
    /// k of F_pk.
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

/// A part of the nodes over a flank, or of what their surface is fitted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceField {
    /// Places along the profile.
    Profile,
    /// One of them.
    ProfileAt {
        /// From 0.
        index: usize,
    },
    /// Axial places.
    Positions,
    /// One of them.
    Position {
        /// From 0.
        index: usize,
    },
    /// All deviations.
    Deviations,
    /// One of them.
    Deviation {
        /// From 0.
        index: usize,
    },
    /// Which nodes are there.
    Valid,
    /// The range along the profile.
    ProfileRange,
    /// One end of it.
    ProfileRangeEnd {
        /// 0 or 1.
        index: usize,
    },
    /// The range along the axis.
    HelixRange,
    /// What is cut off at the ends of both ranges.
    Border,
    /// At the root.
    BorderRoot,
    /// At the tip.
    BorderTip,
    /// At the end of small z.
    BorderToe,
    /// At the end of great z.
    BorderHeel,
}

/// Why the surface of a flank is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceReason {
    /// There is none.
    #[error("there are no nodes")]
    NoNodes,
    /// Another number of axial places than of places along the profile.
    #[error("{}, but {profile} would match the profile", entries(*.given))]
    Positions {
        /// Given.
        given: usize,
        /// Places along the profile.
        profile: usize,
    },
    /// Every node is missing.
    #[error("every node is missing")]
    AllMissing,
    /// Every node lies outside.
    #[error("no node is left within the trimmed range")]
    AllTrimmed,
    /// No share, percent.
    #[error("{} is not within 0 and 100", Shown(*.0))]
    Percent(f64),
    /// Shares that leave nothing.
    #[error("nothing is left between opposite borders")]
    NothingLeft,
    /// A place without an involute.
    #[error(transparent)]
    NoInvolute(#[from] NoInvolute),
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// Faults of the surface of a flank.
pub type SurfaceFaults = Faults<SurfaceField, SurfaceReason>;

/// Why a flank has no surface.
pub type SurfaceRefused = crate::gear::Refused<SurfaceField, SurfaceReason>;
