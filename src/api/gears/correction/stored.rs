//! A kept correction beside what the machine made of it.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    applied::AppliedChangesBody,
    chosen::{changed_by_fits, to_compare},
    figure_changes::FigureChangesBody,
    include::CorrectionInclude,
    kept_result::StoredResult,
    request::{self, Job, Kept, Read},
    result::CorrectionBody,
    same_nodes::{Measured, same_nodes},
    sensitivity::Level,
};
use crate::{
    api::{
        faults::Faults,
        gears::{
            evaluation::request::figure_terms,
            gear::{GearBody, of_text},
        },
        json::{gather::gathered, text::Moment, writer},
        problem::Problem,
        warning::WarningBody,
    },
    jobs::Record,
};
pub use flankfit_engine::gear::correction::Verdict as VerdictName;
use flankfit_engine::{
    estimation::{FitError, Unconverged},
    gear::{
        Gear,
        correction::{Answer, Comparison, Correction, CorrectionSpec, Scatter, compare, compare_figures},
        evaluation::tooth_shift::ToothShift,
    },
};

/// A correction and its answer.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = KeptCorrection)]
pub struct StoredCorrectionBody {
    /// UUIDv7 of the record.
    pub id: Uuid,
    /// `matrix`, or the machine.
    pub method: String,
    /// When the correction was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The gear that the job had then, of which `result` and `answer` are; left out where it had
    /// none.
    pub gear: Option<GearBody>,
    /// As it was posted; what it says node by node when `nodes` was included.
    #[schema(value_type = Object)]
    pub request: serde_json::Value,
    pub result: CorrectionBody<'static>,
    /// What was entered on the machine, where it was said; the newest entry. `answer` is compared
    /// with these changes then, and with those of `result` otherwise.
    pub applied: Option<AppliedChangesBody>,
    /// What the next iteration of the same flank and tooth measured; left out before there is one.
    pub answer: Option<MachineAnswerBody>,
    /// Why the next iteration cannot be compared.
    pub not_compared: Option<String>,
    /// Whether teeth were numbered otherwise after the correction; there where pitches are kept
    /// with an iteration before it and with one after it. The newest of each are taken.
    pub tooth_shift: Option<ToothShift>,
    /// What `result` and its parts warn of, each with `at`.
    pub warnings: Vec<WarningBody>,
}

/// Predicted beside measured, over the nodes that are defined before, predicted and after.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MachineAnswer)]
pub struct MachineAnswerBody {
    /// Number of the iteration that measured it; of a gear the last of `iterations`.
    pub iteration: u32,
    /// Of a gear: the iterations of the round after the correction, whose mean is compared.
    pub iterations: Option<Vec<u32>>,
    /// How many nodes were compared.
    pub nodes: usize,
    /// Root mean square of the deviations that the correction was made for.
    pub rms_before_um: f64,
    /// Root mean square of the deviations predicted for the changes that were entered, here and
    /// below: those of `applied`, else those of the correction.
    pub rms_predicted_um: f64,
    /// Root mean square of the deviations that were measured after it.
    pub rms_measured_um: f64,
    /// Of predicted minus before.
    pub rms_predicted_change_um: f64,
    /// Of measured minus predicted.
    pub rms_difference_um: f64,
    /// What noise and the uncertainty of the sensitivity let expect of it.
    pub rms_expected_difference_um: f64,
    /// How much of the predicted change came, without what the noise of the first measurement puts
    /// into it through the correction; left out where it is not distinguishable from none at all
    /// (standard error above 0.3).
    pub response_ratio: Option<f64>,
    /// Of the noise of both measurements, and of errors of the sensitivity that its settings have
    /// as a whole.
    pub response_ratio_std_error: Option<f64>,
    /// `[low, high]` of the share that came, at 0.95 by that standard error (Student's t where the
    /// noise was estimated). It is rather too wide: it held in 0.97 and more of simulated
    /// corrections (docs/explanation/intervals.md).
    #[schema(min_items = 2, max_items = 2)]
    pub response_ratio_interval: Option<[f64; 2]>,
    /// Of measured minus predicted against noise and all that errors of the sensitivity explain,
    /// and its quantile of 0.999.
    pub chi_squared: f64,
    /// The quantile of 0.999 that it is held against.
    pub chi_squared_limit: f64,
    pub verdict: VerdictName,
    /// The verdict in words.
    pub sentence: String,
    /// Of every node; `null` where undefined. Present when `nodes` was included.
    pub predicted_um: Option<Vec<Option<f64>>>,
    /// Of every node; `null` where undefined. Present when `nodes` was included.
    pub measured_um: Option<Vec<Option<f64>>>,
    /// Figures before, predicted and measured with their errors, and how much they changed; left
    /// out where the nodes do not tell them.
    pub figure_changes: Option<FigureChangesBody>,
    /// Of a gear: the figures of each flank that was measured again, in place of `figure_changes`.
    /// Their errors hold the scatter of the teeth.
    pub flanks: Option<SidedChangesBody>,
}

/// Changes of the figures of each flank.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SidedFigureChanges)]
pub struct SidedChangesBody {
    pub left: Option<FigureChangesBody>,
    pub right: Option<FigureChangesBody>,
}

#[skip_serializing_none]
#[derive(Serialize)]
struct Written<'a> {
    id: Uuid,
    method: &'a str,
    created_at: Moment,
    gear: Option<Box<RawValue>>,
    request: Box<RawValue>,
    result: Box<RawValue>,
    applied: Option<AppliedChangesBody>,
    answer: Option<MachineAnswerBody>,
    not_compared: Option<String>,
    tooth_shift: Option<ToothShift>,
    warnings: [(); 0],
}

/// What was measured after the corrected iteration.
pub enum After {
    Nothing,
    /// Iterations of other flanks or teeth only; the first of them.
    Others(u32),
    /// The first iteration of the same flank and tooth.
    Same(Box<Measured>),
}

/// The answer to who asks for a kept correction. `applied` is what was entered after it; `today` is
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
            let why = format!("no later iteration says that it is of {of}; the next is iteration {number}");
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
    whole(record, applied, compared, tooth_shift, include)
}

/// Returns why an iteration is not compared whose units are implausible.
pub(super) fn implausible(measured: &Measured) -> Option<String> {
    Some(format!("iteration {}: {}", measured.number, measured.implausible()?))
}

/// A kept correction with the answer of the machine, or why there is none.
pub(super) fn whole(
    record: &Record,
    applied: Option<AppliedChangesBody>,
    (answer, not_compared): (Option<MachineAnswerBody>, Option<String>),
    tooth_shift: Option<ToothShift>,
    include: CorrectionInclude,
) -> Result<Vec<u8>, Problem> {
    let raw = |text| RawValue::from_string(text).map_err(Problem::internal);
    let written = Written {
        id: record.id,
        method: &record.draft.method,
        created_at: Moment(record.created_at),
        gear: record.draft.gear.as_ref().map(|gear| raw(gear.to_string())).transpose()?,
        request: raw(include.of_request(&record.draft.request)?)?,
        result: raw(include.of_result(&record.draft.result)?)?,
        applied,
        answer,
        not_compared,
        tooth_shift,
        warnings: [],
    };
    writer::whole(&written).map(gathered).map_err(Problem::not_finite)
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
    let (earlier, later) = match (made.read(&[before], Level::Iteration)?, made.read(&[after], Level::Iteration)?) {
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
            "the traces of iteration {number} have a zero each, the heights of the corrected one have not"
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
        let figure_changes = figure_changes.map(|changes| changed_by_fits(changes, &fitted[0], &fitted[1]).into());
        let body = MachineAnswerBody::new(answer, number, &predicted, &measured);
        MachineAnswerBody { figure_changes, ..body }
    }))
}

/// A kept correction, to be computed again.
pub(super) struct Made<'a> {
    record: &'a Record,
    pub result: StoredResult,
    own_gear: Option<Gear>,
    today: Option<&'a Gear>,
    kept: Kept,
}

/// What was measured after a correction.
pub(super) struct Later {
    /// At the nodes of the correction; NaN where nothing was measured.
    pub measured: Vec<f64>,
    /// Of the difference from what the correction was made for.
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
        let result: StoredResult = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
        if result.settings.iter().all(|setting| setting.change == 0.0) {
            return Ok(Err("the correction changed nothing".to_owned()));
        }
        // the job may require something else by now
        let kept = Kept {
            target: result.target.as_ref().and_then(|target| target.deviation_um.clone()),
            terms: figure_terms(result.direction, result.reference),
            left: result.settings.iter().filter(|setting| setting.left.is_some()).map(|s| s.name.clone()).collect(),
        };
        Ok(Ok(Made { record, result, own_gear, today, kept }))
    }

    pub fn gear(&self) -> Option<&Gear> {
        self.own_gear.as_ref().or(self.today)
    }

    /// The request with these iterations.
    pub fn read(&self, measured: &[&Measured], level: Level) -> Result<Result<Read, String>, Problem> {
        let job = Job::Kept(&self.kept);
        let read = request::read(self.record.draft.request.as_bytes(), measured, level, self.gear(), job)?;
        Ok(read.map_err(|faults| first(&faults)))
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
                "the gear of the job has changed since, and the one before was not kept with the correction".to_owned()
            );
        }
        let Some(mut noise) = solution.noise else {
            return Err("the noise is not known: as many settings as nodes, and no `noise_sigma_um`".to_owned());
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
        let predicted = correction.predict(&change).deviation;
        let comparison = Comparison { scatter, ..correction.comparison(&change, leverage, noise, measured.clone()) };
        let answer = compare(&comparison).map_err(why)?;
        Ok(Judged { answer, predicted, before: correction.asked().deviation.clone(), measured })
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

/// Whether a correction comes out as it was told, but for rounding.
fn same_changes(result: &[f64], again: impl Iterator<Item = f64>) -> bool {
    let size = result.iter().fold(0.0f64, |size, change| size.max(change.abs()));
    result.iter().zip(again).all(|(result, again)| (result - again).abs() <= 1e-6 * size)
}

pub(super) fn first(faults: &Faults) -> String {
    faults.list().first().map_or_else(String::new, |fault| fault.detail.clone())
}

/// The first thing that stands in the way.
fn why(error: FitError) -> String {
    error.faults().map_or_else(|| error.to_string(), |faults| faults.list()[0].message.clone())
}

impl MachineAnswerBody {
    pub(super) fn new(answer: Answer, iteration: u32, predicted: &[f64], measured: &[f64]) -> Self {
        let defined = |list: &[f64]| list.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect();
        MachineAnswerBody {
            iteration,
            iterations: None,
            nodes: answer.nodes,
            rms_before_um: answer.before_rms,
            rms_predicted_um: answer.predicted_rms,
            rms_measured_um: answer.measured_rms,
            rms_predicted_change_um: answer.predicted_change_rms,
            rms_difference_um: answer.difference_rms,
            rms_expected_difference_um: answer.expected_difference_rms,
            response_ratio: answer.response_ratio,
            response_ratio_std_error: answer.response_ratio_std_error,
            response_ratio_interval: answer.response_ratio_interval,
            chi_squared: answer.chi_squared,
            chi_squared_limit: answer.chi_squared_limit,
            verdict: answer.verdict,
            sentence: answer.sentence,
            predicted_um: Some(defined(predicted)),
            measured_um: Some(defined(measured)),
            figure_changes: None,
            flanks: None,
        }
    }
}
