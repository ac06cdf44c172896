//! Row keys of jobs and iterations in SQLite.

use sqlx::{FromRow, Sqlite, SqliteConnection, SqlitePool, Transaction, sqlite::SqliteRow};
use uuid::Uuid;

use crate::{
    jobs::{Caller, MAX_LISTED, RepositoryError, Resource, Tenant},
    store::shared::{Counted, Integer, JobPurge, Outcome, StoreError, in_order},
};

row! {
    /// A row with the key that SQLite gave it.
    pub struct WithSeq<T> {
        @pub row: T,
        pub seq: i64,
    }
}

/// A job's row.
pub async fn job(db: &mut SqliteConnection, tenant: &Tenant, id: Uuid) -> Outcome<i64> {
    let found = sqlx::query_scalar("SELECT seq FROM jobs WHERE id = ? AND tenant = ?").bind(id).bind(tenant.as_str());
    Ok(found.fetch_optional(db).await?.ok_or(RepositoryError::NotFound(Resource::Job))?)
}

/// What a statement reads of the iteration that is its variables: job, tenant and number.
pub async fn row<T>(
    db: &mut SqliteConnection,
    sql: &'static str,
    (tenant, job, number): (&Tenant, Uuid, u32),
) -> Outcome<T>
where
    T: for<'r> FromRow<'r, SqliteRow> + Send + Unpin,
{
    let row = sqlx::query_as(sql).bind(job).bind(tenant.as_str()).bind(number).fetch_optional(&mut *db).await?;
    match row {
        Some(row) => Ok(row),
        None => Err(which_is_missing(db, tenant, job).await),
    }
}

/// A transaction that sees one state, and the row of an iteration in it.
pub async fn within(
    from: &SqlitePool,
    Caller { tenant, .. }: &Caller,
    job: Uuid,
    number: u32,
) -> Outcome<(Transaction<'static, Sqlite>, i64)> {
    let mut db = from.begin().await?;
    let (seq,) = row(
        &mut db,
        "SELECT i.seq FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? AND i.number = ?",
        (tenant, job, number),
    )
    .await?;
    Ok((db, seq))
}

/// The last entries of a list of an iteration, as a statement reads them newest first whose
/// variables are row of the iteration and how many; and how many stand before them.
pub async fn last<T, U: From<T>>(db: &mut SqliteConnection, sql: &'static str, iteration: i64) -> Outcome<(Vec<U>, u64)>
where
    Counted<T>: for<'r> FromRow<'r, SqliteRow> + Send + Unpin,
{
    let rows: Vec<Counted<T>> = sqlx::query_as(sql).bind(iteration).bind(MAX_LISTED).fetch_all(db).await?;
    Ok(in_order(rows))
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

row! {
    struct IterationVersionRow {
        @purge: JobPurge,
        /// Of a job that has no iteration of this number there is none.
        seq: Option<i64>,
        /// Nor is there a version.
        version: Option<Integer<u64>>,
    }
}

/// An iteration that is to be written to.
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
                    + (SELECT count(*) FROM decisions WHERE iteration = i.seq)
                    + (SELECT count(*) FROM records
                       WHERE iteration = i.seq AND kind = 'measurand' AND method = 'changed') - 1
                END AS version,
                j.purged_at AS purged_at, (SELECT reason FROM purges WHERE job = j.seq) AS purge_reason
         FROM jobs j LEFT JOIN iterations i ON i.job = j.seq AND i.number = ? WHERE j.id = ? AND j.tenant = ?",
    )
    .bind(number)
    .bind(job)
    .bind(tenant.as_str())
    .fetch_optional(&mut *db)
    .await?
    .ok_or(RepositoryError::NotFound(Resource::Job))?;
    row.purge.refuse()?;
    let (seq, Integer(version)) = row.seq.zip(row.version).ok_or(RepositoryError::NotFound(Resource::Iteration))?;
    Ok(IterationVersion { seq, version })
}

/// SQLite's integers are signed; versions and counts are far below 2⁶³, and a cursor beyond is
/// behind every row.
pub fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
