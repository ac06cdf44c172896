//! A stored correction with the answer of the machine.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    applied::AppliedChangesBody,
    chosen::{changed_by_fits, to_compare},
    figures::SidedBody,
    include::CorrectionInclude,
    request::{CorrectionRequestBody, Job, Read},
    result::CorrectionResultBody,
    same_nodes::{Measured, same_nodes},
    sensitivity::Level,
};
use crate::{
    api::{
        faults::Faults,
        gears::gear::{GearBody, of_text},
        json::{gather::gathered, raw::Raw, text::Moment, writer},
        problem::Problem,
        warning::WarningBody,
    },
    jobs::{Record, RecordKind},
};
use flankfit_engine::{
    estimation::{FitError, Unconverged},
    gear::{
        Gear,
        correction::{Answer, Comparison, Correction, CorrectionSpec, FigureChange, Scatter, compare, compare_figures},
        evaluation::{flank_surface::FlankFigures, tooth_shift::ToothShift},
    },
};

/// A correction. The response to the request that made it has no `answer` yet.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Correction)]
pub struct CorrectionBody {
    /// UUIDv7 of the record.
    pub id: Uuid,
    pub kind: RecordKind,
    /// `matrix`, or the machine.
    pub method: String,
    /// When the correction was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller; absent where no key was required.
    pub by: Option<String>,
    /// The gear of the job at that time, which `result` and `answer` refer to; absent where it had
    /// none.
    #[schema(value_type = Option<GearBody>)]
    pub gear: Option<Raw<GearBody>>,
    /// The request as posted, without members that are `null`. Unless `nodes` was included, it
    /// lacks `trace`, `weight`, a `target` with `deviation_um`, and the `matrix` of `sensitivity`.
    /// To send it again, include `nodes`.
    #[schema(value_type = Object)]
    pub request: Raw<Value>,
    pub result: CorrectionResultBody,
    /// The newest entry of changes made on the machine, if there is one. `answer` is then computed
    /// with these changes, otherwise with those of `result`.
    pub applied: Option<AppliedChangesBody>,
    /// Result of the next iteration of the same flank and tooth; absent before there is one.
    pub answer: Option<MachineAnswerBody>,
    /// Why the next iteration cannot be compared.
    pub not_compared: Option<String>,
    /// Shift of the tooth numbers after the correction; present if pitches are stored with an
    /// iteration before it and with one after it. The newest of each are used.
    pub tooth_shift: Option<ToothShift>,
    /// Warnings of `result` and its parts, each with `at`.
    pub warnings: Vec<WarningBody>,
}

/// Comparison of prediction and measurement over the nodes that are defined before, predicted and
/// after.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MachineAnswer)]
pub struct MachineAnswerBody {
    /// Number of the iteration that measured it; for a gear the last of `iterations`.
    pub iteration: u32,
    /// For a gear: the iterations of the round after the correction, whose mean is compared.
    pub iterations: Option<Vec<u32>>,
    #[serde(flatten)]
    #[schema(inline)]
    pub answer: Answer,
    /// Predicted deviation of every node; `null` where undefined. Present when `nodes` was
    /// included.
    pub predicted_um: Option<Vec<Option<f64>>>,
    /// Measured deviation of every node; `null` where undefined. Present when `nodes` was included.
    pub measured_um: Option<Vec<Option<f64>>>,
    /// Figures before, predicted and measured with their errors, and their changes; absent if the
    /// nodes do not determine them.
    pub figure_changes: Option<FlankFigures<FigureChange>>,
    /// For a gear: the figures of each flank that was measured again, in place of `figure_changes`.
    /// Their errors include the scatter of the teeth.
    pub flanks: Option<SidedBody<FlankFigures<FigureChange>>>,
}

/// Measurement after the corrected iteration.
pub enum After {
    Nothing,
    /// Iterations of other flanks or teeth only; the first of them.
    Others(u32),
    /// The first iteration of the same flank and tooth.
    Same(Box<Measured>),
}

/// Returns a stored correction as JSON. `applied` is what was entered after it; `today` is
/// the gear of the job, for corrections that were kept without the gear that they were made for.
/// Processor work.
pub fn write(
    record: &Record,
    applied: Option<AppliedChangesBody>,
    before: &Measured,
    after: &After,
    tooth_shift: Option<ToothShift>,
    today: Option<&Gear>,
    include: CorrectionInclude,
) -> Result<Vec<u8>, Problem> {
    let compared = match after {
        After::Nothing => (None, None),
        After::Others(number) => {
            let of = before.measurand.words();
            let why = format!("no later iteration is of {of}; the next one is iteration {number}");
            (None, Some(why))
        }
        After::Same(measured) if measured.implausible().is_some() => (None, implausible(measured)),
        After::Same(measured) => match answer(record, applied.as_ref(), before, measured, today)? {
            Ok(mut answer) => {
                if !include.nodes {
                    (answer.predicted_um, answer.measured_um) = (None, None);
                }
                (Some(answer), None)
            }
            Err(why) => (None, Some(why)),
        },
    };
    whole(record, CorrectionResultBody::of(record)?, applied, compared, tooth_shift, include)
}

/// Returns why an iteration is not compared whose units are implausible.
pub(super) fn implausible(measured: &Measured) -> Option<String> {
    Some(format!("iteration {}: {}", measured.number, measured.implausible()?))
}

/// Returns a stored correction with the answer of the machine, or why there is none.
pub(super) fn whole(
    record: &Record,
    result: CorrectionResultBody,
    applied: Option<AppliedChangesBody>,
    (answer, not_compared): (Option<MachineAnswerBody>, Option<String>),
    tooth_shift: Option<ToothShift>,
    include: CorrectionInclude,
) -> Result<Vec<u8>, Problem> {
    let body = CorrectionBody {
        id: record.id,
        kind: record.draft.kind,
        method: record.draft.method.clone(),
        created_at: Moment(record.created_at),
        by: record.by.as_deref().map(str::to_owned),
        gear: record.draft.gear.as_deref().map(Raw::from),
        request: include.of_request(&record.draft.request).map_err(|syntax| Problem::internal(syntax.what))?.into(),
        result: include.of_result(result),
        applied,
        answer,
        not_compared,
        tooth_shift,
        warnings: Vec::new(),
    };
    writer::whole(&body).map(gathered).map_err(Problem::not_finite)
}

fn answer(
    record: &Record,
    applied: Option<&AppliedChangesBody>,
    before: &Measured,
    after: &Measured,
    today: Option<&Gear>,
) -> Result<Result<MachineAnswerBody, String>, Problem> {
    let number = after.number;
    let made = match Made::of(record, today)? {
        Ok(made) => made,
        Err(why) => return Ok(Err(why)),
    };
    let (earlier, later) = match (made.read(&[before], Level::Iteration), made.read(&[after], Level::Iteration)) {
        (Ok(earlier), Ok(later)) => (earlier, later),
        (Err(why), _) | (_, Err(why)) => return Ok(Err(why)),
    };
    let flank = |read: &Read| read.nodes.blocks.first().and_then(|block| block.flank.clone());
    let flanks = flank(&earlier).zip(flank(&later));
    if let Err(why) = same_nodes(before, after, flanks.as_ref().map(|(a, b)| [a, b]), number) {
        return Ok(Err(why));
    }
    if earlier.spec.traces.is_none() && later.spec.traces.is_some() {
        return Ok(Err(format!(
            "the traces of iteration {number} have their own zeros, the heights of the corrected one do not"
        )));
    }
    let flank = flanks.map(|(_, after)| after);
    let chosen = |read: &Read| read.nodes.blocks.first().map(|block| block.chosen.clone()).unwrap_or_default();
    let fitted = flank.as_ref().map(|flank| to_compare(flank, &chosen(&earlier), &chosen(&later))).unwrap_or_default();
    let weight = later.spec.weight.clone();
    let measured = Later { measured: later.spec.deviation.clone(), scatter: Scatter::default(), noise: 1.0 };
    Ok(made.judge(earlier.spec, applied, measured).map(|judged| {
        let Judged { answer, predicted, before, measured } = judged;
        let weight = weight.as_deref();
        let figure_changes = flank.as_ref().and_then(|flank| {
            compare_figures(&before, &predicted, &measured, |list, _| flank.estimated_figures(list, weight))
        });
        let figure_changes = figure_changes.map(|changes| changed_by_fits(changes, &fitted[0], &fitted[1]));
        let body = MachineAnswerBody::new(answer, number, &predicted, &measured);
        MachineAnswerBody { figure_changes, ..body }
    }))
}

/// A stored correction that is computed again.
pub(super) struct Made<'a> {
    record: &'a Record,
    pub request: CorrectionRequestBody,
    pub result: CorrectionResultBody,
    own_gear: Option<Gear>,
    today: Option<&'a Gear>,
}

/// Measurement after a correction.
pub(super) struct Later {
    /// At the nodes of the correction; NaN where nothing was measured.
    pub measured: Vec<f64>,
    /// Scatter of the difference from the deviations that the correction was made for.
    pub scatter: Scatter,
    /// Its noise as a multiple of that of the correction.
    pub noise: f64,
}

/// A comparison, with the deviations that were compared.
pub(super) struct Judged {
    pub answer: Answer,
    pub predicted: Vec<f64>,
    pub before: Vec<f64>,
    pub measured: Vec<f64>,
}

impl<'a> Made<'a> {
    /// `today` is the gear of the job, for corrections that were kept without theirs.
    pub fn of(record: &'a Record, today: Option<&'a Gear>) -> Result<Result<Self, String>, Problem> {
        let own_gear = record.draft.gear.as_deref().map(of_text).transpose()?;
        let request = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
        let result = CorrectionResultBody::of(record)?;
        if result.settings.iter().all(|setting| setting.change == 0.0) {
            return Ok(Err("the correction changed nothing".to_owned()));
        }
        Ok(Ok(Made { record, request, result, own_gear, today }))
    }

    pub fn gear(&self) -> Option<&Gear> {
        self.own_gear.as_ref().or(self.today)
    }

    /// Checks the request for these iterations, with the requirements of its time.
    pub fn read(&self, measured: &[&Measured], level: Level) -> Result<Read, String> {
        self.request.read(measured, level, self.gear(), Job::Kept(&self.result)).map_err(|faults| first(&faults))
    }

    /// Compares what was measured with what was predicted of the changes that were entered.
    pub fn judge(
        &self,
        earlier: CorrectionSpec,
        applied: Option<&AppliedChangesBody>,
        later: Later,
    ) -> Result<Judged, String> {
        let proposed: Vec<f64> = self.result.settings.iter().map(|setting| setting.change).collect();
        // the request says what the sensitivity is, and how the changes follow the noise of the
        // deviations
        let correction = Correction::new(earlier).map_err(|faults| first(&faults.into()))?;
        let solution = correction.solve().map_err(why)?;
        let changes = solution.settings.iter().map(|setting| setting.change);
        let of_gear = self.record.draft.method != "matrix";
        if proposed.len() != changes.len() || (of_gear && self.own_gear.is_none() && !same_changes(&proposed, changes))
        {
            return Err(
                "the gear of the job has changed since, and the previous one was not stored with the correction"
                    .to_owned(),
            );
        }
        let Some(mut noise) = solution.noise else {
            return Err(
                "the noise is not known: there are as many settings as nodes, and no `noise_sigma_um`".to_owned()
            );
        };
        noise.sigma *= later.noise;
        let entered = applied.map(|applied| applied.settings.iter().map(|setting| setting.change).collect());
        let change: Vec<f64> = entered.unwrap_or_else(|| proposed.clone());
        let leverage = match change == proposed {
            true => solution.leverage,
            false => correction
                .leverage_of(&solution, &shares(&change, &proposed))
                .ok_or_else(|| why(FitError::NotConverged(Unconverged::Comparison)))?,
        };
        let Later { measured, scatter, .. } = later;
        let predicted = correction.predict(&change).deviation_um;
        let comparison = Comparison { scatter, ..correction.comparison(&change, leverage, noise, measured.clone()) };
        let answer = compare(&comparison).map_err(why)?;
        Ok(Judged { answer, predicted, before: correction.spec().deviation.clone(), measured })
    }
}

/// How far each change that was entered follows the proposed one, and with it the noise that the
/// proposal was computed from.
fn shares(entered: &[f64], proposed: &[f64]) -> Vec<f64> {
    let share = |(entered, proposed): (&f64, &f64)| match *proposed {
        0.0 => 0.0,
        proposed => (entered / proposed).clamp(0.0, 1.0),
    };
    entered.iter().zip(proposed).map(share).collect()
}

/// Returns whether a correction has the same changes but for rounding.
fn same_changes(result: &[f64], again: impl Iterator<Item = f64>) -> bool {
    let size = result.iter().fold(0.0f64, |size, change| size.max(change.abs()));
    result.iter().zip(again).all(|(result, again)| (result - again).abs() <= 1e-6 * size)
}

pub(super) fn first(faults: &Faults) -> String {
    faults.list().first().map_or_else(String::new, |fault| fault.detail.clone())
}

/// Returns the first reason of a refused fit.
fn why(error: FitError) -> String {
    error.faults().map_or_else(|| error.to_string(), |faults| faults.list()[0].message.clone())
}

impl MachineAnswerBody {
    pub(super) fn new(answer: Answer, iteration: u32, predicted: &[f64], measured: &[f64]) -> Self {
        let defined = |list: &[f64]| list.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect();
        MachineAnswerBody {
            iteration,
            iterations: None,
            answer,
            predicted_um: Some(defined(predicted)),
            measured_um: Some(defined(measured)),
            figure_changes: None,
            flanks: None,
        }
    }
}
