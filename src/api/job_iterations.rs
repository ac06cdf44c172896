//! Iterations of a job and their fits as they are written and read.
//!
//! Answers hold the stored answer of a fit byte for byte, so they are written by [`Object`]; the structs say what is written, for
//! the OpenAPI document and for whoever reads it back.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    fit_result::FitResultBody,
    fit_spec::{FitSpecBody, present},
    json_writer::{Json, Object},
    nodes_schema::NodesBody,
    reader::Extra,
    text::{LongText, Moment, ShortText},
};
use crate::jobs::{Decision, FitRecord, Iteration, NewFit, NewIteration, Stored};

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

/// What is known of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Measurement {
    /// RFC 3339, any offset; answered in UTC.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime, example = "2026-11-21T08:30:00Z")]
    pub measured_at: Option<Moment>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "P40")]
    pub instrument: Option<ShortText>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub operator: Option<ShortText>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub note: Option<LongText>,
}

impl Extra for Measurement {
    const KEYS: &'static [&'static str] = &["measured_at", "instrument", "operator", "note"];
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

/// Why something is done.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Why {
    /// Kept in the trace.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub reason: Option<LongText>,
}

impl Extra for Why {
    const KEYS: &'static [&'static str] = &["reason"];
}

/// Which fit stands from now on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ChosenFit)]
pub struct ChosenFitBody {
    /// A fit of this iteration.
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

/// An iteration of a job, with every fit of its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Iteration)]
pub struct IterationBody {
    /// 1, 2, 3 … within the job.
    pub number: u32,
    pub id: Uuid,
    pub job_id: Uuid,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub measured_at: Option<Moment>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Nodes posted, missing ones included.
    pub node_count: u64,
    /// The latest decision; absent before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionName>,
    /// In the order in which they were made.
    pub fits: Vec<IterationFitBody>,
}

/// A fit of an iteration's nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationFit)]
pub struct IterationFitBody {
    pub id: Uuid,
    /// Whether this fit stands.
    pub chosen: bool,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub result: FitResultBody,
}

/// A new iteration, once it has its number.
pub fn created_iteration(new: &NewIteration, stored: Stored) -> Vec<u8> {
    let mut json = Json::with_capacity(512 + new.fit.computed.result.len());
    let mut object = json.object();
    object
        .field("number", &stored.number)
        .field("id", &new.id)
        .field("job_id", &new.job_id)
        .maybe("measured_at", new.measured_at.map(Moment))
        .maybe("instrument", new.instrument.as_deref())
        .maybe("operator", new.operator.as_deref())
        .maybe("note", new.note.as_deref())
        .field("created_at", &Moment(new.created_at))
        .field("node_count", &new.nodes.posted())
        .list("fits", [&new.fit], |object, fit| new_fit(object, fit, true))
        .end();
    json.into_bytes()
}

/// A stored iteration.
pub fn iteration(iteration: &Iteration) -> Vec<u8> {
    let results: usize = iteration.fits.iter().map(|fit| fit.result.len() + 256).sum();
    let mut json = Json::with_capacity(512 + results);
    let mut object = json.object();
    object
        .field("number", &iteration.number)
        .field("id", &iteration.id)
        .field("job_id", &iteration.job_id)
        .maybe("measured_at", iteration.measured_at.map(Moment))
        .maybe("instrument", iteration.instrument.as_deref())
        .maybe("operator", iteration.operator.as_deref())
        .maybe("note", iteration.note.as_deref())
        .field("created_at", &Moment(iteration.created_at))
        .field("node_count", &iteration.node_count)
        .maybe("decision", iteration.ruling.as_ref().map(|ruling| ruling.decision.name()))
        .list("fits", &iteration.fits, |object, fit| fit_record(object, fit, fit.id == iteration.chosen))
        .end();
    json.into_bytes()
}

/// A new fit of stored nodes. It is not chosen yet.
pub fn created_fit(fit: &NewFit) -> Vec<u8> {
    let mut json = Json::with_capacity(256 + fit.computed.result.len());
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
        .raw("result", &fit.computed.result);
}

fn fit_record(object: &mut Object<'_>, fit: &FitRecord, chosen: bool) {
    object
        .field("id", &fit.id)
        .field("chosen", &chosen)
        .field("created_at", &Moment(fit.created_at))
        .maybe("reason", fit.reason.as_deref())
        .raw("result", &fit.result);
}
