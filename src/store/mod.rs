//! The stores: everything that is SQL. A store implements the repository of [`crate::jobs`].
//!
//! `shared/` holds what no store has for itself: the writes as data, the queue in which they wait
//! for a common transaction, and the rows that are read. A store adds its SQL, and one
//! `impl Run<Connection> for …` for each write.

mod shared;
mod sqlite;

pub use sqlite::{BackupError, OpenError, Store, StoreSettings, backup, migrations};
