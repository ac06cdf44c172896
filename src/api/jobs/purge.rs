//! Purges as they are requested and returned.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::json::text::{LongText, Moment},
    jobs::Purge,
};

/// Reason of the purge.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PurgeRequest, example = json!({ "reason": "The operator asked for it" }))]
pub struct PurgeRequestBody {
    /// Reason of the purge. It is stored, and returned for later requests for the removed data: do
    /// not name persons here.
    #[schema(value_type = String, min_length = 1, max_length = 4000)]
    pub reason: LongText,
}

/// The purge of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Purge)]
pub struct PurgeBody {
    /// The job; its row, numbers and audit are kept.
    pub job_id: Uuid,
    /// Time of the purge.
    #[schema(value_type = String, format = DateTime)]
    pub purged_at: Moment,
    /// Reason, as posted.
    pub reason: String,
}

impl From<&Purge> for PurgeBody {
    fn from(Purge { job, at, reason }: &Purge) -> Self {
        PurgeBody { job_id: *job, purged_at: Moment(*at), reason: reason.clone() }
    }
}
