//! Jobs in SQLite.
//!
//! **One writer.** All writes go through one task that owns the only writing connection (`writer`).
//! Requests that wait together share one transaction and so one sync of the write-ahead log; none
//! is answered before it. Nothing else writes, so no request can meet a locked database, and rows
//! that were read inside the transaction are the same when it commits.
//!
//! **One process.** A lock file next to the database keeps a second writing process away (`lock`).
//!
//! **Many readers.** Reads come from a pool of read-only connections; with the write-ahead log they
//! neither wait for the writer nor hold it up, and each sees one consistent state.
//!
//! **Durability.** `journal_mode=WAL` with `synchronous=FULL`: a commit returns after the log has
//! been synced.
//!
//! **Form.** STRICT tables, foreign keys enforced, triggers that refuse to change the trace. A
//! figure that does not exist is NULL; NaN never gets here (SQLite would make it NULL).

mod backup;
mod error;
mod in_place;
mod lock;
mod open;
mod writer;

pub use backup::{BackupError, backup, unfinished as unfinished_backup};
pub use error::{OpenError, failure};
pub use open::{StoreSettings, migrations, open_sqlite, sqlite_auditor, sqlite_holdings};
