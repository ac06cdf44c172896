//! Rows by the names of their columns: types of the domain that are read as they are, and rows that
//! become one.

mod audit;
mod fit;
mod iteration;
mod job;
mod key;
mod listing;
mod record;
mod stream;

pub use audit::JobPurge;
pub use fit::TracedFitRow;
pub use iteration::{MeasuredTooth, NodesRow, SuccessorRow};
pub use job::AnswerRow;
pub use listing::NamedJob;
pub use stream::{EventRow, ToldEventRow};
pub(super) use {
    audit::{entry_columns, seal_columns},
    fit::figure_columns,
    job::job_columns,
    key::{key_columns, plant_columns},
};
