//! Operations as they are answered: requests with `Prefer: respond-async`.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::{json::text::Moment, problem::Problem},
    jobs::{List, MOST_ATTEMPTS, Page, Task, TaskState},
};

/// A request that is answered later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Operation, example = json!({"id": "019ab1c2-0000-7000-8000-000000000000",
    "request": "POST /v1/studies/randomization", "scope": "compute", "state": "running", "progress": 0.25,
    "remaining_seconds": 12.0, "attempts": 1, "created_at": "2026-11-21T08:30:00.000000Z",
    "begun_at": "2026-11-21T08:30:00.010000Z"}))]
pub struct OperationBody {
    /// A UUIDv7.
    pub id: Uuid,
    /// Method and path of the request.
    pub request: String,
    /// Scope that the request requires, and that reading the operation requires.
    pub scope: String,
    /// Job of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job_id: Option<Uuid>,
    pub state: OperationStateName,
    /// Completed share, from 0 to 1, as far as the computation reports it; a few seconds old if
    /// another server computes it.
    pub progress: f64,
    /// Estimated seconds until its end; absent where no estimate exists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remaining_seconds: Option<f64>,
    /// Number of starts: more than one after the loss of a server.
    pub attempts: u32,
    /// When the request was kept.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// When it was begun, the last time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub begun_at: Option<Moment>,
    /// When it ended. It is kept for an hour from then on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub ended_at: Option<Moment>,
    /// The status of the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<u16>,
    /// Why it failed. `…/result` answers this, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<Problem>,
}

/// State of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = OperationState)]
pub enum OperationStateName {
    /// Nobody does it yet, or whoever did it was lost.
    Queued,
    Running,
    /// `…/result` answers what the request would have answered.
    Succeeded,
    /// `…/result` answers the problem.
    Failed,
    /// There is no result, and nothing was stored.
    Cancelled,
}

impl From<TaskState> for OperationStateName {
    fn from(state: TaskState) -> Self {
        match state {
            TaskState::Queued => OperationStateName::Queued,
            TaskState::Running => OperationStateName::Running,
            TaskState::Succeeded => OperationStateName::Succeeded,
            TaskState::Failed => OperationStateName::Failed,
            TaskState::Cancelled => OperationStateName::Cancelled,
        }
    }
}

/// Operations, newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = OperationPage)]
pub struct OperationPageBody {
    /// Newest first.
    pub items: Vec<OperationBody>,
    /// Cursor of the next page; absent on the last one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

impl OperationBody {
    /// A task as it stands now.
    pub fn of(task: &Task, now: Timestamp) -> Self {
        OperationBody {
            id: task.id,
            request: format!("POST {}", task.request),
            scope: task.scope.name().to_owned(),
            job_id: task.job,
            state: task.state.into(),
            progress: if task.state == TaskState::Succeeded { 1.0 } else { task.progress },
            // to the tenth: more would pretend
            remaining_seconds: task.remaining(now).map(|seconds| (10.0 * seconds).round() / 10.0),
            // once more it is begun only to say that it is given up
            attempts: task.attempts.min(MOST_ATTEMPTS),
            created_at: Moment(task.created_at),
            begun_at: task.begun_at.map(Moment),
            ended_at: task.ended_at.map(Moment),
            status: task.status,
            problem: None,
        }
    }
}

impl OperationPageBody {
    pub fn of(page: Page<Task>, now: Timestamp) -> Self {
        OperationPageBody {
            items: page.items.iter().map(|task| OperationBody::of(task, now)).collect(),
            next_cursor: page.next.map(|cursor| cursor.encode(List::Tasks)),
        }
    }
}
