//! The stores: everything that is SQL. A store implements the repository of [`crate::jobs`].

mod sqlite;

pub use sqlite::{BackupError, OpenError, Store, StoreSettings, backup, migrations};
