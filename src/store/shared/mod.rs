//! What stores of different databases share: writes as data, their queue, and rows.

mod columns;
mod error;
mod operation;
mod queue;
mod row;

pub use columns::{Digest, Integer, Moment, NodesColumn, Tags};
pub use error::{Outcome, StoreError, damaged};
pub use operation::{
    Choose, Decide, DeleteJob, DeleteStream, FinishStream, ForgetAnswers, InsertBlock, InsertFit, InsertIteration,
    InsertJob, InsertRecord, InsertRuns, InsertStream, PatchJob, Probe, Run,
};
pub use queue::{Pending, Queue, Waiting, Write, queue};
pub use row::{
    AnswerRow, BlockRow, ChoiceRow, DecisionRow, EventRow, FitRow, FitSummaryRow, IterationRow, JobRow, MeasurandRow,
    RecordRow, RecordSummaryRow, StreamRow, TracedFitRow, TracedIterationRow,
};
pub(in crate::store) use row::{figure_columns, job_columns};
