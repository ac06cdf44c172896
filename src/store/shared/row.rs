//! Rows by the names of their columns, and the domain values that they become. A store's SQL gives
//! its columns these names; a row struct reads no column that it does not name.

use sqlx::FromRow;
use uuid::Uuid;

use super::{
    columns::{CriterionName, Digest, Flank, Moment, NodesColumn, SchemeName, Tags, Whole},
    error::{StoreError, damaged},
};
use crate::jobs::{
    Answer, Block, Choice, Decision, Event, EventKind, Figures, FitRecord, FitSummary, Iteration, Job, JobEvent,
    Measurand, Record, RecordDraft, RecordKind, RecordSummary, RepositoryError, Ruling, Stream, StreamEvent, TracedFit,
    TracedIteration,
};

/// The columns of [`JobRow`].
macro_rules! job_columns {
    () => {
        "id, name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at"
    };
}
pub(in crate::store) use job_columns;

#[derive(FromRow)]
pub struct JobRow {
    id: Uuid,
    name: String,
    part_number: Option<String>,
    serial_number: Option<String>,
    machine: Option<String>,
    gear: Option<String>,
    tags: Tags,
    version: Whole<u64>,
    created_at: Moment,
    updated_at: Moment,
}

impl From<JobRow> for Job {
    fn from(row: JobRow) -> Self {
        Job {
            id: row.id,
            name: row.name,
            part_number: row.part_number,
            serial_number: row.serial_number,
            machine: row.machine,
            gear: row.gear.map(Into::into),
            tags: row.tags.0,
            version: row.version.0,
            created_at: row.created_at.0,
            updated_at: row.updated_at.0,
        }
    }
}

#[derive(FromRow)]
pub struct MeasurandRow {
    flank: Option<Flank>,
    tooth: Option<String>,
    axes: Option<String>,
}

impl From<MeasurandRow> for Measurand {
    fn from(MeasurandRow { flank, tooth, axes }: MeasurandRow) -> Self {
        Measurand { flank: flank.map(|Flank(side)| side), tooth, axes: axes.map(Into::into) }
    }
}

#[derive(FromRow)]
pub struct IterationRow {
    id: Uuid,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    measured_at: Option<Moment>,
    instrument: Option<String>,
    operator: Option<String>,
    note: Option<String>,
    created_at: Moment,
    node_count: Whole<u64>,
    version: Whole<u64>,
}

impl IterationRow {
    /// The iteration of this number of a job, with its last fits and how many stand before them.
    pub fn with(
        self,
        (job_id, number): (Uuid, u32),
        (fits, earlier_fits): (Vec<FitSummary>, u64),
        ruling: Option<Ruling>,
    ) -> Iteration {
        Iteration {
            id: self.id,
            job_id,
            number,
            measurand: self.measurand.into(),
            measured_at: self.measured_at.map(|at| at.0),
            instrument: self.instrument,
            operator: self.operator,
            note: self.note,
            created_at: self.created_at.0,
            node_count: self.node_count.0,
            version: self.version.0,
            fits,
            earlier_fits,
            ruling,
        }
    }
}

#[derive(FromRow)]
pub struct TracedIterationRow {
    id: Uuid,
    number: Whole<u32>,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    measured_at: Option<Moment>,
    created_at: Moment,
}

impl From<TracedIterationRow> for TracedIteration {
    /// Without the lists.
    fn from(row: TracedIterationRow) -> Self {
        TracedIteration {
            id: row.id,
            number: row.number.0,
            measurand: row.measurand.into(),
            measured_at: row.measured_at.map(|at| at.0),
            created_at: row.created_at.0,
            fits: Vec::new(),
            choices: Vec::new(),
            rulings: Vec::new(),
            records: Vec::new(),
            earlier: Default::default(),
        }
    }
}

/// The columns of [`FigureRow`].
macro_rules! figure_columns {
    () => {
        "lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms, \
         max_abs"
    };
}
pub(in crate::store) use figure_columns;

#[derive(FromRow)]
struct FigureRow {
    lambda_star: Option<f64>,
    criterion: Option<CriterionName>,
    scheme: Option<SchemeName>,
    count: Option<Whole<u32>>,
    condition: Option<f64>,
    regularized_condition: Option<f64>,
    bias_norm: Option<f64>,
    bias_sharp_bound: Option<f64>,
    rms: Option<f64>,
    max_abs: Option<f64>,
}

impl From<FigureRow> for Figures {
    fn from(row: FigureRow) -> Self {
        Figures {
            lambda_star: row.lambda_star,
            criterion: row.criterion.map(|name| name.0),
            scheme: row.scheme.map(|name| name.0),
            count: row.count.map(|count| count.0),
            condition: row.condition,
            regularized_condition: row.regularized_condition,
            bias_norm: row.bias_norm,
            bias_sharp_bound: row.bias_sharp_bound,
            rms: row.rms,
            max_abs: row.max_abs,
        }
    }
}

/// When something was said, and why.
#[derive(FromRow)]
struct ReasonRow {
    reason: Option<String>,
    created_at: Moment,
}

impl From<ReasonRow> for Event {
    fn from(ReasonRow { reason, created_at }: ReasonRow) -> Self {
        Event { reason, created_at: created_at.0 }
    }
}

#[derive(FromRow)]
pub struct FitRow {
    id: Uuid,
    reason: Option<String>,
    created_at: Moment,
    chosen: bool,
    spec: String,
    result: String,
}

impl From<FitRow> for FitRecord {
    fn from(row: FitRow) -> Self {
        FitRecord {
            id: row.id,
            spec: row.spec.into(),
            result: row.result.into(),
            reason: row.reason,
            created_at: row.created_at.0,
            chosen: row.chosen,
        }
    }
}

#[derive(FromRow)]
pub struct FitSummaryRow {
    id: Uuid,
    #[sqlx(flatten)]
    event: ReasonRow,
    chosen: bool,
    #[sqlx(flatten)]
    figures: FigureRow,
}

impl From<FitSummaryRow> for FitSummary {
    fn from(row: FitSummaryRow) -> Self {
        FitSummary { id: row.id, chosen: row.chosen, figures: row.figures.into(), event: row.event.into() }
    }
}

#[derive(FromRow)]
pub struct TracedFitRow {
    #[sqlx(flatten)]
    summary: FitSummaryRow,
    pub coefficients: String,
}

impl From<TracedFitRow> for TracedFit {
    fn from(TracedFitRow { summary, coefficients }: TracedFitRow) -> Self {
        TracedFit { summary: summary.into(), coefficients }
    }
}

#[derive(FromRow)]
pub struct ChoiceRow {
    fit_id: Uuid,
    #[sqlx(flatten)]
    event: ReasonRow,
}

impl From<ChoiceRow> for Choice {
    fn from(ChoiceRow { fit_id, event }: ChoiceRow) -> Self {
        Choice { fit_id, event: event.into() }
    }
}

#[derive(FromRow)]
pub struct RulingRow {
    decision: Decision,
    #[sqlx(flatten)]
    event: ReasonRow,
}

impl From<RulingRow> for Ruling {
    fn from(RulingRow { decision, event }: RulingRow) -> Self {
        Ruling { decision, event: event.into() }
    }
}

#[derive(FromRow)]
pub struct RecordSummaryRow {
    id: Uuid,
    kind: RecordKind,
    method: String,
    created_at: Moment,
}

impl From<RecordSummaryRow> for RecordSummary {
    fn from(RecordSummaryRow { id, kind, method, created_at }: RecordSummaryRow) -> Self {
        RecordSummary { id, kind, method, created_at: created_at.0 }
    }
}

#[derive(FromRow)]
pub struct RecordRow {
    #[sqlx(flatten)]
    summary: RecordSummaryRow,
    request: String,
    result: String,
    gear: Option<String>,
}

impl From<RecordRow> for Record {
    fn from(RecordRow { summary, request, result, gear }: RecordRow) -> Self {
        let RecordSummaryRow { id, kind, method, created_at } = summary;
        let gear = gear.map(Into::into);
        let draft = RecordDraft { kind, method, request: request.into(), result: result.into(), gear };
        Record { id, created_at: created_at.0, draft }
    }
}

#[derive(FromRow)]
pub struct StreamRow {
    id: Uuid,
    job_id: Uuid,
    spec: String,
    forgetting_factor: f64,
    sequence: Whole<u64>,
    node_count: Whole<u64>,
    input_sha256: Digest,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    iteration: Option<Whole<u32>>,
    version: Whole<u64>,
    created_at: Moment,
    updated_at: Moment,
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

#[derive(FromRow)]
pub struct BlockRow {
    sequence: Whole<u64>,
    sha256: Digest,
    data: NodesColumn,
}

impl From<BlockRow> for Block {
    fn from(BlockRow { sequence, sha256, data }: BlockRow) -> Self {
        Block { sequence: sequence.0, sha256: sha256.0, nodes: data.0 }
    }
}

/// An event with what it names; which columns hold something depends on its kind.
#[derive(FromRow)]
pub struct EventRow {
    number: Whole<u64>,
    created_at: Moment,
    kind: String,
    iteration: Option<Whole<u32>>,
    iteration_id: Option<Uuid>,
    fit_id: Option<Uuid>,
    choice: Option<i64>,
    choice_reason: Option<String>,
    decision: Option<Decision>,
    decision_reason: Option<String>,
    stream_id: Option<Uuid>,
    state: Option<StreamEvent>,
    sequence: Option<Whole<u64>>,
    node_count: Option<Whole<u64>>,
}

impl TryFrom<EventRow> for JobEvent {
    type Error = StoreError;

    fn try_from(row: EventRow) -> Result<Self, StoreError> {
        let damaged = || StoreError::from(RepositoryError::Failed(damaged("an event", &row.kind)));
        let iteration = row.iteration.map(|number| number.0);
        let whole = |count: Option<Whole<u64>>| count.map(|count| count.0).ok_or_else(damaged);
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
            _ => return Err(damaged()),
        };
        Ok(JobEvent { number: row.number.0, created_at: row.created_at.0, kind })
    }
}

/// An answer kept under an idempotency key.
#[derive(FromRow)]
pub struct AnswerRow {
    request_sha256: Digest,
    status: Whole<u16>,
    location: Option<String>,
    etag: Option<String>,
    body: Vec<u8>,
}

impl From<AnswerRow> for ([u8; 32], Answer) {
    fn from(row: AnswerRow) -> Self {
        let answer = Answer { status: row.status.0, location: row.location, etag: row.etag, body: row.body };
        (row.request_sha256.0, answer)
    }
}
