//! Errors of reads and writes.

use sqlx::sqlite::SqliteError;

use crate::{
    jobs::{RepositoryError, RepositoryFuture},
    store::{postgres, sqlite},
};

/// Reads use it like writes; for them the two differ in nothing but their cause.
#[derive(Debug)]
pub enum StoreError {
    /// Refused before anything was changed; the transaction goes on.
    Refused(RepositoryError),
    /// The database failed; the transaction is given up.
    Broken(sqlx::Error),
}

pub type Outcome<T> = Result<T, StoreError>;

impl From<sqlx::Error> for StoreError {
    /// A row that does not read is a damaged or foreign database: an error of the write that
    /// reads it, not of the others in the transaction.
    fn from(error: sqlx::Error) -> Self {
        match error {
            sqlx::Error::ColumnDecode { .. } | sqlx::Error::Decode(_) => {
                StoreError::Refused(RepositoryError::Failed(error.to_string()))
            }
            error => StoreError::Broken(error),
        }
    }
}

impl From<RepositoryError> for StoreError {
    fn from(error: RepositoryError) -> Self {
        StoreError::Refused(error)
    }
}

impl StoreError {
    /// Returns the error after a first change: the transaction must be given up.
    pub fn too_late(self) -> Self {
        match self {
            StoreError::Refused(error) => StoreError::Broken(sqlx::Error::InvalidArgument(error.to_string())),
            broken => broken,
        }
    }
}

/// Returns an error of either database as the callers of the repository see it; the detail is for
/// the log.
pub fn failure(error: &sqlx::Error) -> RepositoryError {
    match error.as_database_error().and_then(|error| error.try_downcast_ref::<SqliteError>()) {
        Some(_) => sqlite::failure(error),
        None => postgres::failure(error),
    }
}

/// Returns an error of a read as its callers see it.
pub fn reported(error: StoreError) -> RepositoryError {
    match error {
        StoreError::Refused(error) => error,
        StoreError::Broken(error) => failure(&error),
    }
}

/// Reads for callers.
pub fn reading<'a, T>(read: impl Future<Output = Outcome<T>> + Send + 'a) -> RepositoryFuture<'a, T> {
    Box::pin(async { read.await.map_err(reported) })
}

/// Describes a value of the database that does not read.
pub fn damaged(what: &str, value: &str) -> String {
    let value: String = value.chars().take(80).collect();
    format!("the database holds {what} that cannot be read: {value}")
}
