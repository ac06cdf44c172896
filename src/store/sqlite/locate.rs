//! Where jobs and iterations are: the rows of SQLite's own keys.

use sqlx::{FromRow, SqliteConnection};
use uuid::Uuid;

use crate::{
    jobs::{RepositoryError, Resource, Tenant},
    store::shared::{Integer, Outcome, StoreError},
};

/// A row with the key that SQLite gave it.
#[derive(FromRow)]
pub struct WithSeq<T> {
    pub seq: i64,
    #[sqlx(flatten)]
    pub row: T,
}

/// The row of an iteration.
pub async fn iteration_seq(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid, number: u32) -> Outcome<i64> {
    let seq = sqlx::query_scalar(
        "SELECT i.seq FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? AND i.number = ?",
    )
    .bind(job)
    .bind(tenant.as_str())
    .bind(number)
    .fetch_optional(&mut *db)
    .await?;
    match seq {
        Some(seq) => Ok(seq),
        None => Err(which_is_missing(db, tenant, job).await),
    }
}

/// Whether the job or only its iteration does not exist.
pub async fn which_is_missing(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid) -> StoreError {
    let job = sqlx::query("SELECT 1 FROM jobs WHERE id = ? AND tenant = ?").bind(job).bind(tenant.as_str());
    match job.fetch_optional(db).await {
        Ok(Some(_)) => RepositoryError::NotFound(Resource::Iteration).into(),
        Ok(None) => RepositoryError::NotFound(Resource::Job).into(),
        Err(error) => error.into(),
    }
}

/// The row of an iteration, and its version.
pub struct IterationVersion {
    pub seq: i64,
    pub version: u64,
}

#[derive(FromRow)]
struct IterationVersionRow {
    /// Of a job that has no iteration of this number there is none.
    seq: Option<i64>,
    /// Nor is there a version.
    version: Option<Integer<u64>>,
}

pub async fn iteration(
    db: &mut SqliteConnection,
    tenant: &Tenant,
    job: Uuid,
    number: u32,
) -> Outcome<IterationVersion> {
    let row: IterationVersionRow = sqlx::query_as(
        "SELECT i.seq AS seq,
                CASE WHEN i.seq NOTNULL THEN
                    (SELECT count(*) FROM fits WHERE iteration = i.seq)
                    + (SELECT count(*) FROM fit_choices WHERE iteration = i.seq)
                    + (SELECT count(*) FROM decisions WHERE iteration = i.seq) - 1
                END AS version
         FROM jobs j LEFT JOIN iterations i ON i.job = j.seq AND i.number = ? WHERE j.id = ? AND j.tenant = ?",
    )
    .bind(number)
    .bind(job)
    .bind(tenant.as_str())
    .fetch_optional(&mut *db)
    .await?
    .ok_or(RepositoryError::NotFound(Resource::Job))?;
    let (seq, Integer(version)) = row.seq.zip(row.version).ok_or(RepositoryError::NotFound(Resource::Iteration))?;
    Ok(IterationVersion { seq, version })
}

/// SQLite's integers are signed; versions and counts are far below 2⁶³, and a cursor beyond is
/// behind every row.
pub fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
