//! What stores of different databases share: operations as data, the handles that take them, the
//! queue of writes, and rows.

mod about;
mod access;
mod around;
mod audit;
mod columns;
mod error;
mod group;
mod handle;
mod incoming;
mod keyed;
mod lists;
mod maintenance;
mod neighbours;
mod operation;
mod queue;
mod row;
mod subject;
mod weight;

pub use about::of_job;
pub use access::{Read, Write};
pub use around::around;
pub use audit::{Growing, NewEntry, target};
pub use columns::{Digest, Document, Integer, Moment, Tags};
pub use error::{Outcome, StoreError, damaged};
pub use group::{InsertTogether, run_group};
pub use handle::{Backend, Handle};
pub use incoming::Incoming;
pub use keyed::{behind, place};
pub use lists::{Counted, Listed, in_order, page, told};
pub use maintenance::{FindCertificate, FindKey, ForgetAnswers, HasKeys, NoteUses, Probe};
pub use neighbours::{PredecessorRow, SuccessorRow, predecessors, successors};
pub use operation::{
    Asked, Choose, Decide, DeleteJob, DeleteStream, FinishStream, GetAnswer, GetAudit, GetBlockSha256, GetBlocks,
    GetEvents, GetFit, GetIteration, GetJob, GetKey, GetLastEvent, GetLatestRecord, GetMeasurand, GetNodes,
    GetNodesUpTo, GetPlant, GetPredecessors, GetRecord, GetStream, GetStreamState, GetSuccessors, GetTrace,
    InsertBlock, InsertFit, InsertIteration, InsertJob, InsertKey, InsertPlant, InsertRecord, InsertRuns, InsertStream,
    Key, ListFits, ListJobs, ListKeys, ListPlants, ListRecords, Operation, PatchJob, PatchKey, PatchPlant, RevokeKey,
    RotateKey, VerifyAudit, key_of,
};
pub use queue::{Pending, Queue, Queued, Run, Waiting, queue};
pub use row::{
    AnswerRow, BlockRow, ChoiceRow, DecisionRow, EntryRow, EventRow, FitRow, FitSummaryRow, FoundBlock, FoundFit,
    FoundIteration, FoundNodes, FoundRow, FoundStreamRow, HeadRow, IterationRow, JobRow, KeyRow, KnownKeyRow, Latest,
    MeasurandRow, MeasuredTooth, NodesRow, PlantRow, RecordRow, RecordSummaryRow, StateRow, StreamRow, TracedFitRow,
    TracedIterationRow, entries,
};
pub(in crate::store) use row::{entry_columns, figure_columns, job_columns, key_columns, plant_columns};
pub use subject::Subject;
