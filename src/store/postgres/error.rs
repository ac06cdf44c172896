//! Errors of the database in plain words. No password is in any of them: a database is named by
//! host, port and name.

use sqlx::migrate::MigrateError;

use crate::jobs::RepositoryError;

/// Why the store could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum PostgresError {
    #[error("this is not a database URL of the form postgres://USER@HOST:PORT/DATABASE: {reason}")]
    Url { reason: String },
    #[error("the database {address} cannot be reached: {told}", told = said(source))]
    Connect { address: String, source: sqlx::Error },
    #[error("the database {address} is PostgreSQL {version}; flankfit needs 15 or later")]
    TooOld { address: String, version: i64 },
    #[error("the database {address} is a standby: name the service that follows the primary")]
    InRecovery { address: String },
    #[error("the database {address} keeps texts as {encoding}; make one with ENCODING 'UTF8'")]
    Encoding { address: String, encoding: String },
    #[error(
        "the server of {address} has {setting} = off: what it says is stored may be lost with its power; turn it on, \
         or say --unsafe-store"
    )]
    Unsafe { address: String, setting: &'static str },
    #[error("the database {address} needs a newer flankfit (one that knows migration {migration})")]
    Newer { address: String, migration: i64 },
    /// One of a development version, before the migrations began again.
    #[error(
        "the database {address} was made by an earlier development version, which this version does not read: start \
         with a new database"
    )]
    Earlier { address: String },
    #[error("the database {address} cannot be brought up to date: {told}", told = not_migrated(source))]
    Migration { address: String, source: MigrateError },
}

/// PostgreSQL's code of a missing right.
const NO_RIGHT: &str = "42501";

/// An error in words. The library adds a line number, which is one of PostgreSQL's own sources.
pub fn said(error: &sqlx::Error) -> String {
    error.as_database_error().map_or_else(|| error.to_string(), |database| database.message().to_owned())
}

/// Why the schema could not be made or renewed, and who can.
fn not_migrated(error: &MigrateError) -> String {
    let (told, source) = match error {
        MigrateError::Execute(source) => (said(source), source),
        MigrateError::ExecuteMigration(source, number) => (format!("migration {number}: {}", said(source)), source),
        other => return other.to_string(),
    };
    match source.as_database_error().and_then(|error| error.code()).as_deref() {
        Some(NO_RIGHT) => {
            format!(
                "{told}; its owner makes the schema with `flankfit migrate`, another role starts with --migrate check"
            )
        }
        _ => told,
    }
}

/// The reaction to an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The data will not be had: each write of the group is tried alone.
    Refused,
    /// Another transaction was in the way: the same once more.
    Again,
    /// The server or the connection is gone: the same on another connection.
    Lost,
    Other,
}

pub fn class(error: &sqlx::Error) -> Class {
    let sqlx::Error::Database(database) = error else {
        return match error {
            sqlx::Error::Io(_) | sqlx::Error::Tls(_) | sqlx::Error::PoolTimedOut => Class::Lost,
            // what came is no answer to what was asked: the connection is not to be used any more
            sqlx::Error::Protocol(_) | sqlx::Error::BeginFailed => Class::Lost,
            // a write that was refused after its first change
            sqlx::Error::InvalidArgument(_) => Class::Refused,
            _ => Class::Other,
        };
    };
    match database.code().as_deref() {
        Some("40001" | "40P01" | "55P03") => Class::Again,
        // ended by an administrator, shutting down, starting up; too many connections; ended while
        // idle in a transaction; a primary that has become a standby
        Some("57P01" | "57P02" | "57P03" | "57P05" | "53300" | "25P03" | "25006") => Class::Lost,
        Some(code) if code.starts_with("22") || code.starts_with("23") => Class::Refused,
        Some(code) if code.starts_with("08") => Class::Lost,
        _ => Class::Other,
    }
}

/// Returns whether the server or the connection is gone, and not only every connection in use.
pub fn is_lost(error: &sqlx::Error) -> bool {
    class(error) == Class::Lost && !matches!(error, sqlx::Error::PoolTimedOut)
}

/// An SQL error as the callers of the repository see it; the detail is for the log.
pub fn failure(error: &sqlx::Error) -> RepositoryError {
    let code = error.as_database_error().and_then(|error| error.code());
    match (class(error), code.as_deref()) {
        (Class::Lost | Class::Again, _) => RepositoryError::Unavailable(said(error)),
        (Class::Other, _) if matches!(error, sqlx::Error::PoolClosed | sqlx::Error::WorkerCrashed) => {
            RepositoryError::Unavailable(said(error))
        }
        // a table or a column is not there
        (Class::Other, Some("42P01" | "42703")) => RepositoryError::Unavailable(format!(
            "{}: the database has no schema yet, or an older one; run `flankfit migrate`",
            said(error)
        )),
        // out of disk or memory; took too long; no rights
        (Class::Other, Some("57014" | NO_RIGHT)) => RepositoryError::Unavailable(said(error)),
        (Class::Other, Some(code)) if code.starts_with("53") => RepositoryError::Unavailable(said(error)),
        _ => RepositoryError::Failed(said(error)),
    }
}
