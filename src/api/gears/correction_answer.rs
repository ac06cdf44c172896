//! A kept correction beside what the machine made of it.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    correction::{CorrectionBody, FlankFiguresBody},
    correction_include::CorrectionInclude,
    correction_request,
    iteration_nodes::deviations,
};
use crate::{
    api::{json_writer, measurand::AxesBody, problem::Problem, text::Moment},
    estimation::{FitError, Nodes},
    gear::{
        Gear,
        correction::{Answer, Correction, Verdict, compare},
    },
    jobs::{Measurand, Record},
};

/// A correction and its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = KeptCorrection)]
pub struct KeptCorrectionBody {
    /// UUIDv7 of the record.
    pub id: Uuid,
    /// `matrix`, or the machine.
    pub method: String,
    /// When the correction was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// As it was posted; what it says node by node when `nodes` was included.
    #[schema(value_type = Object)]
    pub request: serde_json::Value,
    pub result: CorrectionBody,
    /// What the next iteration of the same flank and tooth measured; left out before there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer: Option<MachineAnswerBody>,
    /// Why the next iteration cannot be compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_compared: Option<String>,
}

/// Predicted beside measured, over the nodes that are defined before, predicted and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MachineAnswer)]
pub struct MachineAnswerBody {
    /// Number of the iteration that measured it.
    pub iteration: u32,
    /// How many nodes were compared.
    pub nodes: usize,
    /// Root mean square of the deviations that the correction was made for.
    pub rms_before_um: f64,
    /// Root mean square of the deviations that it predicted.
    pub rms_predicted_um: f64,
    /// Root mean square of the deviations that were measured after it.
    pub rms_measured_um: f64,
    /// Of predicted minus before.
    pub rms_predicted_change_um: f64,
    /// Of measured minus predicted.
    pub rms_difference_um: f64,
    /// What noise and the uncertainty of the sensitivity let expect of it.
    pub rms_expected_difference_um: f64,
    /// How much of the predicted change came, without what the noise of the first measurement puts into it through the correction; left out
    /// where it is not told from none at all (standard error above 0.3).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_ratio: Option<f64>,
    /// Of the noise of both measurements, and of errors of the sensitivity that its settings have as a whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_ratio_std_error: Option<f64>,
    /// Of measured minus predicted against noise and all that errors of the sensitivity explain, and its quantile of 0.999.
    pub chi_squared: f64,
    /// The quantile of 0.999 that it is held against.
    pub chi_squared_limit: f64,
    pub verdict: VerdictName,
    /// The verdict in words.
    pub sentence: String,
    /// Of every node; `null` where undefined. Present when `nodes` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_um: Option<Vec<Option<f64>>>,
    /// Of every node; `null` where undefined. Present when `nodes` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_um: Option<Vec<Option<f64>>>,
    /// What the evaluation of the measured flank says, beside `result.predicted.figures`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<FlankFiguresBody>,
}

/// How the machine answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MachineVerdict)]
pub enum VerdictName {
    /// As far as noise and the uncertainty of the sensitivity allow.
    AsPredicted,
    /// A part of the predicted change came.
    Weaker,
    /// More of the predicted change came.
    Stronger,
    /// What came is no multiple of what was predicted.
    Different,
    /// Noise or the uncertainty of the sensitivity are so great against the predicted change that an answer is not told from none.
    Undecided,
}

impl From<Verdict> for VerdictName {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::AsPredicted => VerdictName::AsPredicted,
            Verdict::Weaker => VerdictName::Weaker,
            Verdict::Stronger => VerdictName::Stronger,
            Verdict::Different => VerdictName::Different,
            Verdict::Undecided => VerdictName::Undecided,
        }
    }
}

/// The parts of a stored result that are looked at again: what was to be changed.
#[derive(Deserialize)]
struct Told {
    settings: Vec<Changed>,
}

#[derive(Deserialize)]
struct Changed {
    change: f64,
}

#[derive(Serialize)]
struct Written<'a> {
    id: Uuid,
    method: &'a str,
    created_at: Moment,
    request: Box<RawValue>,
    result: Box<RawValue>,
    #[serde(skip_serializing_if = "Option::is_none")]
    answer: Option<MachineAnswerBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    not_compared: Option<String>,
}

/// Nodes with what they are of.
pub struct Measured {
    pub nodes: Nodes,
    pub measurand: Measurand,
}

/// What was measured after the corrected iteration.
pub enum After {
    Nothing,
    /// Iterations of other flanks or teeth only; the first of them.
    Others(u32),
    /// The first iteration of the same flank and tooth.
    Same(u32, Measured),
}

impl Measured {
    /// µm, positive where material stands out; or why nobody can say.
    fn deviations(&self) -> Result<Vec<f64>, String> {
        Ok(deviations(&self.nodes, AxesBody::of(&self.measurand).deviation_factor()?))
    }
}

/// The answer to who asks for a kept correction; `gear` is that of the job. Processor work.
pub fn write(
    record: &Record,
    before: &Measured,
    after: &After,
    gear: Option<&Gear>,
    include: CorrectionInclude,
) -> Result<Vec<u8>, Problem> {
    let raw = |text| RawValue::from_string(text).map_err(Problem::internal);
    let (answer, not_compared) = match after {
        After::Nothing => (None, None),
        After::Others(number) => {
            let of = before.measurand.words();
            let why = format!("no later iteration says that it is of {of}; the next is iteration {number}");
            (None, Some(why))
        }
        After::Same(number, measured) => match answer(record, before, *number, measured, gear)? {
            Ok(mut answer) => {
                answer.figures = figures(record, measured, gear);
                if !include.nodes {
                    (answer.predicted_um, answer.measured_um) = (None, None);
                }
                (Some(answer), None)
            }
            Err(why) => (None, Some(why)),
        },
    };
    let written = Written {
        id: record.id,
        method: &record.draft.method,
        created_at: Moment(record.created_at),
        request: raw(include.of_request(&record.draft.request)?)?,
        result: raw(include.of_result(&record.draft.result)?)?,
        answer,
        not_compared,
    };
    json_writer::whole(&written).map_err(Problem::not_finite)
}

/// Figures of the flank that a machine made; `None` for a matrix, whose nodes may lie anywhere.
fn figures(record: &Record, after: &Measured, gear: Option<&Gear>) -> Option<FlankFiguresBody> {
    let Measured { nodes, measurand } = after;
    let read = correction_request::read(record.draft.request.as_bytes(), nodes, measurand, gear).ok()?.ok()?;
    read.flank?.figures(&read.asked.deviation, read.asked.weight.as_deref()).map(Into::into)
}

fn answer(
    record: &Record,
    before: &Measured,
    number: u32,
    after: &Measured,
    gear: Option<&Gear>,
) -> Result<Result<MachineAnswerBody, String>, Problem> {
    if !same_places(&before.nodes, &after.nodes) {
        return Ok(Err(format!("iteration {number} has its nodes at other places")));
    }
    let told: Told = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    let change: Vec<f64> = told.settings.iter().map(|setting| setting.change).collect();
    // the request says what the sensitivity is, and how the changes follow the noise of the deviations
    let again = correction_request::read(record.draft.request.as_bytes(), &before.nodes, &before.measurand, gear)?
        .map_err(FitError::Invalid)
        .and_then(|read| Ok(Correction::new(read.asked)?))
        .and_then(|correction| Ok((correction.solve()?, correction)));
    let (solution, correction) = match again {
        Ok(again) => again,
        Err(error) => return Ok(Err(why(error))),
    };
    if solution.settings.len() != change.len() {
        return Ok(Err("the gear of the job has changed since: its machine has other settings".to_owned()));
    }
    let Some(noise) = solution.noise else {
        return Ok(Err("the noise is not known: as many settings as nodes, and no `noise_sigma_um`".to_owned()));
    };
    let measured = match after.deviations() {
        Ok(measured) => measured,
        Err(why) => return Ok(Err(why)),
    };
    let predicted = correction.predict(&change).deviation;
    match compare(&correction.comparison(&change, solution.leverage, noise, measured.clone())) {
        Ok(answer) => Ok(Ok(MachineAnswerBody::new(answer, number, &predicted, &measured))),
        Err(error) => Ok(Err(why(error))),
    }
}

/// The first thing that stands in the way.
fn why(error: FitError) -> String {
    match error {
        FitError::Invalid(faults) => faults.list().first().map_or_else(String::new, |fault| fault.detail.clone()),
        other => other.to_string(),
    }
}

/// Whether two iterations measured the same nodes.
fn same_places(a: &Nodes, b: &Nodes) -> bool {
    match (a, b) {
        (Nodes::Curve(a), Nodes::Curve(b)) => a.x == b.x,
        (Nodes::Scattered(a), Nodes::Scattered(b)) => a.u == b.u && a.v == b.v,
        (Nodes::Grid(a), Nodes::Grid(b)) => a.u == b.u && a.v == b.v,
        (Nodes::Matrix(a), Nodes::Matrix(b)) => a.x == b.x,
        _ => false,
    }
}

impl MachineAnswerBody {
    fn new(answer: Answer, iteration: u32, predicted: &[f64], measured: &[f64]) -> Self {
        let defined = |list: &[f64]| list.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect();
        MachineAnswerBody {
            iteration,
            nodes: answer.nodes,
            rms_before_um: answer.before_rms,
            rms_predicted_um: answer.predicted_rms,
            rms_measured_um: answer.measured_rms,
            rms_predicted_change_um: answer.predicted_change_rms,
            rms_difference_um: answer.difference_rms,
            rms_expected_difference_um: answer.expected_difference_rms,
            response_ratio: answer.response_ratio,
            response_ratio_std_error: answer.response_ratio_std_error,
            chi_squared: answer.chi_squared,
            chi_squared_limit: answer.chi_squared_limit,
            verdict: answer.verdict.into(),
            sentence: answer.sentence,
            predicted_um: Some(defined(predicted)),
            measured_um: Some(defined(measured)),
            figures: None,
        }
    }
}
