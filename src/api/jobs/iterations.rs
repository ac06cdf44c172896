//! Iterations of a job and their fits as they are written and read.
//!
//! Answers hold the stored answer of a fit byte for byte, so they are written by [`Object`]; the
//! structs say what is written, for the OpenAPI document and for whoever reads it back.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::{
        fits::{
            answer::result::FitResultBody,
            spec::{
                nodes::NodesBody,
                request::{CriterionName, FitSpecBody, SchemeName},
            },
        },
        json::{
            id::id,
            present::present,
            request::request,
            text::{LongText, Moment, ShortText},
            writer::{Json, Object},
        },
        measurand::{
            axes::{AxesBody, MeasurandBody},
            side::SideName,
        },
    },
    jobs::{
        Decision, FitRecord, FitSummary, Iteration, List, Measurand, MeasurementDetails, NewFit, NewIteration, Page,
        Stored,
    },
};

/// A fit request with what is known of the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = IterationRequest)]
pub struct IterationRequest {
    pub nodes: NodesBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurement: Measurement,
}

/// An iteration request as a form (`multipart/form-data`).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct IterationForm {
    /// The iteration request without `nodes`, as JSON.
    pub spec: IterationFormSpec,
    /// CSV with a header `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node.
    #[schema(value_type = String, format = Binary)]
    pub nodes: Vec<u8>,
}

/// An iteration request without nodes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct IterationFormSpec {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurement: Measurement,
}

request! {
    /// What is known of a measurement.
    #[derive(Default)]
    pub struct Measurement as MeasurementMembers, read whole {
        flatten measurand: MeasurandBody,
        flatten details: MeasurementDetailsBody,
    }
}

request! {
    /// What is known of a measurement whose nodes came as a stream. All of it may be left out, and the
    /// body with it.
    #[derive(Default, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = StreamFinish)]
    pub struct MeasurementDetailsBody as MeasurementDetailsMembers, read whole {
        /// RFC 3339, any offset; answered in UTC.
        #[schema(value_type = Option<String>, format = DateTime, example = "2026-11-21T08:30:00Z")]
        optional measured_at: Moment,
        /// What the nodes were measured with.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "P40")]
        optional instrument: ShortText,
        /// Who measured them.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
        optional operator: ShortText,
        /// What else is to be known of the measurement; may have line breaks.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
        optional note: LongText,
    }
}

impl From<MeasurementDetailsBody> for MeasurementDetails {
    fn from(body: MeasurementDetailsBody) -> Self {
        MeasurementDetails {
            measured_at: body.measured_at.map(|moment| moment.0),
            instrument: body.instrument.map(String::from),
            operator: body.operator.map(String::from),
            note: body.note.map(String::from),
        }
    }
}

/// A fit request without nodes: the stored ones are fitted again.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = RefitRequest)]
pub struct RefitRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub why: Why,
}

request! {
    /// Why something is done.
    #[derive(Default)]
    pub struct Why as WhyMembers, read whole {
        /// Kept in the trace.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
        optional reason: LongText,
    }
}

/// Which fit stands from now on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ChosenFit)]
pub struct ChosenFitBody {
    /// A fit of this iteration.
    #[serde(deserialize_with = "id")]
    pub fit_id: Uuid,
    /// Kept in the trace.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub reason: Option<LongText>,
}

/// What is done with the gear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = IterationPatch, example = json!({"decision": "remachine", "reason": "profile slope out of tolerance"}))]
pub struct IterationPatchBody {
    pub decision: DecisionName,
    /// Kept in the trace.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub reason: Option<LongText>,
}

/// What is done with the gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DecisionName {
    Accept,
    Remachine,
    Reject,
}

impl From<DecisionName> for Decision {
    fn from(name: DecisionName) -> Self {
        match name {
            DecisionName::Accept => Decision::Accept,
            DecisionName::Remachine => Decision::Remachine,
            DecisionName::Reject => Decision::Reject,
        }
    }
}

/// What was posted of an iteration, and what it was given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostedIterationBody {
    /// 1, 2, 3 … within the job.
    pub number: u32,
    /// UUIDv7.
    pub id: Uuid,
    /// The job that it belongs to.
    pub job_id: Uuid,
    /// The flank that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flank: Option<SideName>,
    /// The tooth that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tooth: Option<String>,
    /// What the axes of the nodes mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<AxesBody>,
    /// When the nodes were measured, as it was posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub measured_at: Option<Moment>,
    /// What they were measured with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
    /// Who measured them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// What else was said of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Nodes posted, missing ones included.
    pub node_count: u64,
}

/// A new iteration of a job, with its fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = NewIteration)]
pub struct NewIterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub posted: PostedIterationBody,
    /// One, which is chosen until another one is.
    pub fits: Vec<IterationFitBody>,
}

/// An iteration of a job, with the figures of the fits of its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Iteration)]
pub struct IterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub posted: PostedIterationBody,
    /// The latest decision; absent before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionName>,
    /// The last hundred fits in the order in which they were made; `GET …/fits/{fit_id}` has each
    /// in full.
    pub fits: Vec<FitSummaryBody>,
    /// How many fits were made before those; `GET …/fits` lists all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earlier_fits: Option<u64>,
}

/// A fit of an iteration's nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationFit)]
pub struct IterationFitBody {
    /// UUIDv7.
    pub id: Uuid,
    /// Whether this fit stands.
    pub chosen: bool,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Why it was made, as it was posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What was fitted, with every default filled in: a request of its own for a refit, or with
    /// nodes for a new fit.
    #[schema(value_type = FitSpecBody)]
    pub spec: serde_json::Value,
    pub result: FitResultBody,
}

/// A fit by the figures by which λ* choices are told apart at a glance. A figure that does not
/// exist is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitSummary)]
pub struct FitSummaryBody {
    /// UUIDv7.
    pub id: Uuid,
    /// Whether this fit stands.
    pub chosen: bool,
    /// The λ* of the fit; left out without regularisation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_star: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criterion: Option<CriterionName>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeName>,
    /// L: how many of the smallest eigenvalues were regularised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// Condition number of the scaled Fisher information matrix; left out where it is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// The same after regularisation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub regularized_condition: Option<f64>,
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_norm: Option<f64>,
    /// The least bound of the bias that holds within the norm limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_sharp_bound: Option<f64>,
    /// Root mean square of the residuals, in the unit of the heights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// Largest |residual|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_abs: Option<f64>,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Why it was made, as it was posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Some fits of an iteration, in the order in which they were made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitPage)]
pub struct FitPageBody {
    /// The fits of this page.
    pub items: Vec<FitSummaryBody>,
    /// Where the next page begins; absent on the last one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// A new iteration, once it has its number.
pub fn created_iteration(new: &NewIteration, stored: Stored) -> Vec<u8> {
    let mut json = Json::with_capacity(1024 + new.fit.computed.spec.len() + new.fit.computed.result.len());
    let mut object = json.object();
    object.field("number", &stored.number).field("id", &new.id).field("job_id", &new.job_id);
    measurand(&mut object, &new.measurand);
    details(&mut object, &new.details);
    object
        .field("created_at", &Moment(new.created_at))
        .field("node_count", &new.nodes.posted())
        .list("fits", [&new.fit], |object, fit| new_fit(object, fit, true))
        .end();
    json.into_bytes()
}

/// A stored iteration.
pub fn iteration(iteration: &Iteration) -> Vec<u8> {
    let mut json = Json::with_capacity(512 * (2 + iteration.fits.len()));
    let mut object = json.object();
    object.field("number", &iteration.number).field("id", &iteration.id).field("job_id", &iteration.job_id);
    measurand(&mut object, &iteration.measurand);
    details(&mut object, &iteration.details);
    object
        .field("created_at", &Moment(iteration.created_at))
        .field("node_count", &iteration.node_count)
        .maybe("decision", iteration.ruling.as_ref().map(|ruling| ruling.decision.name()))
        .list("fits", &iteration.fits, fit_summary)
        .maybe("earlier_fits", Some(iteration.earlier_fits).filter(|count| *count > 0))
        .end();
    json.into_bytes()
}

fn details(object: &mut Object<'_>, of: &MeasurementDetails) {
    object
        .maybe("measured_at", of.measured_at.map(Moment))
        .maybe("instrument", of.instrument.as_deref())
        .maybe("operator", of.operator.as_deref())
        .maybe("note", of.note.as_deref());
}

/// What nodes are of, as an iteration, a stream and the trace tell it.
pub(in crate::api) fn measurand(object: &mut Object<'_>, of: &Measurand) {
    object.maybe("flank", of.flank_name()).maybe("tooth", of.tooth.as_deref());
    if let Some(axes) = &of.axes {
        object.raw("axes", axes);
    }
}

/// A new fit of stored nodes. It is not chosen yet.
pub fn created_fit(fit: &NewFit) -> Vec<u8> {
    let mut json = Json::with_capacity(512 + fit.computed.spec.len() + fit.computed.result.len());
    let mut object = json.object();
    new_fit(&mut object, fit, false);
    object.end();
    json.into_bytes()
}

fn new_fit(object: &mut Object<'_>, fit: &NewFit, chosen: bool) {
    object
        .field("id", &fit.id)
        .field("chosen", &chosen)
        .field("created_at", &Moment(fit.created_at))
        .maybe("reason", fit.reason.as_deref())
        .raw("spec", &fit.computed.spec)
        .raw("result", &fit.computed.result);
}

/// A stored fit in full; `result` is its answer, perhaps with more than was asked for at first.
pub fn stored_fit(fit: &FitRecord, result: &str) -> Vec<u8> {
    let mut json = Json::with_capacity(512 + fit.spec.len() + result.len());
    json.object()
        .field("id", &fit.id)
        .field("chosen", &fit.chosen)
        .field("created_at", &Moment(fit.created_at))
        .maybe("reason", fit.reason.as_deref())
        .raw("spec", &fit.spec)
        .raw("result", result)
        .end();
    json.into_bytes()
}

/// Some fits of an iteration.
pub fn fits(page: &Page<FitSummary>) -> Vec<u8> {
    let mut json = Json::with_capacity(64 + 512 * page.items.len());
    json.object()
        .list("items", &page.items, fit_summary)
        .maybe("next_cursor", page.next.map(|next| next.encode(List::Fits)))
        .end();
    json.into_bytes()
}

/// The fields of [`FitSummaryBody`].
pub(in crate::api) fn fit_summary(object: &mut Object<'_>, fit: &FitSummary) {
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
        .field("created_at", &Moment(fit.event.created_at))
        .maybe("reason", fit.event.reason.as_deref());
}
