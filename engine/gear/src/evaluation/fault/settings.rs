//! What is wrong with the settings of an evaluation.

use super::limits::{ToleranceField, ToleranceReason};
use crate::Kind;
use flankfit_numerics::fault::{Faults, words::Shown};

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
    /// The diameters between which the tip relief lies.
    TipRelief,
    /// One of them.
    TipReliefEnd {
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
    /// The level of intervals.
    Level,
    /// A limit of a figure.
    Limit(ToleranceField),
}

impl From<ToleranceField> for SettingField {
    fn from(field: ToleranceField) -> Self {
        SettingField::Limit(field)
    }
}

impl SettingField {
    /// The evaluation range of a kind of trace.
    pub(in crate::evaluation) fn range(kind: Kind) -> Self {
        match kind {
            Kind::Profile => SettingField::ProfileRange,
            Kind::Helix => SettingField::HelixRange,
        }
    }

    /// The length that slopes of a kind of trace are extended to.
    pub(in crate::evaluation) fn reference_length(kind: Kind) -> Self {
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
    /// A level that no interval has.
    #[error("{} is not a level: above 0.5 and below 1", Shown(*.0))]
    Level(f64),
    /// What is wrong with a limit.
    #[error(transparent)]
    Limit(#[from] ToleranceReason),
    /// Traces without a range; the first of them.
    #[error("trace {} needs an evaluation range, and none is given", .0)]
    NoRange(usize),
}

/// Faults of settings.
pub type SettingFaults = Faults<SettingField, SettingReason>;
