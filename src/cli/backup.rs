//! `flankfit backup FILE`: a copy of the database, also while a server writes to it.

use std::path::PathBuf;

use clap::Args;

use super::CommandError;
use crate::store::{PostgresSettings, StoreSettings, backup};

#[derive(Debug, Args)]
pub struct BackupArguments {
    /// The copy to make; a file that exists is not overwritten.
    file: PathBuf,
    /// The database to copy.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

pub fn run(arguments: &BackupArguments) -> Result<(), CommandError> {
    if PostgresSettings::takes(&arguments.database_url) {
        return Err(
            "PostgreSQL is backed up by its own means: pg_basebackup with an archive of the write-ahead log, which \
                    is recovered to any moment (point-in-time recovery), or pg_dump"
                .into(),
        );
    }
    let source = StoreSettings::of_url(&arguments.database_url)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(backup(&source, &arguments.file))?;
    println!("{} copied to {}", source.path().display(), arguments.file.display());
    Ok(())
}
