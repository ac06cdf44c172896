//! Iterations of a job and their fits as they are answered.
//!
//! Answers hold the stored answer of a fit byte for byte, so they are written by [`Object`]; the
//! structs say what is written, for the OpenAPI document and for whoever reads it back.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::iteration_requests::DecisionName;
use crate::{
    api::{
        fits::{answer::FitResultBody, spec::request::FitSpecBody},
        gears::{fit_figures::FitFiguresBody, notice::NoticeBody},
        json::{
            gather::gathered,
            raw::Raw,
            text::Moment,
            writer::{Json, Object},
        },
        measurand::axes::MeasurandBody,
    },
    jobs::{
        Computed, Event, FitRecord, FitSummary, Iteration, List, Measurand, MeasurementDetails, NewFit, NewIteration,
        Page, Stored,
    },
};
use flankfit_engine::estimation::spec::{ChosenBy, Scheme};

/// What was posted of an iteration, and what it was given.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostedIterationBody {
    /// 1, 2, 3 … within the job.
    pub number: u32,
    /// UUIDv7.
    pub id: Uuid,
    /// The job that it belongs to.
    pub job_id: Uuid,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurand: MeasurandBody,
    /// True if the units were confirmed although the values are implausible; absent otherwise.
    pub accept_units: Option<bool>,
    /// When the nodes were measured, as it was posted.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub measured_at: Option<Moment>,
    /// Measuring instrument.
    pub instrument: Option<String>,
    /// Operator who measured the nodes.
    pub operator: Option<String>,
    /// Note on the measurement.
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
    /// Warnings of the fit and its figures, each with `at`.
    pub warnings: Vec<NoticeBody>,
}

/// An iteration of a job, with the figures of the fits of its nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Iteration)]
pub struct IterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub posted: PostedIterationBody,
    /// The latest decision; absent before the first.
    pub decision: Option<DecisionName>,
    /// Actor of the caller who decided; absent where no key was required.
    pub decided_by: Option<String>,
    /// The last hundred fits in the order in which they were made; `GET …/fits/{fit_id}` has each
    /// in full.
    pub fits: Vec<FitSummaryBody>,
    /// Number of fits before the listed ones; `GET …/fits` lists all.
    pub earlier_fits: Option<u64>,
    /// When its nodes, results, texts and names were taken away; absent where they are there.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub purged_at: Option<Moment>,
    /// Warnings of the chosen fit's figures, each with `at`.
    pub warnings: Vec<NoticeBody>,
}

/// A fit of an iteration's nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationFit)]
pub struct IterationFitBody {
    /// UUIDv7.
    pub id: Uuid,
    /// True for the chosen fit.
    pub chosen: bool,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller who made it; absent where no key was required.
    pub by: Option<String>,
    /// Why it was made, as it was posted.
    pub reason: Option<String>,
    /// The fit request without nodes, with every default filled in. It can be sent as a refit, or
    /// with nodes as a new fit.
    #[schema(value_type = FitSpecBody)]
    pub spec: serde_json::Value,
    /// Slopes, crownings and twist, or why there are none; absent of curves and matrices, of jobs
    /// without gear and requirements, and of fits from before there were any.
    pub figures: Option<FitFiguresBody>,
    pub result: FitResultBody<'static>,
    /// Warnings of result and figures, each with `at`; in the answer for a single fit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<NoticeBody>,
}

/// Figures of a fit for comparing λ* choices. A figure that does not exist is absent.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitSummary)]
pub struct FitSummaryBody {
    /// UUIDv7.
    pub id: Uuid,
    /// True for the chosen fit.
    pub chosen: bool,
    /// For the chosen fit: actor of the caller who chose it; absent where no key was required.
    pub chosen_by: Option<String>,
    /// The λ* of the fit; left out without regularisation.
    pub lambda_star: Option<f64>,
    pub criterion: Option<ChosenBy>,
    pub scheme: Option<Scheme>,
    /// L: how many of the smallest eigenvalues were regularised.
    pub count: Option<u32>,
    /// Condition number of the scaled Fisher information matrix; left out where it is infinite.
    pub condition: Option<f64>,
    /// The same after regularisation.
    pub regularized_condition: Option<f64>,
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: Option<f64>,
    /// The smallest bias bound that holds within the norm limit.
    pub bias_sharp_bound: Option<f64>,
    /// Root mean square of the residuals, in the unit of the heights.
    pub rms: Option<f64>,
    /// Largest |residual|.
    pub max_abs: Option<f64>,
    /// Slopes, crownings and twist of the chosen fit (every fit has its own where it is returned in
    /// full); absent where `axes` do not give u, v and z, and for fits that are older than these
    /// figures.
    pub figures: Option<FitFiguresBody>,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller who made it; absent where no key was required.
    pub by: Option<String>,
    /// Why it was made, as it was posted.
    pub reason: Option<String>,
}

/// Some fits of an iteration, in the order in which they were made.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitPage)]
pub struct FitPageBody {
    /// The fits of this page.
    pub items: Vec<FitSummaryBody>,
    /// Cursor of the next page; absent on the last one.
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
        .field("warnings", &[(); 0])
        .end();
    gathered(json.into_bytes())
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
        .maybe("decision", iteration.decision.as_ref().map(|decision| decision.decision.name()))
        .maybe("decided_by", iteration.decision.as_ref().and_then(|decision| decision.event.by.as_deref()))
        .list("fits", &iteration.fits, fit_summary)
        .maybe("earlier_fits", Some(iteration.earlier_fits).filter(|count| *count > 0))
        .maybe("purged_at", iteration.purged_at.map(Moment))
        .field("warnings", &[(); 0])
        .end();
    gathered(json.into_bytes())
}

fn details(object: &mut Object<'_>, of: &MeasurementDetails) {
    measured(object, of.measured_at, of.instrument.as_deref(), of.operator.as_deref());
    object.maybe("note", of.note.as_deref());
}

/// When nodes were measured, with what and by whom, as an iteration, a list and the trace tell it.
pub(super) fn measured(
    object: &mut Object<'_>,
    at: Option<Timestamp>,
    instrument: Option<&str>,
    operator: Option<&str>,
) {
    object.maybe("measured_at", at.map(Moment)).maybe("instrument", instrument).maybe("operator", operator);
}

/// What nodes are of, as an iteration, a stream and the trace tell it.
pub(in crate::api) fn measurand(object: &mut Object<'_>, of: &Measurand) {
    object.maybe("flank", of.flank_name()).maybe("tooth", of.tooth.as_deref());
    if let Some(axes) = &of.axes {
        object.raw("axes", axes);
    }
    object.maybe("accept_units", Some(of.units_accepted).filter(|accepted| *accepted));
}

/// A new fit of stored nodes. It is not chosen yet.
pub fn created_fit(fit: &NewFit) -> Vec<u8> {
    let mut json = Json::with_capacity(512 + fit.computed.spec.len() + fit.computed.result.len());
    let mut object = json.object();
    new_fit(&mut object, fit, false);
    object.end();
    gathered(json.into_bytes())
}

fn new_fit(object: &mut Object<'_>, fit: &NewFit, chosen: bool) {
    let Computed { spec, result, flank, .. } = &fit.computed;
    fit_in_full(object, fit.id, chosen, &fit.event, spec, flank.as_deref(), result);
}

/// A stored fit in full; `result` is its answer, perhaps with more than was asked for at first.
pub fn stored_fit(fit: &FitRecord, result: &str) -> Vec<u8> {
    let mut json = Json::with_capacity(512 + fit.spec.len() + result.len());
    let mut object = json.object();
    fit_in_full(&mut object, fit.id, fit.chosen, &fit.event, &fit.spec, fit.flank.as_deref(), result);
    object.end();
    gathered(json.into_bytes())
}

/// The fields of [`IterationFitBody`].
fn fit_in_full(
    object: &mut Object<'_>,
    id: Uuid,
    chosen: bool,
    event: &Event,
    spec: &str,
    flank: Option<&str>,
    result: &str,
) {
    object
        .field("id", &id)
        .field("chosen", &chosen)
        .field("created_at", &Moment(event.created_at))
        .maybe("by", event.by.as_deref())
        .maybe("reason", event.reason.as_deref())
        .raw("spec", spec)
        .maybe("figures", flank.map(Raw::<FitFiguresBody>::from))
        .raw("result", result);
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
        .maybe("chosen_by", fit.chosen_by.as_deref())
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
        .maybe("figures", fit.flank.as_deref().filter(|_| fit.chosen).map(Raw::<FitFiguresBody>::from))
        .field("created_at", &Moment(fit.event.created_at))
        .maybe("by", fit.event.by.as_deref())
        .maybe("reason", fit.event.reason.as_deref());
}
