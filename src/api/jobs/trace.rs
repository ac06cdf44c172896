//! The trace of a job as it is written: every λ* choice and every decision in the order in which
//! they were made.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    iteration_requests::DecisionName,
    iterations::{FitSummaryBody, fit_summary, measurand, measured},
    job::JobBody,
    records::RecordSummaryBody,
};
use crate::{
    api::{
        jobs::amendments::MeasurandChangeBody,
        json::{
            raw::Raw,
            text::Moment,
            writer::{Json, Object},
        },
        measurand::axes::MeasurandBody,
    },
    jobs::{Choice, DecisionEvent, Earlier, List, RecordSummary, Trace, TracedFit, TracedIteration},
};
use flankfit_engine::estimation::result::{Coefficient, PriorReport};

/// The whole story of a job. Nothing in it is ever overwritten: changes of mind are new entries.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Trace)]
pub struct TraceBody {
    pub job: JobBody,
    /// By number.
    pub iterations: Vec<TracedIterationBody>,
    /// Cursor of the next page; absent on the last one.
    pub next_cursor: Option<String>,
}

/// An iteration in the trace.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedIteration)]
pub struct TracedIterationBody {
    /// 1, 2, 3 … within the job.
    pub number: u32,
    /// UUIDv7.
    pub id: Uuid,
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
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The latest decision; absent before the first.
    pub decision: Option<DecisionName>,
    /// In the order in which they were made.
    pub fits: Vec<TracedFitBody>,
    /// Which fit stood, from when on and why; the first is made with the iteration.
    pub choices: Vec<TracedChoiceBody>,
    /// In the order in which they were made.
    pub decisions: Vec<TracedDecisionBody>,
    /// Records of the iteration, oldest first.
    #[serde(default)]
    pub records: Vec<RecordSummaryBody>,
    /// Absent where the lists are whole.
    pub earlier: Option<EarlierBody>,
}

/// A fit in the trace.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedFit)]
pub struct TracedFitBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub summary: FitSummaryBody,
    /// In the order of the fit's answer; empty after a purge of the job.
    pub coefficients: Vec<Coefficient>,
    /// Prior of the fit; absent without one.
    pub prior: Option<PriorReport>,
}

/// For each list of a traced iteration: number of entries before the listed ones, which are the
/// last hundred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = EarlierEntries)]
pub struct EarlierBody {
    /// Fits before those listed.
    pub fits: u64,
    /// Choices of a fit before those listed.
    pub choices: u64,
    /// Decisions before those listed.
    pub decisions: u64,
    /// Records before those listed.
    pub records: u64,
}

/// That from then on a certain fit stood.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedChoice)]
pub struct TracedChoiceBody {
    /// The fit that stood from then on.
    pub fit_id: Uuid,
    /// Actor of the caller who chose it; absent where no key was required.
    pub by: Option<String>,
    /// Why it was chosen, as it was posted.
    pub reason: Option<String>,
    /// When it was chosen.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// That something was decided.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedDecision)]
pub struct TracedDecisionBody {
    pub decision: DecisionName,
    /// True if it accepts a gear with a figure that does not conform, suspected gross errors, or
    /// implausible units; a reason is then required. Absent otherwise.
    pub concession: Option<bool>,
    /// Actor of the caller who decided; absent where no key was required.
    pub by: Option<String>,
    /// Why it was decided so, as it was posted.
    pub reason: Option<String>,
    /// When it was decided.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

impl From<Earlier> for EarlierBody {
    fn from(earlier: Earlier) -> Self {
        let Earlier { fits, choices, decisions, records } = earlier;
        EarlierBody { fits, choices, decisions, records }
    }
}

/// A page of the trace.
pub fn trace(trace: Trace) -> Vec<u8> {
    let coefficients: usize =
        trace.iterations.iter().flat_map(|iteration| &iteration.fits).map(|fit| fit.coefficients.len() + 512).sum();
    let mut json = Json::with_capacity(1024 + coefficients);
    json.object()
        .field("job", &JobBody::from(trace.job))
        .list("iterations", &trace.iterations, iteration)
        .maybe("next_cursor", trace.next.map(|next| next.encode(List::Iterations)))
        .end();
    json.into_bytes()
}

fn iteration(object: &mut Object<'_>, iteration: &TracedIteration) {
    object.field("number", &iteration.number).field("id", &iteration.id);
    measurand(object, &iteration.measurand);
    measured(object, iteration.measured_at, iteration.instrument.as_deref(), iteration.operator.as_deref());
    object
        .field("created_at", &Moment(iteration.created_at))
        .maybe("decision", iteration.decisions.last().map(|decision| decision.decision.name()))
        .list("fits", &iteration.fits, fit)
        .list("choices", &iteration.choices, choice)
        .list("decisions", &iteration.decisions, decision)
        .list("records", &iteration.records, record)
        .maybe(
            "earlier",
            Some(iteration.earlier).filter(|earlier| *earlier != Earlier::default()).map(EarlierBody::from),
        );
}

fn fit(object: &mut Object<'_>, fit: &TracedFit) {
    fit_summary(object, &fit.summary);
    object.raw("coefficients", &fit.coefficients);
    if let Some(prior) = &fit.prior {
        object.raw("prior", prior);
    }
}

fn choice(object: &mut Object<'_>, choice: &Choice) {
    object
        .field("fit_id", &choice.fit_id)
        .maybe("by", choice.event.by.as_deref())
        .maybe("reason", choice.event.reason.as_deref())
        .field("created_at", &Moment(choice.event.created_at));
}

fn record(object: &mut Object<'_>, record: &RecordSummary) {
    object
        .field("id", &record.id)
        .field("kind", &record.kind.name())
        .field("method", &record.method)
        .field("created_at", &Moment(record.created_at))
        .maybe("by", record.by.as_deref())
        .maybe("measurand", record.measurand.as_deref().map(Raw::<MeasurandChangeBody>::from));
}

fn decision(object: &mut Object<'_>, decision: &DecisionEvent) {
    object
        .field("decision", &decision.decision.name())
        .maybe("concession", Some(decision.concession).filter(|concession| *concession))
        .maybe("by", decision.event.by.as_deref())
        .maybe("reason", decision.event.reason.as_deref())
        .field("created_at", &Moment(decision.event.created_at));
}
