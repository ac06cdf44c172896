//! Events of a job as they are sent to those who listen (`text/event-stream`).

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{iteration_requests::DecisionName, records::RecordKindName};
use crate::{
    api::json::text::Moment,
    jobs::{Decision, EventKind, EventPlace, JobChange, JobEvent, ToldEvent},
};

/// The `data` of an event. Its `event` is the `type`, its `id` the number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = JobEvent, example = json!({"number": 3, "type": "decision", "created_at": "2026-11-21T08:30:00.000000Z",
    "iteration_number": 1, "decision": "accept"}))]
pub struct JobEventBody {
    /// 1, 2, 3 … within the job; 0 where the job was created or deleted, and of a `reset`, which
    /// only those hear who listen to all jobs.
    pub number: u64,
    /// The job; where events of all jobs are listened to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job_id: Option<Uuid>,
    #[serde(rename = "type")]
    pub kind: EventName,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The iteration added, fitted again, decided on, or made of a stream.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iteration_number: Option<u32>,
    /// Id of the iteration, a UUIDv7.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iteration_id: Option<Uuid>,
    /// The first fit of a new iteration, a new fit, or the one chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_id: Option<Uuid>,
    /// For a fit: true if it was chosen, false if it was only added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionName>,
    /// Reason of a decision, a choice, a new fit or a purge, as posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The stream, for an event of a stream.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream_id: Option<Uuid>,
    /// Change of the stream's state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<StreamEventName>,
    /// Number of the stream's last block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sequence: Option<u64>,
    /// Nodes of a stream so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_count: Option<u64>,
    /// The record that was stored with the iteration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record_id: Option<Uuid>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record_kind: Option<RecordKindName>,
    /// Change of the job itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job_state: Option<JobStateName>,
}

/// Change of a job itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = JobEventState)]
pub enum JobStateName {
    Created,
    /// Its name, gear, requirements or what else is its own was written anew.
    Changed,
    Deleted,
}

impl From<JobChange> for JobStateName {
    fn from(change: JobChange) -> Self {
        match change {
            JobChange::Created => JobStateName::Created,
            JobChange::Changed => JobStateName::Changed,
            JobChange::Deleted => JobStateName::Deleted,
        }
    }
}

/// Subject of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventName {
    Iteration,
    Fit,
    Decision,
    Stream,
    /// Something was kept with an iteration.
    Record,
    /// The job itself was created, changed or deleted.
    Job,
    /// The job was purged: its numbers stay, and whatever needs the rest is 410 from now on.
    Purged,
    /// Events of all jobs were missed: sending goes on with what happens from now on.
    Reset,
}

impl EventName {
    pub fn name(self) -> &'static str {
        match self {
            EventName::Iteration => "iteration",
            EventName::Fit => "fit",
            EventName::Decision => "decision",
            EventName::Stream => "stream",
            EventName::Record => "record",
            EventName::Job => "job",
            EventName::Purged => "purged",
            EventName::Reset => "reset",
        }
    }
}

/// Change of the stream's state.
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

impl JobEventBody {
    /// Tells one who listens to all jobs that events were missed.
    pub fn reset(now: Timestamp) -> Self {
        JobEventBody::empty(0, EventName::Reset, now)
    }

    fn empty(number: u64, kind: EventName, created_at: Timestamp) -> Self {
        JobEventBody {
            number,
            job_id: None,
            kind,
            created_at: Moment(created_at),
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
            record_id: None,
            record_kind: None,
            job_state: None,
        }
    }
}

impl From<ToldEvent> for JobEventBody {
    fn from(ToldEvent { job, event, .. }: ToldEvent) -> Self {
        JobEventBody { job_id: Some(job), ..event.into() }
    }
}

impl From<JobEvent> for JobEventBody {
    fn from(event: JobEvent) -> Self {
        let mut body = JobEventBody::empty(event.number, EventName::Iteration, event.created_at);
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
            EventKind::Record { number, id, kind } => {
                body.kind = EventName::Record;
                body.iteration_number = Some(number);
                body.record_id = Some(id);
                body.record_kind = Some(kind);
            }
            EventKind::Job { state } => {
                body.kind = EventName::Job;
                body.job_state = Some(state.into());
            }
            EventKind::Purged { reason } => {
                body.kind = EventName::Purged;
                body.reason = Some(reason);
            }
        }
        body
    }
}

/// A place as the id of an event.
pub fn place_text(EventPlace { change, number }: EventPlace) -> String {
    format!("{change}-{number}")
}

/// The place that an id is of.
pub fn place_of(text: &str) -> Option<EventPlace> {
    // signs are none
    let whole = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_digit()).then(|| digits.parse().ok());
    let (change, number) = text.split_once('-')?;
    Some(EventPlace { change: whole(change)??, number: whole(number)?? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_back_from_their_ids() {
        for place in [EventPlace::default(), EventPlace { change: 7, number: 12 }] {
            assert_eq!(place_of(&place_text(place)), Some(place));
        }
        for odd in ["", "7", "7-", "-7", "+7-1", "7-+1", "7-1-1", "7 - 1", "99999999999999999999-1", "a-b"] {
            assert_eq!(place_of(odd), None, "{odd}");
        }
    }
}
