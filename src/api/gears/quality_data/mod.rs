//! Evaluations of traces and of pitches as quality data (`.dfq`), for statistical process control.

mod kept;
mod list;
mod part;
mod pitch;
mod traces;

use jiff::Timestamp;
use serde::Deserialize;

use super::{
    evaluation::{self, answer::EvaluationBody, pitch::PitchEvaluationBody},
    gear::{GearBody, of_text},
};
use crate::{
    api::{
        problem::{Problem, ProblemCode},
        shapes::export::utc,
    },
    jobs::RecordKind,
};
use flankfit_engine::{
    formats::qdas::{self, Measurement},
    gear::Gear,
};

pub use flankfit_engine::formats::qdas::{Charset, MEDIA_TYPE};
pub use kept::Kept;

/// The tag of a job whose value is its batch.
const BATCH: &str = "batch";

/// The required part of a request: for an import the gear is in the description of the file.
#[derive(Default, Deserialize)]
struct Asked {
    #[serde(default)]
    gear: Option<GearBody>,
    #[serde(default)]
    spec: Option<Of>,
}

#[derive(Deserialize)]
struct Of {
    #[serde(default)]
    gear: Option<GearBody>,
}

impl Asked {
    fn gear(self) -> Option<Gear> {
        let gear = self.gear.or(self.spec.and_then(|spec| spec.gear))?;
        gear.checked("/gear").ok()
    }
}

/// Whether records of a kind can be written.
pub fn is_quality_data(kind: RecordKind) -> bool {
    matches!(kind, RecordKind::Evaluation | RecordKind::Pitch)
}

/// Evaluates the traces of a request and writes what it finds. Processor work.
pub fn of_traces(text: &[u8], now: Timestamp) -> Result<Vec<u8>, Problem> {
    let found = evaluation::build(text, None, None, None)?.result;
    write(&of_request(text), RecordKind::Evaluation, &found, None, now)
}

/// Evaluates the pitches of a request and writes what it finds. Processor work.
pub fn of_pitches(text: &[u8], now: Timestamp) -> Result<Vec<u8>, Problem> {
    let found = evaluation::pitch::build(text, None, None, None)?.result;
    write(&of_request(text), RecordKind::Pitch, &found, None, now)
}

/// Writes a kept evaluation. Processor work.
pub fn of_record(kept: &Kept) -> Result<Vec<u8>, Problem> {
    let Kept { record, details, .. } = kept;
    let kind = record.draft.kind;
    if !is_quality_data(kind) {
        return Err(not_written(kind));
    }
    let own = record.draft.gear.as_deref().map(of_text).transpose()?;
    let gear = of_request(record.draft.request.as_bytes()).or(own);
    let at = details.measured_at.unwrap_or(record.created_at);
    write(&gear, kind, record.draft.result.as_bytes(), Some(kept), at)
}

/// Returns the problem if only quality data is acceptable.
pub fn not_written(kind: RecordKind) -> Problem {
    let detail = format!(
        "This record is a {}; only evaluations and pitches are available as {MEDIA_TYPE}, others as application/json.",
        kind.name()
    );
    Problem::new(ProblemCode::NotAcceptable, detail)
}

fn of_request(text: &[u8]) -> Option<Gear> {
    serde_json::from_slice::<Asked>(text).unwrap_or_default().gear()
}

/// Writes a record by its kind.
fn write(
    gear: &Option<Gear>,
    kind: RecordKind,
    found: &[u8],
    kept: Option<&Kept>,
    at: Timestamp,
) -> Result<Vec<u8>, Problem> {
    let characteristics = match kind {
        RecordKind::Evaluation => {
            let found: EvaluationBody = serde_json::from_slice(found).map_err(Problem::internal)?;
            traces::characteristics(&found, gear.as_ref())
        }
        RecordKind::Pitch => {
            let found: PitchEvaluationBody = serde_json::from_slice(found).map_err(Problem::internal)?;
            pitch::characteristics(&found)
        }
        other => return Err(not_written(other)),
    };
    let job = kept.map(|kept| &kept.job);
    let remark = |kept: &Kept| format!("job {}, iteration {}, record {}", kept.job.id, kept.number, kept.record.id);
    let measured = Measurement {
        at: utc(at),
        batch: job.and_then(|job| job.tags.get(BATCH)).cloned(),
        remark: kept.map(remark),
        serial_number: job.and_then(|job| job.serial_number.clone()),
    };
    let part = part::part(gear.as_ref(), kept);
    let text = qdas::write(&part, &characteristics, &measured).map_err(Problem::internal)?;
    Ok(qdas::encode(&text))
}
