//! Events of a job as they are sent to those who listen (`text/event-stream`).

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{iteration_requests::DecisionName, operation::OperationStateName};
use crate::{
    api::json::{text::Moment, writer::text_of},
    jobs::{Decision, EventKind, JobEvent},
};

/// The `data` of an event. Its `event` is the `type`, its `id` the number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = JobEvent, example = json!({"number": 3, "type": "decision", "created_at": "2026-11-21T08:30:00.000000Z",
    "iteration_number": 1, "decision": "accept"}))]
pub struct JobEventBody {
    /// 1, 2, 3 … within the job.
    pub number: u64,
    #[serde(rename = "type")]
    pub kind: EventName,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The iteration added, fitted again, decided on, or made of a stream.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iteration_number: Option<u32>,
    /// Of the iteration, a UUIDv7.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iteration_id: Option<Uuid>,
    /// The first fit of a new iteration, a new fit, or the one chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_id: Option<Uuid>,
    /// Of a fit: whether it stands from now on, or was only added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionName>,
    /// Of a decision, a choice, a new fit or a purge, as it was posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Of the stream that something happened to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream_id: Option<Uuid>,
    /// What happened to a stream.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<StreamEventName>,
    /// Of a stream's last block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sequence: Option<u64>,
    /// Nodes of a stream so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_count: Option<u64>,
    /// Of the operation (`Prefer: respond-async`) that was begun or has ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operation_id: Option<Uuid>,
    /// `queued` for an operation that was begun, else how it has ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operation_state: Option<OperationStateName>,
}

/// What an event is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventName {
    Iteration,
    Fit,
    Decision,
    Stream,
    Operation,
    /// The job was purged: its numbers stay, and whatever needs the rest is 410 from now on.
    Purged,
}

impl EventName {
    fn name(self) -> &'static str {
        match self {
            EventName::Iteration => "iteration",
            EventName::Fit => "fit",
            EventName::Decision => "decision",
            EventName::Stream => "stream",
            EventName::Operation => "operation",
            EventName::Purged => "purged",
        }
    }
}

/// What happened to a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StreamEventName {
    Open,
    Block,
    Finished,
    Deleted,
}

impl From<crate::jobs::StreamEvent> for StreamEventName {
    fn from(event: crate::jobs::StreamEvent) -> Self {
        use crate::jobs::StreamEvent;
        match event {
            StreamEvent::Open => StreamEventName::Open,
            StreamEvent::Block => StreamEventName::Block,
            StreamEvent::Finished => StreamEventName::Finished,
            StreamEvent::Deleted => StreamEventName::Deleted,
        }
    }
}

impl From<JobEvent> for JobEventBody {
    fn from(event: JobEvent) -> Self {
        let mut body = JobEventBody {
            number: event.number,
            kind: EventName::Iteration,
            created_at: Moment(event.created_at),
            iteration_number: None,
            iteration_id: None,
            fit_id: None,
            chosen: None,
            decision: None,
            reason: None,
            stream_id: None,
            state: None,
            sequence: None,
            node_count: None,
            operation_id: None,
            operation_state: None,
        };
        match event.kind {
            EventKind::Iteration { number, id, fit_id } => {
                body.iteration_number = Some(number);
                body.iteration_id = Some(id);
                body.fit_id = Some(fit_id);
            }
            EventKind::Fit { number, fit_id, chosen, reason } => {
                body.kind = EventName::Fit;
                body.iteration_number = Some(number);
                body.fit_id = Some(fit_id);
                body.chosen = Some(chosen);
                body.reason = reason;
            }
            EventKind::Decision { number, decision, reason } => {
                body.kind = EventName::Decision;
                body.iteration_number = Some(number);
                body.decision = Some(match decision {
                    Decision::Accept => DecisionName::Accept,
                    Decision::Remachine => DecisionName::Remachine,
                    Decision::Reject => DecisionName::Reject,
                });
                body.reason = reason;
            }
            EventKind::Stream { id, state, sequence, node_count, iteration } => {
                body.kind = EventName::Stream;
                body.stream_id = Some(id);
                body.state = Some(state.into());
                body.sequence = Some(sequence);
                body.node_count = Some(node_count);
                body.iteration_number = iteration;
            }
            EventKind::Task { id, state } => {
                body.kind = EventName::Operation;
                body.operation_id = Some(id);
                body.operation_state = Some(state.into());
            }
            EventKind::Purged { reason } => {
                body.kind = EventName::Purged;
                body.reason = Some(reason);
            }
        }
        body
    }
}

/// Events in the form of `text/event-stream`.
pub fn to_text(events: impl IntoIterator<Item = JobEvent>) -> String {
    let mut text = String::new();
    for event in events {
        let body = JobEventBody::from(event);
        // JSON of one line: line breaks inside strings are escaped. Writing to a string cannot
        // fail.
        let data = text_of(&body);
        let _ = write!(text, "id: {}\nevent: {}\ndata: {data}\n\n", body.number, body.kind.name());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_three_lines_and_a_blank_one() {
        let kind = EventKind::Decision { number: 2, decision: Decision::Reject, reason: Some("a\nb".into()) };
        let event = JobEvent { number: 7, created_at: jiff::Timestamp::UNIX_EPOCH, kind };
        let text = to_text([event]);
        let lines: Vec<&str> = text.split('\n').collect();
        assert_eq!((lines[0], lines[1], lines.len()), ("id: 7", "event: decision", 5));
        let data: JobEventBody = serde_json::from_str(lines[2].strip_prefix("data: ").unwrap()).unwrap();
        assert_eq!((data.number, data.iteration_number, data.reason.as_deref()), (7, Some(2), Some("a\nb")));
        assert!(!text.contains("null"));
    }
}
