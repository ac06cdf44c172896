//! What stores of different databases share: operations as data, the handles that take them, the
//! queue of writes, and rows.

mod access;
mod around;
mod columns;
mod error;
mod handle;
mod maintenance;
mod operation;
mod queue;
mod row;
mod weight;

pub use access::{Read, Write};
pub use around::around;
pub use columns::{Digest, Integer, Moment, NodesColumn, Tags};
pub use error::{Outcome, StoreError, damaged};
pub use handle::{Backend, Handle};
pub use maintenance::{ForgetAnswers, Probe};
pub use operation::{
    Asked, Choose, Decide, DeleteJob, DeleteStream, FinishStream, GetAnswer, GetBlockSha256, GetBlocks, GetEvents,
    GetFit, GetIteration, GetJob, GetLastEvent, GetLatestRecord, GetMeasurand, GetNodes, GetNodesUpTo, GetPredecessors,
    GetRecord, GetStream, GetStreamState, GetSuccessors, GetTrace, InsertBlock, InsertFit, InsertIteration, InsertJob,
    InsertRecord, InsertRuns, InsertStream, ListFits, ListJobs, ListRecords, PatchJob,
};
pub use queue::{Pending, Queue, Queued, Run, Waiting, queue};
pub use row::{
    AnswerRow, BlockRow, ChoiceRow, DecisionRow, EventRow, FitRow, FitSummaryRow, IterationRow, JobRow, MeasurandRow,
    RecordRow, RecordSummaryRow, StreamRow, TracedFitRow, TracedIterationRow,
};
pub(in crate::store) use row::{figure_columns, job_columns};
