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
mod read_turns;
mod row;
mod search;
mod subject;
mod weight;

pub use about::{of_job, of_keys};
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
pub use maintenance::{
    ClaimTask, EndTask, FindCertificate, FindKey, ForgetAnswers, ForgetTasks, ForgetTold, GiveTaskBack, HasKeys,
    NOTED_EVERY, NoteUses, PROBE, Probe, RenewTasks, SealAudit,
};
pub use neighbours::{CorrectionRow, MeasuredRow, PredecessorRow, SuccessorRow, predecessors, rounds, successors};
pub use operation::{
    Amend, Asked, CancelTask, Choose, Decide, DeleteJob, DeleteStream, FinishStream, GetAllEvents, GetAnswer, GetAudit,
    GetBlockSha256, GetBlocks, GetEvents, GetFit, GetIteration, GetJob, GetJobCounts, GetKey, GetLastEvent,
    GetLastPlace, GetLatestRecord, GetMapping, GetMeasurand, GetNodes, GetNodesUpTo, GetPlant, GetPredecessors,
    GetRecord, GetRounds, GetSeals, GetStream, GetStreamState, GetSuccessors, GetTask, GetTaskOfKey, GetTaskResult,
    GetTrace, InsertBlock, InsertFit, InsertIteration, InsertJob, InsertKey, InsertPlant, InsertRecord, InsertRuns,
    InsertStream, InsertTask, KeepMapping, Key, ListFits, ListIterations, ListJobs, ListKeys, ListPlants, ListRecords,
    ListStreams, ListTasks, Operation, PatchJob, PatchKey, PatchPlant, PurgeJob, RevokeKey, RotateKey, TellsAllAfter,
    VerifyAudit, key_of,
};
pub use queue::{Pending, Queue, Queued, Run, Waiting, queue};
#[cfg(test)]
pub use read_turns::{EndsRead, Watch};
pub use read_turns::{READ_TIME, READING, ReadTurns};
pub use row::{
    AnswerRow, BlockRow, ChoiceRow, ClaimedTaskRow, DayRow, DecisionRow, EntryRow, EventRow, FitRow, FitSummaryRow,
    FoundBlock, FoundFitTold, FoundIteration, FoundJobPurge, FoundNodes, FoundPurge, FoundRow, FoundStreamRow,
    GrownRow, HeadRow, HeldRow, IterationRow, JobPurge, JobRow, KeptKeyRow, KeyRow, KeyedTaskRow, KnownKeyRow,
    LastSealRow, Latest, ListedIterationRow, ListedJobRow, MachineRow, MachinesRow, MeasurandRow, MeasuredTooth,
    NewestSealRow, NodesRow, PlantRow, PurgeRow, RecordRow, RecordSummaryRow, SealRow, SealedHeadRow, StateRow,
    StatusRow, StreamRow, TaskResultRow, TaskRow, ToldEventRow, TracedFitRow, TracedIterationRow, counts, entries,
    grown, last_seals, page_of_seals,
};
pub(in crate::store) use row::{
    claimed_task_columns, entry_columns, figure_columns, job_columns, key_columns, plant_columns, seal_columns,
    task_columns,
};
pub use search::{FEW, Parts};
pub use subject::Subject;
