//! The stores: everything that is SQL. A store implements the repository of [`crate::jobs`].
//!
//! `shared/` holds what no store has for itself: operations as data, the handles in which callers
//! have them, the queue in which writes wait for a common transaction, and the rows that are read.
//! A store adds its SQL: one `impl Read<Readers> for …` of each read and one
//! `impl Write<Connection> for …` of each write.

#[macro_use]
mod by_name;
mod migrations;
mod postgres;
mod shared;
mod sqlite;

pub use postgres::{
    Migrate, PostgresAuditor, PostgresError, PostgresHoldings, PostgresSettings, PostgresStore, migrate,
    postgres_migrations,
};
pub use sqlite::{
    BackupError, OpenError, SqliteAuditor, SqliteHoldings, SqliteStore, StoreSettings, backup, migrations,
    unfinished_backup,
};
