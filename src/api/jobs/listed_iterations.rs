//! Iterations of a job in a list.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::iterations::{FitSummaryBody, MeasuredIterationBody};
use crate::jobs::{Decision, ListedIteration};

/// An iteration with its chosen fit.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationSummary)]
pub struct ListedIterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub measured: MeasuredIterationBody,
    /// The latest decision; absent before the first.
    pub decision: Option<Decision>,
    /// Actor of the caller who decided; absent where no key was required.
    pub decided_by: Option<String>,
    /// The chosen fit.
    pub chosen_fit: FitSummaryBody,
}

impl From<ListedIteration> for ListedIterationBody {
    fn from(listed: ListedIteration) -> Self {
        let measured = (listed.measured_at, &listed.instrument, &listed.operator);
        let key = (listed.number, listed.id);
        ListedIterationBody {
            measured: MeasuredIterationBody::new(key, &listed.measurand, measured, listed.created_at),
            decision: listed.decision,
            decided_by: listed.decided_by.as_deref().map(str::to_owned),
            chosen_fit: listed.fit.into(),
        }
    }
}
