//! Jobs in PostgreSQL, for several processes at a time.
//!
//! **Writers.** Writes go by their job to one of a few tasks (`writer`), each with a connection of
//! its own (`session`). What waits there together shares one transaction and so one sync. It locks
//! the rows of its jobs in ascending order, then claims its idempotency keys in ascending order,
//! and only then reads: numbers, positions and versions that were read hold until it commits, and
//! no two transactions wait for each other.
//!
//! **A lost COMMIT is settled.** Each transaction first takes a lock of its own and last stores the
//! entries of the audit. Where the connection was lost before the answer to COMMIT, the repetition
//! takes the same lock: it waits for the end of the first transaction, and finds its entries there,
//! or not.
//!
//! **Readers.** Reads come from a pool of connections; one that asks more than once does so in one
//! read-only transaction of the level REPEATABLE READ.
//!
//! **Wakes.** After its commits a process tells the others by NOTIFY what has changed (`wakes`).
//!
//! **Form.** Documents are their text, or a frame of zstd where it is long (`document`); times are
//! timestamptz; ids uuid; nodes the binary form of [`crate::jobs::nodes_codec`]. Triggers write
//! events and refuse to change the trace, as in SQLite.
//!
//! Each table or two have a file with their reads and writes.

mod answers;
mod api_keys;
mod audit;
mod audit_keys;
mod audit_reads;
mod audit_seals;
mod auditor;
mod blocks;
mod decisions;
mod document;
mod error;
mod events;
mod fits;
mod folded;
mod gone;
mod holdings;
mod insert_iterations;
mod iterations;
mod job_list;
mod jobs;
mod keys;
mod leases;
mod locate;
mod mappings;
mod message;
mod migrate;
mod open;
mod plants;
mod purges;
mod records;
mod runs;
mod session;
mod settings;
mod store;
mod streams;
mod tasks;
mod time;
mod trace;
mod upkeep;
mod wakes;
mod writer;

pub use auditor::PostgresAuditor;
pub use error::PostgresError;
pub use holdings::PostgresHoldings;
pub use migrate::{migrate, postgres_migrations};
pub use settings::{Migrate, PostgresSettings};
pub use store::PostgresStore;
