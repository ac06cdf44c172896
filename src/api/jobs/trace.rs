//! The trace of a job: every λ* choice and every decision in the order in which they were made.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    iterations::{FitSummaryBody, MeasuredIterationBody},
    job::JobBody,
    records::RecordSummaryBody,
};
use crate::{
    api::json::{raw::Raw, text::Moment},
    jobs::{Choice, Decision, DecisionEvent, Earlier, List, Trace, TracedFit, TracedIteration},
};
use flankfit_engine::estimation::result::{Coefficient, PriorReport};

/// The history of a job. Nothing in it is overwritten: changes are new entries.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Trace)]
pub struct TraceBody {
    pub job: JobBody,
    /// Iterations by number.
    pub iterations: Vec<TracedIterationBody>,
    /// Cursor of the next page; absent on the last one.
    pub next_cursor: Option<String>,
}

/// An iteration in the trace.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedIteration)]
pub struct TracedIterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub measured: MeasuredIterationBody,
    /// The latest decision; absent before the first.
    pub decision: Option<Decision>,
    /// In the order in which they were made.
    pub fits: Vec<TracedFitBody>,
    /// Choices of a fit; the first is made with the iteration.
    pub choices: Vec<TracedChoiceBody>,
    /// In the order in which they were made.
    pub decisions: Vec<TracedDecisionBody>,
    /// Records of the iteration, oldest first.
    #[serde(default)]
    pub records: Vec<RecordSummaryBody>,
    /// Absent if the lists are complete.
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
    /// In the order of the fit; empty after a purge of the job.
    #[schema(value_type = Vec<Coefficient>)]
    pub coefficients: Raw<Vec<Coefficient>>,
    /// Prior of the fit; absent without one.
    #[schema(value_type = Option<PriorReport>)]
    pub prior: Option<Raw<PriorReport>>,
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

/// Choice of a fit.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedChoice)]
pub struct TracedChoiceBody {
    /// The fit that was chosen.
    pub fit_id: Uuid,
    /// Actor of the caller who chose it; absent where no key was required.
    pub by: Option<String>,
    /// Reason of the choice, as posted.
    pub reason: Option<String>,
    /// Time of the choice.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// A decision.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TracedDecision)]
pub struct TracedDecisionBody {
    pub decision: Decision,
    /// True if it accepts a gear with a figure that does not conform, suspected gross errors, or
    /// implausible units; a reason is then required. Absent otherwise.
    pub concession: Option<bool>,
    /// Actor of the caller who decided; absent where no key was required.
    pub by: Option<String>,
    /// Reason of the decision, as posted.
    pub reason: Option<String>,
    /// Time of the decision.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

impl From<Earlier> for EarlierBody {
    fn from(earlier: Earlier) -> Self {
        let Earlier { fits, choices, decisions, records } = earlier;
        EarlierBody { fits, choices, decisions, records }
    }
}

impl From<Trace> for TraceBody {
    fn from(trace: Trace) -> Self {
        TraceBody {
            job: trace.job.into(),
            iterations: trace.iterations.into_iter().map(Into::into).collect(),
            next_cursor: trace.next.map(|next| next.encode(List::Iterations)),
        }
    }
}

impl From<TracedIteration> for TracedIterationBody {
    fn from(traced: TracedIteration) -> Self {
        let measured = (traced.measured_at, &traced.instrument, &traced.operator);
        let key = (traced.number, traced.id);
        TracedIterationBody {
            measured: MeasuredIterationBody::new(key, &traced.measurand, measured, traced.created_at),
            decision: traced.decisions.last().map(|decision| decision.decision),
            fits: traced.fits.into_iter().map(Into::into).collect(),
            choices: traced.choices.into_iter().map(Into::into).collect(),
            decisions: traced.decisions.into_iter().map(Into::into).collect(),
            records: traced.records.into_iter().map(Into::into).collect(),
            earlier: Some(traced.earlier).filter(|earlier| *earlier != Earlier::default()).map(Into::into),
        }
    }
}

impl From<TracedFit> for TracedFitBody {
    fn from(TracedFit { summary, coefficients, prior }: TracedFit) -> Self {
        TracedFitBody { summary: summary.into(), coefficients: coefficients.into(), prior: prior.map(Into::into) }
    }
}

impl From<Choice> for TracedChoiceBody {
    fn from(Choice { fit_id, event }: Choice) -> Self {
        TracedChoiceBody {
            fit_id,
            by: event.by.as_deref().map(str::to_owned),
            reason: event.reason,
            created_at: Moment(event.created_at),
        }
    }
}

impl From<DecisionEvent> for TracedDecisionBody {
    fn from(DecisionEvent { decision, concession, event }: DecisionEvent) -> Self {
        TracedDecisionBody {
            decision,
            concession: concession.then_some(true),
            by: event.by.as_deref().map(str::to_owned),
            reason: event.reason,
            created_at: Moment(event.created_at),
        }
    }
}
