//! Errors of the database in plain words.

use std::path::PathBuf;

use crate::jobs::RepositoryError;

/// Why the store could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The URL is not repeated: there could be a password in it.
    #[error("this is not a database URL of the form sqlite://FILE: {reason}")]
    Url { reason: String },
    #[error(
        "an in-memory database cannot be shared by a writer and its readers: name a file, such as sqlite://flankfit.db"
    )]
    InMemory,
    /// SQLite's code 14.
    #[error(
        "cannot open or create the database {path}: its directory must exist and be writable by the user that runs \
         flankfit \
         (beside the file SQLite keeps {path}-wal and {path}-shm); in a container, give the volume to that user",
         path = path.display()
    )]
    CannotOpen { path: PathBuf },
    /// SQLite's code 8.
    #[error("the database {path} is read-only: the file and its directory must be writable by the user that runs \
        flankfit", path = path.display())]
    ReadOnly { path: PathBuf },
    /// Who only reads makes none.
    #[error("there is no database at {path}; name the one that the server uses", path = path.display())]
    Missing { path: PathBuf },
    /// Another process holds the lock.
    #[error(
        "the database {path} is in use: another flankfit writes it (it holds {lock}); stop that one, or name another \
         database with \
         --database-url", path = path.display(), lock = lock.display()
    )]
    InUse { path: PathBuf, lock: PathBuf },
    #[error(
        "the database {path} has another name (a hard link), by which another server could write it; remove that name, \
         or name a copy", path = path.display()
    )]
    Linked { path: PathBuf },
    /// SQLite's code 26.
    #[error("{path} is not an SQLite database", path = path.display())]
    NotADatabase { path: PathBuf },
    #[error("the database {path} was written by a newer flankfit (its migration {version} is unknown here)",
        path = path.display())]
    Newer { path: PathBuf, version: i64 },
    /// One of a development version, before the migrations began again.
    #[error("the database {path} was made by an earlier development version, which this version does not read: \
        start with a new database", path = path.display())]
    Earlier { path: PathBuf },
    #[error("the database {path} cannot be brought up to date: {source}", path = path.display())]
    Migration { path: PathBuf, source: sqlx::migrate::MigrateError },
    #[error("the database {path} cannot be opened: {source}", path = path.display())]
    Other { path: PathBuf, source: sqlx::Error },
}

/// SQLite's primary result code behind an error, where there is one.
pub fn code(error: &sqlx::Error) -> Option<i32> {
    let code = error.as_database_error()?.code()?.parse::<i32>().ok()?;
    Some(code & 0xff)
}

/// Primary result codes that mean "not now".
const BUSY: i32 = 5;
const LOCKED: i32 = 6;
const FULL: i32 = 13;
const INPUT_OUTPUT: i32 = 10;
const READ_ONLY: i32 = 8;
const CANNOT_OPEN: i32 = 14;
const NOT_A_DATABASE: i32 = 26;
const INTERRUPTED: i32 = 9;

impl OpenError {
    pub fn from_sqlx(path: PathBuf, source: sqlx::Error) -> Self {
        match code(&source) {
            Some(CANNOT_OPEN) => OpenError::CannotOpen { path },
            Some(READ_ONLY) => OpenError::ReadOnly { path },
            Some(NOT_A_DATABASE) => OpenError::NotADatabase { path },
            _ => OpenError::Other { path, source },
        }
    }

    pub fn from_migration(path: PathBuf, source: sqlx::migrate::MigrateError) -> Self {
        use sqlx::migrate::MigrateError;
        match source {
            MigrateError::VersionMissing(version) => OpenError::Newer { path, version },
            MigrateError::Execute(source) | MigrateError::ExecuteMigration(source, _) if code(&source).is_some() => {
                OpenError::from_sqlx(path, source)
            }
            source => OpenError::Migration { path, source },
        }
    }
}

/// An SQL error as the callers of the repository see it; the detail is for the log.
pub fn failure(error: &sqlx::Error) -> RepositoryError {
    match error {
        sqlx::Error::PoolTimedOut | sqlx::Error::PoolClosed | sqlx::Error::WorkerCrashed => {
            RepositoryError::Unavailable(error.to_string())
        }
        _ => match code(error) {
            Some(BUSY | LOCKED) => RepositoryError::Unavailable("another program holds the database".into()),
            Some(INTERRUPTED) => RepositoryError::Unavailable("the read took too long and was ended".into()),
            Some(FULL) => RepositoryError::Unavailable("the disk is full".into()),
            Some(READ_ONLY) => RepositoryError::Unavailable("the database is read-only".into()),
            Some(INPUT_OUTPUT) => RepositoryError::Unavailable(format!("the disk does not write: {error}")),
            _ => RepositoryError::Failed(error.to_string()),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sqlx::{ConnectOptions as _, sqlite::SqliteConnectOptions};

    #[tokio::test]
    async fn a_database_that_became_read_only_is_not_available() {
        let mut db = SqliteConnectOptions::new().in_memory(true).connect().await.unwrap();
        sqlx::query("PRAGMA query_only = ON").execute(&mut db).await.unwrap();
        let error = sqlx::query("CREATE TABLE t (x INTEGER)").execute(&mut db).await.unwrap_err();
        assert_eq!(code(&error), Some(READ_ONLY));
        let failure = failure(&error);
        assert!(matches!(&failure, RepositoryError::Unavailable(why) if why.contains("read-only")), "{failure}");
    }
}
