//! Streams, their blocks, and the events of a job.

use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    jobs::{
        Block, Decision, EventKind, EventPlace, JobChange, JobEvent, RecordKind, RepositoryError, Stream, StreamEvent,
        StreamState, ToldEvent,
    },
    store::sql::error::{StoreError, damaged},
};

from_row! {
    Stream {
        @measurand,
        id, job_id, spec, forgetting_factor, sequence, node_count, input_sha256, iteration, version, created_at,
        updated_at,
    }
    Block { sequence, sha256, nodes = "data" }
    StreamState { sequence, data }
    EventPlace { change = "changed_by", number = "place" }
}

row! {
    /// An event with the columns of other tables; its kind says which hold something.
    pub struct EventRow {
        number: u64,
        created_at: Timestamp,
        kind: String,
        iteration: Option<u32>,
        iteration_id: Option<Uuid>,
        fit_id: Option<Uuid>,
        choice: Option<i64>,
        choice_reason: Option<String>,
        decision: Option<Decision>,
        decision_reason: Option<String>,
        stream_id: Option<Uuid>,
        state: Option<StreamEvent>,
        sequence: Option<u64>,
        node_count: Option<u64>,
        purge_reason: Option<String>,
        record_id: Option<Uuid>,
        record_kind: Option<RecordKind>,
        job_state: Option<JobChange>,
    }
}

row! {
    /// An event among those of all jobs.
    pub struct ToldEventRow {
        @place: EventPlace,
        @event: EventRow,
        job_id: Uuid,
    }
}

impl TryFrom<ToldEventRow> for ToldEvent {
    type Error = StoreError;

    fn try_from(row: ToldEventRow) -> Result<Self, StoreError> {
        Ok(ToldEvent { place: row.place, job: row.job_id, event: row.event.try_into()? })
    }
}

impl TryFrom<EventRow> for JobEvent {
    type Error = StoreError;

    fn try_from(row: EventRow) -> Result<Self, StoreError> {
        let damaged = || StoreError::from(RepositoryError::Failed(damaged("an event", &row.kind)));
        let iteration = row.iteration;
        let whole = |count: Option<u64>| count.ok_or_else(damaged);
        let kind = match row.kind.as_str() {
            "iteration" => EventKind::Iteration {
                number: iteration.ok_or_else(damaged)?,
                id: row.iteration_id.ok_or_else(damaged)?,
                fit_id: row.fit_id.ok_or_else(damaged)?,
            },
            "fit" => EventKind::Fit {
                number: iteration.ok_or_else(damaged)?,
                fit_id: row.fit_id.ok_or_else(damaged)?,
                chosen: row.choice.is_some(),
                reason: row.choice_reason,
            },
            "decision" => EventKind::Decision {
                number: iteration.ok_or_else(damaged)?,
                decision: row.decision.ok_or_else(damaged)?,
                reason: row.decision_reason,
            },
            "stream" => EventKind::Stream {
                id: row.stream_id.ok_or_else(damaged)?,
                state: row.state.ok_or_else(damaged)?,
                sequence: whole(row.sequence)?,
                node_count: whole(row.node_count)?,
                iteration,
            },
            "record" => EventKind::Record {
                number: iteration.ok_or_else(damaged)?,
                id: row.record_id.ok_or_else(damaged)?,
                kind: row.record_kind.ok_or_else(damaged)?,
            },
            "job" => EventKind::Job { state: row.job_state.ok_or_else(damaged)? },
            "purged" => EventKind::Purged { reason: row.purge_reason.ok_or_else(damaged)? },
            _ => return Err(damaged()),
        };
        Ok(JobEvent { number: row.number, created_at: row.created_at, kind })
    }
}
