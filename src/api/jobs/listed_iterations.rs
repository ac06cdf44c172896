//! Iterations of a job as they are listed.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    iteration_requests::DecisionName,
    iterations::{FitSummaryBody, fit_summary, measurand, measured},
};
use crate::{
    api::{
        json::{
            text::Moment,
            writer::{Json, Object},
        },
        measurand::axes::MeasurandBody,
    },
    jobs::{List, ListedIteration, Page},
};

/// An iteration with its chosen fit.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationSummary)]
pub struct ListedIterationBody {
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
    /// Actor of the caller who decided; absent where no key was required.
    pub decided_by: Option<String>,
    /// The chosen fit.
    pub chosen_fit: FitSummaryBody,
}

/// Some iterations of a job, by number.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationPage)]
pub struct IterationPageBody {
    /// The iterations of this page.
    pub items: Vec<ListedIterationBody>,
    /// Cursor of the next page; absent on the last one.
    pub next_cursor: Option<String>,
}

/// A page of iterations.
pub fn page(page: &Page<ListedIteration>) -> Vec<u8> {
    let mut json = Json::with_capacity(64 + 1024 * page.items.len());
    json.object()
        .list("items", &page.items, iteration)
        .maybe("next_cursor", page.next.map(|next| next.encode(List::Iterations)))
        .end();
    json.into_bytes()
}

fn iteration(object: &mut Object<'_>, iteration: &ListedIteration) {
    object.field("number", &iteration.number).field("id", &iteration.id);
    measurand(object, &iteration.measurand);
    measured(object, iteration.measured_at, iteration.instrument.as_deref(), iteration.operator.as_deref());
    object
        .field("created_at", &Moment(iteration.created_at))
        .maybe("decision", iteration.decision.map(|decision| decision.name()))
        .maybe("decided_by", iteration.decided_by.as_deref())
        .object("chosen_fit", |object| fit_summary(object, &iteration.fit));
}
