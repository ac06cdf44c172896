//! The trace of a job as it is written: every λ* choice and every decision in the order in which they were made.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    fit_result_parts::CoefficientBody,
    fit_spec::{CriterionName, SchemeName},
    job_iterations::DecisionName,
    jobs::JobBody,
    json_writer::{Json, Object},
    records::RecordSummaryBody,
    text::Moment,
};
use crate::jobs::{Choice, FitSummary, RecordSummary, Ruling, Trace, TracedIteration};

/// The whole story of a job. Nothing in it is ever overwritten: changes of mind are new entries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Trace)]
pub struct TraceBody {
    pub job: JobBody,
    /// By number.
    pub iterations: Vec<TracedIterationBody>,
}

/// An iteration in the trace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedIteration)]
pub struct TracedIterationBody {
    pub number: u32,
    pub id: Uuid,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub measured_at: Option<Moment>,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The latest decision; absent before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionName>,
    pub fits: Vec<TracedFitBody>,
    /// Which fit stood, from when on and why; the first is made with the iteration.
    pub choices: Vec<TracedChoiceBody>,
    pub decisions: Vec<TracedDecisionBody>,
    /// What is kept beside the fits, oldest first.
    #[serde(default)]
    pub records: Vec<RecordSummaryBody>,
}

/// A fit in the trace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedFit)]
pub struct TracedFitBody {
    pub id: Uuid,
    /// Whether this fit stands.
    pub chosen: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_star: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criterion: Option<CriterionName>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeName>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub regularized_condition: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_norm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_sharp_bound: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_abs: Option<f64>,
    pub coefficients: Vec<CoefficientBody>,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// That from then on a certain fit stood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedChoice)]
pub struct TracedChoiceBody {
    pub fit_id: Uuid,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// That something was decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedDecision)]
pub struct TracedDecisionBody {
    pub decision: DecisionName,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// The trace.
pub fn trace(trace: Trace) -> Vec<u8> {
    let coefficients: usize =
        trace.iterations.iter().flat_map(|iteration| &iteration.fits).map(|fit| fit.coefficients.len() + 512).sum();
    let mut json = Json::with_capacity(1024 + coefficients);
    json.object().field("job", &JobBody::from(trace.job)).list("iterations", &trace.iterations, iteration).end();
    json.into_bytes()
}

fn iteration(object: &mut Object<'_>, iteration: &TracedIteration) {
    object
        .field("number", &iteration.number)
        .field("id", &iteration.id)
        .maybe("measured_at", iteration.measured_at.map(Moment))
        .field("created_at", &Moment(iteration.created_at))
        .maybe("decision", iteration.rulings.last().map(|ruling| ruling.decision.name()))
        .list("fits", &iteration.fits, fit)
        .list("choices", &iteration.choices, choice)
        .list("decisions", &iteration.rulings, ruling)
        .list("records", &iteration.records, record);
}

fn fit(object: &mut Object<'_>, fit: &FitSummary) {
    let figures = &fit.figures;
    object
        .field("id", &fit.id)
        .field("chosen", &fit.chosen)
        .maybe("lambda_star", figures.lambda_star)
        .maybe("criterion", figures.criterion)
        .maybe("scheme", figures.scheme)
        .maybe("count", figures.count)
        .maybe("condition", figures.condition)
        .maybe("regularized_condition", figures.regularized_condition)
        .maybe("bias_norm", figures.bias_norm)
        .maybe("bias_sharp_bound", figures.bias_sharp_bound)
        .maybe("rms", figures.rms)
        .maybe("max_abs", figures.max_abs)
        .raw("coefficients", &fit.coefficients)
        .field("created_at", &Moment(fit.event.created_at))
        .maybe("reason", fit.event.reason.as_deref());
}

fn choice(object: &mut Object<'_>, choice: &Choice) {
    object
        .field("fit_id", &choice.fit_id)
        .maybe("reason", choice.event.reason.as_deref())
        .field("created_at", &Moment(choice.event.created_at));
}

fn record(object: &mut Object<'_>, record: &RecordSummary) {
    object
        .field("id", &record.id)
        .string("kind", record.kind.name())
        .string("method", &record.method)
        .field("created_at", &Moment(record.created_at));
}

fn ruling(object: &mut Object<'_>, ruling: &Ruling) {
    object
        .field("decision", &ruling.decision.name())
        .maybe("reason", ruling.event.reason.as_deref())
        .field("created_at", &Moment(ruling.event.created_at));
}
