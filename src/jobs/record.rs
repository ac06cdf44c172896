//! Records of an iteration: request and answer, never changed.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecordKind {
    Curve,
    Surface,
    /// Deviations of measured points from the nominal flank.
    Deviations,
    /// Slopes, forms and totals of traces.
    Evaluation,
    /// Pitches of all teeth, and run-out.
    Pitch,
    /// Changes of machine settings by the nodes of one iteration.
    Correction,
    /// Changes of machine settings by all teeth that were measured.
    GearCorrection,
    /// Measurand of the nodes, added or changed after they were measured.
    Measurand,
    /// The changes that were entered on the machine after a correction.
    Applied,
}

names! {
    RecordKind {
        Curve "curve", Surface "surface", Deviations "deviations", Evaluation "evaluation", Pitch "pitch",
        Correction "correction", GearCorrection "gear_correction", Measurand "measurand", Applied "applied",
    }
}

/// A record built, on its way to be stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordDraft {
    pub kind: RecordKind,
    /// The contract's name of the method that built it.
    pub method: String,
    /// The request: a JSON document.
    pub request: Arc<str>,
    /// The response: a JSON document.
    pub result: Arc<str>,
    /// The gear of the job, of records that refer to one: a JSON document. (The job's may be
    /// changed later.)
    pub gear: Option<Arc<str>>,
    /// Class found by an evaluation.
    pub class: Option<u8>,
    /// New flank, tooth, axes and accepted units: a JSON document.
    pub measurand: Option<Arc<str>>,
}

/// A record with its id and time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    pub id: Uuid,
    pub created_at: Timestamp,
    /// The actor, where one is known.
    pub by: Option<Arc<str>>,
    pub draft: RecordDraft,
}

impl Record {
    /// Returns the bytes that it adds to the log of a database, roughly.
    pub fn bytes(&self) -> usize {
        self.draft.request.len() + self.draft.result.len()
    }
}

/// A stored record in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordSummary {
    pub id: Uuid,
    pub kind: RecordKind,
    pub method: String,
    pub created_at: Timestamp,
    /// The actor, where one is known.
    pub by: Option<Arc<str>>,
    /// New flank, tooth, axes and accepted units: a JSON document.
    pub measurand: Option<Arc<str>>,
}
