//! Events of a job as they are sent to those who listen (`text/event-stream`).

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::json::text::Moment,
    jobs::{Decision, EventKind, EventPlace, JobChange, JobEvent, RecordKind, StreamEvent, ToldEvent},
};

/// The `data` of an event. Its `event` is the `type`, its `id` the number.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = JobEvent, example = json!({"number": 3, "type": "decision", "created_at": "2026-11-21T08:30:00.000000Z",
    "iteration_number": 1, "decision": "accepted"}))]
pub struct JobEventBody {
    /// 1, 2, 3 … within the job; 0 if the job was created or deleted, and for a `reset`, which only
    /// listeners to all jobs receive.
    pub number: u64,
    /// The job; for events of all jobs.
    pub job_id: Option<Uuid>,
    #[serde(rename = "type")]
    pub kind: EventName,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The iteration that was added, fitted again, decided on, or made from a stream.
    pub iteration_number: Option<u32>,
    /// Id of the iteration, a UUIDv7.
    pub iteration_id: Option<Uuid>,
    /// The first fit of a new iteration, a new fit, or the one chosen.
    pub fit_id: Option<Uuid>,
    /// For a fit: true if it was chosen, false if it was only added.
    pub chosen: Option<bool>,
    pub decision: Option<Decision>,
    /// Reason of a decision, a choice, a new fit or a purge, as posted.
    pub reason: Option<String>,
    /// The stream, for an event of a stream.
    pub stream_id: Option<Uuid>,
    /// Change of the stream's state.
    pub state: Option<StreamEvent>,
    /// Number of the stream's last block.
    pub sequence: Option<u64>,
    /// Nodes of a stream so far.
    pub node_count: Option<u64>,
    /// The record that was stored with the iteration.
    pub record_id: Option<Uuid>,
    pub record_kind: Option<RecordKind>,
    /// Change of the job itself.
    pub job_state: Option<JobChange>,
}

/// Subject of an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
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
    #[default]
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

impl JobEventBody {
    /// Creates the event that says that events of all jobs were missed.
    pub fn reset(now: Timestamp) -> Self {
        JobEventBody { created_at: Moment(now), ..JobEventBody::default() }
    }
}

impl From<ToldEvent> for JobEventBody {
    fn from(ToldEvent { job, event, .. }: ToldEvent) -> Self {
        JobEventBody { job_id: Some(job), ..event.into() }
    }
}

impl From<JobEvent> for JobEventBody {
    fn from(event: JobEvent) -> Self {
        let body =
            JobEventBody { number: event.number, created_at: Moment(event.created_at), ..JobEventBody::default() };
        match event.kind {
            EventKind::Iteration { number, id, fit_id } => JobEventBody {
                kind: EventName::Iteration,
                iteration_number: Some(number),
                iteration_id: Some(id),
                fit_id: Some(fit_id),
                ..body
            },
            EventKind::Fit { number, fit_id, chosen, reason } => JobEventBody {
                kind: EventName::Fit,
                iteration_number: Some(number),
                fit_id: Some(fit_id),
                chosen: Some(chosen),
                reason,
                ..body
            },
            EventKind::Decision { number, decision, reason } => JobEventBody {
                kind: EventName::Decision,
                iteration_number: Some(number),
                decision: Some(decision),
                reason,
                ..body
            },
            EventKind::Stream { id, state, sequence, node_count, iteration } => JobEventBody {
                kind: EventName::Stream,
                stream_id: Some(id),
                state: Some(state),
                sequence: Some(sequence),
                node_count: Some(node_count),
                iteration_number: iteration,
                ..body
            },
            EventKind::Record { number, id, kind } => JobEventBody {
                kind: EventName::Record,
                iteration_number: Some(number),
                record_id: Some(id),
                record_kind: Some(kind),
                ..body
            },
            EventKind::Job { state } => JobEventBody { kind: EventName::Job, job_state: Some(state), ..body },
            EventKind::Purged { reason } => JobEventBody { kind: EventName::Purged, reason: Some(reason), ..body },
        }
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
