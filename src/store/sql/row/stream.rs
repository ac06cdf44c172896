//! Streams, their blocks, and the events of a job.

use uuid::Uuid;

use super::iteration::MeasurandRow;
use crate::{
    jobs::{
        Block, Decision, EventKind, EventPlace, JobChange, JobEvent, RecordKind, RepositoryError, Stream, StreamEvent,
        StreamState, TaskState, ToldEvent,
    },
    store::sql::{
        columns::{Digest, Document, Integer, Moment, NodesColumn},
        error::{StoreError, damaged},
    },
};

row! {
    pub struct StreamRow {
        @measurand: MeasurandRow,
        id: Uuid,
        job_id: Uuid,
        spec: Document,
        forgetting_factor: f64,
        sequence: Integer<u64>,
        node_count: Integer<u64>,
        input_sha256: Digest,
        iteration: Option<Integer<u32>>,
        version: Integer<u64>,
        created_at: Moment,
        updated_at: Moment,
    }
}

impl StreamRow {
    /// Whether the stream was purged, with the job that it is of.
    pub fn is_gone(&self) -> Option<Uuid> {
        self.spec.0.is_empty().then_some(self.job_id)
    }
}

impl From<StreamRow> for Stream {
    fn from(row: StreamRow) -> Self {
        Stream {
            id: row.id,
            job_id: row.job_id,
            spec: row.spec.into(),
            forgetting_factor: row.forgetting_factor,
            sequence: row.sequence.0,
            node_count: row.node_count.0,
            input_sha256: row.input_sha256.0,
            measurand: row.measurand.into(),
            iteration: row.iteration.map(|number| number.0),
            version: row.version.0,
            created_at: row.created_at.0,
            updated_at: row.updated_at.0,
        }
    }
}

row! {
    pub struct BlockRow {
        sequence: Integer<u64>,
        sha256: Digest,
        data: NodesColumn,
    }
}

impl From<BlockRow> for Block {
    fn from(BlockRow { sequence, sha256, data }: BlockRow) -> Self {
        Block { sequence: sequence.0, sha256: sha256.0, nodes: data.0 }
    }
}

row! {
    /// The numbers of an estimate.
    pub struct StateRow {
        sequence: Integer<u64>,
        data: Vec<u8>,
    }
}

impl From<StateRow> for StreamState {
    fn from(StateRow { sequence, data }: StateRow) -> Self {
        StreamState { sequence: sequence.0, data }
    }
}

row! {
    /// An event with what it names; which columns hold something depends on its kind.
    pub struct EventRow {
        number: Integer<u64>,
        created_at: Moment,
        kind: String,
        iteration: Option<Integer<u32>>,
        iteration_id: Option<Uuid>,
        fit_id: Option<Uuid>,
        choice: Option<i64>,
        choice_reason: Option<String>,
        decision: Option<Decision>,
        decision_reason: Option<String>,
        stream_id: Option<Uuid>,
        state: Option<StreamEvent>,
        sequence: Option<Integer<u64>>,
        node_count: Option<Integer<u64>>,
        operation: Option<Uuid>,
        operation_state: Option<TaskState>,
        purge_reason: Option<String>,
        record_id: Option<Uuid>,
        record_kind: Option<RecordKind>,
        job_state: Option<JobChange>,
    }
}

row! {
    /// The same among those of all jobs.
    pub struct ToldEventRow {
        @event: EventRow,
        changed_by: Integer<u64>,
        place: Integer<u64>,
        job_id: Uuid,
    }
}

impl TryFrom<ToldEventRow> for ToldEvent {
    type Error = StoreError;

    fn try_from(row: ToldEventRow) -> Result<Self, StoreError> {
        let place = EventPlace { change: row.changed_by.0, number: row.place.0 };
        Ok(ToldEvent { place, job: row.job_id, event: row.event.try_into()? })
    }
}

impl TryFrom<EventRow> for JobEvent {
    type Error = StoreError;

    fn try_from(row: EventRow) -> Result<Self, StoreError> {
        let damaged = || StoreError::from(RepositoryError::Failed(damaged("an event", &row.kind)));
        let iteration = row.iteration.map(|number| number.0);
        let whole = |count: Option<Integer<u64>>| count.map(|count| count.0).ok_or_else(damaged);
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
            "operation" => EventKind::Task {
                id: row.operation.ok_or_else(damaged)?,
                state: row.operation_state.ok_or_else(damaged)?,
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
        Ok(JobEvent { number: row.number.0, created_at: row.created_at.0, kind })
    }
}
