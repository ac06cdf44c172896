//! Each query once, for both databases.
//!
//! A [`Db`] is a connection to one of them, with the same calls for both; [`Value`] is a value of a
//! statement, and `row/` has the rows that are read. The schemas have the same tables and keys, and
//! views and triggers of the same names where the databases differ (`migrations/`).
//!
//! A read is a function with the name of the repository's method; a write is an `impl Write` of its
//! struct in `writes`. Each table or two have a file with both. A `Handle` is the store as one
//! caller sees it: reads go to the readers, and writes wait in a queue for a transaction that they
//! share (`group`, [`Session`]).

#[macro_use]
mod value;
mod answers;
mod api_keys;
mod around;
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
mod keyed;
mod keys;
mod lists;
mod locate;
mod mappings;
mod neighbours;
mod plants;
mod purges;
mod queue;
mod read_turns;
mod records;
mod row;
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
pub use queue::{Queued, Waiting, queue};
#[cfg(test)]
pub use read_turns::{EndsRead, Watch};
pub use read_turns::{READ_TIME, READING, ReadTurns};
pub use session::{Proof, Session};
pub use store::{Database, Shared, SqlStore, seconds};
pub use value::Value;

/// The reads, by the names of the repository's methods.
mod reads {
    pub use super::{
        answers::answer,
        api_keys::{find_certificate, find_key, has_keys, key, keys},
        audit::{audit, seals},
        blocks::{block_sha256, blocks, stream_state},
        events::{all_events, events, last_event, last_place, tells_all_after},
        fits::{fit, fits},
        iterations::{iteration, iterations, measurand, nodes, nodes_up_to, predecessors, rounds, successors},
        job_list::{job_counts, jobs},
        jobs::job,
        mappings::mapping,
        plants::{plant, plants},
        records::{latest_record, record, records},
        streams::{stream, streams},
        trace::trace,
    };
}
