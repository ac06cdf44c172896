//! What is wrong with traces, and what a notice about them speaks of.

use super::settings::{SettingField, SettingReason};
use crate::Kind;
use flankfit_numerics::fault::{Common, Faults};

/// The most samples of all traces together.
pub const MOST_SAMPLES: usize = 20_000_000;

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
