//! Wire types of the records of an iteration.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::amendments::MeasurandChangeBody;
use crate::{
    api::{
        built::Built,
        gears::gear::GearBody,
        json::{gather::gathered, left_out::without_nulls, raw::Raw, text::Moment, writer::text_of},
        problem::Problem,
        warning::WarningBody,
    },
    jobs::{Job, Record, RecordDraft, RecordKind, RecordSummary},
};

/// A record of an iteration: a curve, a surface, deviations, an evaluation, pitches, a correction,
/// its entered changes, or a change of the nodes' description.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = JobRecord)]
pub struct RecordBody {
    /// UUIDv7.
    pub id: Uuid,
    pub kind: RecordKind,
    /// Method, as named in the request.
    pub method: String,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller; absent where no key was required.
    pub by: Option<String>,
    /// For deviations, evaluations, pitches and corrections: the job's gear at that time. It may
    /// have changed since; a `gear` in the request has precedence.
    #[schema(value_type = Option<GearBody>)]
    pub gear: Option<Raw<GearBody>>,
    /// The request as posted, without members that are `null`. If it has no points or nodes, those
    /// of the iteration were used. For an import: `file` (its name), `file_sha256`, `file_bytes`
    /// and `spec`. For an imported evaluation also `gear`, `traces` (all of the file, with the
    /// signs of DIN) and `evaluation`, for which `POST /v1/gears/evaluate` gives the same result;
    /// for imported pitches likewise the request of `POST /v1/gears/pitch`.
    #[schema(value_type = Object)]
    pub request: Raw<Value>,
    /// The result, for example that of `POST /v1/curves`; for a correction with `nodes` and
    /// `result` only on request (`include`).
    #[schema(value_type = Object)]
    pub result: Raw<Value>,
    /// Warnings of the result and its parts, each with `at`.
    pub warnings: Vec<WarningBody>,
}

/// A record in a list.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RecordSummary)]
pub struct RecordSummaryBody {
    /// UUIDv7.
    pub id: Uuid,
    pub kind: RecordKind,
    /// Method, as named in the request.
    pub method: String,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller; absent where no key was required.
    pub by: Option<String>,
    /// For a change of the nodes' description: the values before and after it.
    pub measurand: Option<MeasurandChangeBody>,
}

impl From<RecordSummary> for RecordSummaryBody {
    fn from(record: RecordSummary) -> Self {
        RecordSummaryBody {
            id: record.id,
            kind: record.kind,
            method: record.method,
            created_at: Moment(record.created_at),
            by: record.by.map(|by| by.as_ref().to_owned()),
            measurand: record.measurand.as_deref().and_then(MeasurandChangeBody::stored),
        }
    }
}

/// Returns a record with the gear of its job, which may be changed later.
pub fn of_gear(job: &Job, kind: RecordKind, text: &[u8], built: Built) -> Result<RecordDraft, Problem> {
    let gear = job.gear.as_deref().map(Into::into);
    Ok(RecordDraft { gear, ..draft(kind, text, built)? })
}

/// Returns the draft of a record of a request, without its members that are `null`, and its
/// unchanged answer.
pub fn draft(kind: RecordKind, request: &[u8], built: Built) -> Result<RecordDraft, Problem> {
    let class = if kind == RecordKind::Evaluation { class_of(&built.result) } else { None };
    let request = str::from_utf8(request).map_err(Problem::internal)?;
    let request = without_nulls(request).map_err(|syntax| Problem::internal(syntax.what))?;
    let result = str::from_utf8(&built.result).map_err(Problem::internal)?.into();
    Ok(RecordDraft { kind, method: built.method, request, result, gear: None, class, measurand: None })
}

/// The class that an evaluation found.
fn class_of(result: &[u8]) -> Option<u8> {
    #[derive(Deserialize)]
    struct Classed {
        class: Option<u8>,
    }
    serde_json::from_slice::<Classed>(result).ok()?.class
}

/// Parts of the request and of the result of a record that are returned; all of them are stored.
#[derive(Clone)]
pub struct Shown {
    pub request: Arc<str>,
    pub result: Arc<str>,
}

/// Returns a stored record as JSON: all of it, or the parts that are `shown`.
pub fn record(record: &Record, shown: Option<&Shown>) -> Vec<u8> {
    let RecordDraft { kind, method, request, result, gear, .. } = &record.draft;
    let (request, result) = shown.map_or((request, result), |shown| (&shown.request, &shown.result));
    let body = RecordBody {
        id: record.id,
        kind: *kind,
        method: method.clone(),
        created_at: Moment(record.created_at),
        by: record.by.as_deref().map(str::to_owned),
        gear: gear.clone().map(Raw::from),
        request: Arc::clone(request).into(),
        result: Arc::clone(result).into(),
        warnings: Vec::new(),
    };
    gathered(text_of(&body).into_bytes())
}
