//! Use of a PostgreSQL database. For SQLite none of it matters.

use std::time::Duration;

use clap::{Args, ValueEnum};

/// Upgrade of the database's schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MigrateMode {
    /// The first server that starts; the others wait for it.
    #[default]
    Auto,
    /// `flankfit migrate`; until then a server is not ready.
    Check,
}

#[derive(Clone, Debug, PartialEq, Eq, Args)]
pub struct PostgresArguments {
    /// PostgreSQL: number of connections for writes.
    #[arg(long, env = "FLANKFIT_STORE_WRITERS", default_value_t = 4,
        value_parser = clap::value_parser!(u16).range(1..=64))]
    pub store_writers: u16,
    /// PostgreSQL: number of connections for reads.
    #[arg(long, env = "FLANKFIT_DATABASE_READERS", default_value_t = 8,
        value_parser = clap::value_parser!(u16).range(1..=256))]
    pub database_readers: u16,
    /// PostgreSQL: seconds for which a read or write is retried while the server does not answer.
    #[arg(long, env = "FLANKFIT_STORE_PATIENCE", default_value_t = 5,
        value_parser = clap::value_parser!(u64).range(1..=60))]
    pub store_patience: u64,
    /// PostgreSQL: who upgrades the schema.
    #[arg(long, env = "FLANKFIT_MIGRATE", value_enum, default_value_t = MigrateMode::Auto)]
    pub migrate: MigrateMode,
    /// PostgreSQL: URL for migrations and notifications between servers that bypasses a pooler.
    #[arg(long, env = "FLANKFIT_DATABASE_DIRECT_URL", hide_env_values = true)]
    pub database_direct_url: Option<String>,
    /// PostgreSQL: serve although fsync, full_page_writes or synchronous_commit is off and the
    /// server may lose stored data.
    #[arg(long, env = "FLANKFIT_UNSAFE_STORE")]
    pub unsafe_store: bool,
}

impl PostgresArguments {
    pub fn patience(&self) -> Duration {
        Duration::from_secs(self.store_patience)
    }
}
