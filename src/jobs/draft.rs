//! Checked input of the use cases, before ids and times are assigned.

use std::{collections::BTreeMap, sync::Arc};

use flankfit_engine::estimation::Nodes;

use crate::jobs::*;

/// A job to create.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobDraft {
    pub name: String,
    pub part_number: Option<String>,
    pub serial_number: Option<String>,
    pub machine: Option<String>,
    pub gear: Option<JobGear>,
    /// Requirements on its flanks: a JSON document.
    pub requirements: Option<Arc<str>>,
    pub tags: BTreeMap<String, String>,
}

/// An iteration to add.
#[derive(Clone, Debug)]
pub struct IterationDraft {
    pub nodes: Arc<Nodes>,
    /// Result for these nodes.
    pub computed: Computed,
    pub measurand: Measurand,
    pub details: MeasurementDetails,
    /// To be kept with it from the beginning.
    pub records: Vec<RecordDraft>,
    /// The gear of the job that its nodes were made by, where they were.
    pub expected_gear: Option<ExpectedGear>,
}

/// The gear of a job as it was when something was made by it: by the time that this is stored the
/// job may have another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedGear(pub Option<JobGear>);

/// A stream to open.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamDraft {
    /// Specification of the fit: a JSON document.
    pub spec: Arc<str>,
    /// In (0, 1].
    pub forgetting_factor: f64,
    /// Digest of the above.
    pub input_sha256: [u8; 32],
    pub measurand: Measurand,
}

/// A later change of the measurand of stored nodes.
#[derive(Clone, Debug)]
pub struct AmendmentDraft {
    /// The new measurand.
    pub measurand: Measurand,
    /// Record of the change.
    pub record: RecordDraft,
    /// The chosen fit repeated, with the new figures.
    pub refit: Option<RefitDraft>,
    pub decision: Option<DecisionDraft>,
}

/// A decision on the gear.
#[derive(Clone, Debug)]
pub struct DecisionDraft {
    pub decision: Decision,
    pub concession: bool,
    pub reason: Option<String>,
}

/// Another fit of nodes already stored.
#[derive(Clone, Debug)]
pub struct RefitDraft {
    pub computed: Computed,
    pub reason: Option<String>,
}
