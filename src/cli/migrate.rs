//! `flankfit migrate`: makes or renews the schema of a PostgreSQL database, as its owner.

use std::io::Write as _;

use clap::Args;

use super::{CommandError, out::out, progress, runtime};
use crate::store::{PostgresSettings, migrate};

#[derive(Debug, Args)]
pub struct MigrateArguments {
    /// Database, with the owner's role and bypassing a pooler: postgres://OWNER@HOST/NAME.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", hide_env_values = true)]
    database_url: String,
}

pub fn run(arguments: &MigrateArguments) -> Result<(), CommandError> {
    if arguments.database_url.starts_with("sqlite:") {
        return Err("`flankfit migrate` is for PostgreSQL; an SQLite file needs none: `flankfit serve` makes it and \
                    brings it up to date at its start"
            .into());
    }
    let settings = PostgresSettings::of_url(&arguments.database_url)?;
    let runtime = runtime()?;
    progress::watched("migrate", || None, || runtime.block_on(migrate(&settings)))?;
    Ok(writeln!(out(), "the schema of {} is up to date", settings.address())?)
}
