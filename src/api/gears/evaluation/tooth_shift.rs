//! The shift of tooth numbers between two measurements of a gear.

use super::pitch::PitchEvaluationBody;
use crate::{api::problem::Problem, jobs::Record};
use flankfit_engine::gear::evaluation::tooth_shift::{SinglePitches, ToothShift, tooth_shift};

/// Returns the shift between two stored evaluations of pitches; `None` if they do not determine it.
pub fn between(before: &Record, after: &Record) -> Result<Option<ToothShift>, Problem> {
    let read = |record: &Record| serde_json::from_str(&record.draft.result).map_err(Problem::internal);
    let [before, after]: [PitchEvaluationBody; 2] = [read(before)?, read(after)?];
    Ok(tooth_shift(single(&before), single(&after)))
}

fn single(found: &PitchEvaluationBody) -> SinglePitches<'_> {
    [&found.left, &found.right].map(|flank| Some(flank.as_ref()?.single_pitch_deviation_um.as_slice()))
}
