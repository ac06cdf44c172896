//! The stores: everything that is SQL. A store implements the repository of [`crate::jobs`].
//!
//! `sql/` has each query once, for both databases; `sqlite/` and `postgres/` open a database, write
//! its transactions and explain its errors.

#[macro_use]
mod by_name;
mod migrations;
mod postgres;
mod sql;
mod sqlite;

pub use postgres::{
    Migrate, PostgresError, PostgresSettings, migrate, open_postgres, postgres_auditor, postgres_holdings,
    postgres_migrations,
};
pub use sql::{SqlAuditor, SqlHoldings, SqlStore};
pub use sqlite::{
    BackupError, OpenError, StoreSettings, backup, migrations, open_sqlite, sqlite_auditor, sqlite_holdings,
    unfinished_backup,
};
