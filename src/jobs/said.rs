//! Choices and decisions of an iteration.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

/// When something was said of an iteration, by whom and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    pub reason: Option<String>,
    /// The actor, where one is known.
    pub by: Option<Arc<str>>,
    pub created_at: Timestamp,
}

/// The choice of a fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    pub fit_id: Uuid,
    pub event: Event,
}

/// That something was decided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecisionEvent {
    pub decision: Decision,
    /// Whether accepting needed a reason.
    pub concession: bool,
    pub event: Event,
}

/// Decision on the gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    Accepted,
    Remachine,
    Rejected,
}

names! {
    Decision { Accepted "accepted", Remachine "remachine", Rejected "rejected" }
}
