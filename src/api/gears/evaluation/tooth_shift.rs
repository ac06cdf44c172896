//! The shift of tooth numbers between two measurements of a gear.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::pitch::PitchEvaluationBody;
use crate::{api::problem::Problem, jobs::Record};
use flankfit_engine::gear::evaluation::tooth_shift::{SinglePitches, ToothShift, tooth_shift};

/// By how many teeth the numbers after a correction are shifted against those before it, found by
/// the correlation of the single pitch deviations. It is determined where `correlation` is clearly
/// greater than `next_correlation`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ToothShift)]
pub struct ToothShiftBody {
    /// Tooth k before is tooth k + `teeth` after, counted around the gear.
    pub teeth: i64,
    /// Of the single pitch deviations before and after, at this shift; at most 1.
    pub correlation: f64,
    /// The greatest one at any other shift.
    pub next_correlation: f64,
    /// Without a shift.
    pub unshifted_correlation: f64,
}

impl From<ToothShift> for ToothShiftBody {
    fn from(found: ToothShift) -> Self {
        ToothShiftBody {
            teeth: found.teeth,
            correlation: found.correlation,
            next_correlation: found.next,
            unshifted_correlation: found.unshifted,
        }
    }
}

impl ToothShiftBody {
    /// Returns the shift between two kept evaluations of pitches; `None` where they tell none.
    pub fn between(before: &Record, after: &Record) -> Result<Option<Self>, Problem> {
        let read = |record: &Record| serde_json::from_str(&record.draft.result).map_err(Problem::internal);
        let [before, after]: [PitchEvaluationBody; 2] = [read(before)?, read(after)?];
        Ok(tooth_shift(single(&before), single(&after)).map(Into::into))
    }
}

fn single(found: &PitchEvaluationBody) -> SinglePitches<'_> {
    [&found.left, &found.right].map(|flank| Some(flank.as_ref()?.single_pitch_deviation_um.as_slice()))
}
