//! Each query once, for both databases.
//!
//! A [`Db`] is a connection to one of them, with the same calls for both; [`Value`] is a value of a
//! statement, and `row/` has the rows that are read. The schemas have the same tables and keys, and
//! views and triggers of the same names where the databases differ (`migrations/`).
//!
//! Reads and writes are functions with the names of the repository's methods; a write is described
//! in `writes` and given as a struct. Each table or two have a file with both. A `Handle` is the
//! store as one caller sees it: reads go to the readers, and writes wait in a queue for a
//! transaction that they share (`group`, [`Session`]).

#[macro_use]
mod value;
mod answers;
mod api_keys;
mod audit;
mod auditor;
mod blocks;
mod columns;
mod db;
mod decisions;
mod error;
mod events;
mod fits;
mod gone;
mod group;
mod handle;
mod holdings;
mod incoming;
mod insert_iterations;
mod iterations;
mod job_list;
mod jobs;
mod keys;
mod lists;
mod locate;
mod mappings;
mod plants;
mod purges;
mod queue;
mod read_turns;
mod records;
mod rows;
mod search;
mod session;
mod store;
mod streams;
mod subject;
mod trace;
mod upkeep;
mod write;
mod writes;

pub use auditor::SqlAuditor;
pub use columns::{Cell, column};
pub use db::{Db, Pool};
pub use error::failure;
pub use group::run_group;
pub use holdings::SqlHoldings;
pub use queue::{Group, Queued, Waiting, queue};
#[cfg(test)]
pub use read_turns::{EndsRead, Watch};
pub use read_turns::{READ_TIME, READING, ReadTurns};
pub use session::{Proof, Session};
pub use store::{Database, Shared, SqlStore, seconds};
pub use value::Value;

/// Reads and writes, by the names of the repository's methods.
mod operations {
    pub use super::{
        answers::*, api_keys::*, audit::*, blocks::*, decisions::*, events::*, fits::*, insert_iterations::*,
        iterations::*, job_list::*, jobs::*, mappings::*, plants::*, purges::*, records::*, streams::*, trace::*,
    };
}

/// Names that the files of tables use.
mod prelude {
    pub use std::sync::Arc;

    pub use jiff::Timestamp;
    pub use uuid::Uuid;

    pub use super::{
        audit::Draft,
        columns::Cell,
        db::{Db, Ready},
        error::{Outcome, StoreError, damaged},
        gone::JobPurge,
        value::Value,
        write::{Tx, Write},
        writes::*,
    };
    pub(super) use super::{
        audit::{entry_columns, seal_columns},
        fits::figure_columns,
        jobs::job_columns,
    };
    pub use crate::jobs::{
        audit::{Action, Entry, Link, ListedEntry, Seal},
        *,
    };
}
