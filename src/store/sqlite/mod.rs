//! Jobs in SQLite.
//!
//! **One writer.** All writes go through one task that owns the only writing connection (`writer`).
//! Requests that wait together share one transaction and so one sync of the write-ahead log; none
//! is answered before it. Nothing else writes, so no request can meet a locked database, and what
//! was read inside the transaction still holds when it commits.
//!
//! **One process.** A lock beside the database keeps a second writing process away (`lock`).
//!
//! **Many readers.** Reads come from a pool of read-only connections; with the write-ahead log they
//! neither wait for the writer nor hold it up, and each sees one consistent state: one that asks
//! more than once does so in one read transaction.
//!
//! **Durability.** `journal_mode=WAL` with `synchronous=FULL`: a commit returns after the log has
//! been synced.
//!
//! **Form.** STRICT tables, foreign keys enforced, triggers that refuse to change the trace. Times
//! are fixed-width RFC 3339 text in UTC, ids 16 bytes, nodes the binary form of
//! [`crate::jobs::nodes_codec`], answers the JSON text that was answered. A figure that does not
//! exist is NULL; NaN never gets here (SQLite would make it NULL without a word).
//!
//! Each table or two have a file with their reads and writes.

mod answers;
mod api_keys;
mod audit;
mod audit_keys;
mod audit_reads;
mod audit_seals;
mod auditor;
mod backup;
mod blocks;
mod decisions;
mod document;
mod error;
mod events;
mod fits;
mod folded;
mod gone;
mod holdings;
mod in_place;
mod insert_iterations;
mod iterations;
mod job_list;
mod jobs;
mod locate;
mod lock;
mod mappings;
mod open;
mod plants;
mod purges;
mod records;
mod runs;
mod store;
mod streams;
mod tasks;
mod time;
mod trace;
mod upkeep;
mod writer;

pub use auditor::SqliteAuditor;
pub use backup::{BackupError, backup, unfinished as unfinished_backup};
pub use error::OpenError;
pub use holdings::SqliteHoldings;
pub use open::{StoreSettings, migrations};
pub use store::SqliteStore;
