//! Rows by the names of their columns, and the domain values that they become. A store's SQL gives
//! its columns these names; a row struct reads no column that it does not name.

mod audit;
mod fit;
mod found;
mod iteration;
mod job;
mod key;
mod listing;
mod purge;
mod record;
mod seal;
mod stream;
mod task;

pub(in crate::store) use audit::entry_columns;
pub use audit::{EntryRow, HeadRow, entries};
pub use fit::{ChoiceRow, DecisionRow, FitRow, FitSummaryRow, Latest, TracedFitRow};
pub use found::{FoundBlock, FoundFitTold, FoundIteration, FoundNodes, FoundRow, FoundStreamRow};
pub use iteration::{IterationRow, ListedIterationRow, MeasurandRow, MeasuredTooth, NodesRow, TracedIterationRow};
pub use job::{AnswerRow, JobRow};
pub use key::{KeptKeyRow, KeyRow, KnownKeyRow, PlantRow};
pub use listing::{DayRow, ListedJobRow, MachineRow, MachinesRow, StatusRow, counts};
pub use purge::{FoundJobPurge, FoundPurge, JobPurge, PurgeRow, purge_name};
pub use record::{RecordRow, RecordSummaryRow};
pub use seal::{GrownRow, LastSealRow, NewestSealRow, SealRow, SealedHeadRow, grown, page_of_seals};
pub use stream::{BlockRow, EventRow, StateRow, StreamRow, ToldEventRow};
pub use task::{ClaimedTaskRow, HeldRow, KeyedTaskRow, TaskResultRow, TaskRow};
pub(in crate::store) use {
    fit::figure_columns,
    job::job_columns,
    key::{key_columns, plant_columns},
    seal::seal_columns,
    task::{claimed_task_columns, task_columns},
};
