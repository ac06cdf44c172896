//! A kept correction beside what the machine made of it.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    correction::{CorrectionBody, FlankFiguresBody, PredictedBody},
    correction_include::CorrectionInclude,
    correction_request,
    iteration_nodes::deviations,
};
use crate::{
    api::{measurand::AxesBody, problem::Problem, text::Moment},
    estimation::{FitError, Nodes},
    gear::{
        Gear,
        correction::{Answer, Comparison, DEFAULT_RESPONSE_UNCERTAINTY, Verdict, compare},
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
    /// How much of the predicted change came; left out where it is not told from none at all (standard error above 0.3).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_ratio: Option<f64>,
    /// Of noise, and of errors of the sensitivity that its settings have as a whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_ratio_std_error: Option<f64>,
    /// Of measured minus predicted, and its quantile of 0.999.
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
    /// Noise or the uncertainty of the sensitivity are so great against the predicted change that nothing can be told.
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

/// What of a request decides how it is compared.
#[derive(Deserialize)]
struct Noise {
    noise_sigma_um: Option<f64>,
    response_uncertainty: Option<f64>,
}

/// The parts of a stored result that are looked at again.
#[derive(Deserialize)]
struct Told {
    predicted: PredictedBody,
    result: Fitted,
}

#[derive(Deserialize)]
struct Fitted {
    residuals: Scatter,
}

#[derive(Deserialize)]
struct Scatter {
    sigma: Option<f64>,
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
        After::Same(number, measured) => match answer(record, before, *number, measured)? {
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
    serde_json::to_vec(&written).map_err(Problem::internal)
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
) -> Result<Result<MachineAnswerBody, String>, Problem> {
    let noise: Noise = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
    let told: Told = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    if !same_places(&before.nodes, &after.nodes) {
        return Ok(Err(format!("iteration {number} has its nodes at other places")));
    }
    let Some(noise_sigma) = noise.noise_sigma_um.or(told.result.residuals.sigma) else {
        return Ok(Err("the noise is not known: as many settings as nodes, and no `noise_sigma_um`".to_owned()));
    };
    let (before, after) = match (before.deviations(), after.deviations()) {
        (Ok(before), Ok(after)) => (before, after),
        (Err(why), _) | (_, Err(why)) => return Ok(Err(why)),
    };
    let numbers = |list: Option<Vec<Option<f64>>>| {
        list.unwrap_or_default().iter().map(|x| x.unwrap_or(f64::NAN)).collect::<Vec<f64>>()
    };
    let comparison = Comparison {
        before,
        predicted: numbers(told.predicted.deviation_um),
        measured: after,
        noise_sigma,
        uncertainty: Some(numbers(told.predicted.uncertainty_um)),
        response_uncertainty: noise.response_uncertainty.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY),
    };
    match compare(&comparison) {
        Ok(answer) => Ok(Ok(MachineAnswerBody::new(answer, number, &comparison))),
        Err(FitError::Invalid(faults)) => {
            let why = faults.list().first().map_or_else(String::new, |fault| fault.detail.clone());
            Ok(Err(why))
        }
        Err(other) => Ok(Err(other.to_string())),
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
    fn new(answer: Answer, iteration: u32, comparison: &Comparison) -> Self {
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
            predicted_um: Some(defined(&comparison.predicted)),
            measured_um: Some(defined(&comparison.measured)),
            figures: None,
        }
    }
}
