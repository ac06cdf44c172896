//! `flankfit backup FILE`: a copy of the database, also while a server writes to it.

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
};

use clap::Args;

use super::{CommandError, out::out, progress, runtime};
use crate::store::{PostgresSettings, StoreSettings, backup, unfinished_backup};

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
    let runtime = runtime()?;
    let (from, to) = (source.path(), unfinished_backup(&arguments.file));
    progress::watched("backup", || Some(part(&from, &to)), || runtime.block_on(backup(&source, &arguments.file)))?;
    Ok(writeln!(out(), "{} copied to {}", source.path().display(), arguments.file.display())?)
}

/// Returns the share of a file that is in another one, 0 to 1. A copy has no gaps and may be
/// shorter.
fn part(from: &Path, to: &Path) -> f64 {
    let [from, to] = [from, to].map(|file| fs::metadata(file).map_or(0, |about| about.len()) as f64);
    (to / from.max(1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_grows_up_to_the_whole() {
        let folder = tempfile::tempdir().unwrap();
        let [from, to] = ["from", "to"].map(|name| folder.path().join(name));
        assert_eq!(part(&from, &to), 0.0);
        fs::write(&from, [0_u8; 400]).unwrap();
        assert_eq!(part(&from, &to), 0.0);
        for (length, wanted) in [(100, 0.25), (400, 1.0), (500, 1.0)] {
            fs::write(&to, vec![0_u8; length]).unwrap();
            assert_eq!(part(&from, &to), wanted);
        }
    }
}
