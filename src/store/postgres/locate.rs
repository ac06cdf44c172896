//! Row keys of jobs and iterations.

use sqlx::{FromRow, PgConnection, PgPool, Postgres, Transaction, postgres::PgRow};
use uuid::Uuid;

use super::open::snapshot;
use crate::{
    jobs::{Caller, MAX_LISTED, RepositoryError, Resource, Tenant},
    store::shared::{Counted, Integer, JobPurge, Outcome, StoreError, in_order},
};

/// The version of the iteration that is the row `i`.
macro_rules! version {
    () => {
        "(SELECT coalesce(max(position), 0) FROM fits WHERE job = i.job AND number = i.number)
         + (SELECT coalesce(max(position), 0) FROM fit_choices WHERE job = i.job AND number = i.number)
         + (SELECT coalesce(max(position), 0) FROM decisions WHERE job = i.job AND number = i.number)
         + (SELECT count(*) FROM records
            WHERE job = i.job AND number = i.number AND kind = 'measurand' AND method = 'changed') - 1"
    };
}
pub(super) use version;

/// Refuses a job that is not there.
pub async fn job(db: &mut PgConnection, tenant: &Tenant, id: Uuid) -> Outcome<()> {
    let found = sqlx::query("SELECT FROM jobs WHERE id = $1 AND tenant = $2").bind(id).bind(tenant.as_str());
    found.fetch_optional(db).await?.ok_or(RepositoryError::NotFound(Resource::Job))?;
    Ok(())
}

/// What a statement reads of the iteration that is its parameters: job, tenant and number.
pub async fn row<T>(db: &mut PgConnection, sql: &'static str, (tenant, job, number): (&Tenant, Uuid, u32)) -> Outcome<T>
where
    T: for<'r> FromRow<'r, PgRow> + Send + Unpin,
{
    let of = sqlx::query_as(sql).bind(job).bind(tenant.as_str()).bind(i64::from(number));
    match of.fetch_optional(&mut *db).await? {
        Some(row) => Ok(row),
        None => Err(which_is_missing(db, tenant, job).await),
    }
}

/// A transaction that sees one state, in which there is the iteration.
pub async fn within(
    from: &PgPool,
    Caller { tenant, .. }: &Caller,
    job: Uuid,
    number: u32,
) -> Outcome<Transaction<'static, Postgres>> {
    let mut db = snapshot(from).await?;
    let () = row(
        &mut db,
        "SELECT FROM jobs j JOIN iterations i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3",
        (tenant, job, number),
    )
    .await?;
    Ok(db)
}

/// The last entries of a list of an iteration, as a statement reads them newest first whose
/// parameters are job, number and how many; and how many stand before them.
pub async fn last<T, U: From<T>>(
    db: &mut PgConnection,
    sql: &'static str,
    (job, number): (Uuid, i64),
) -> Outcome<(Vec<U>, u64)>
where
    Counted<T>: for<'r> FromRow<'r, PgRow> + Send + Unpin,
{
    let rows: Vec<Counted<T>> =
        sqlx::query_as(sql).bind(job).bind(number).bind(i64::from(MAX_LISTED)).fetch_all(db).await?;
    Ok(in_order(rows))
}

/// Whether the job or only its iteration does not exist.
pub async fn which_is_missing(db: &mut PgConnection, tenant: &Tenant, job: Uuid) -> StoreError {
    let job = sqlx::query("SELECT FROM jobs WHERE id = $1 AND tenant = $2").bind(job).bind(tenant.as_str());
    match job.fetch_optional(db).await {
        Ok(Some(_)) => RepositoryError::NotFound(Resource::Iteration).into(),
        Ok(None) => RepositoryError::NotFound(Resource::Job).into(),
        Err(error) => error.into(),
    }
}

row! {
    struct VersionRow {
        @purge: JobPurge,
        /// Of a job that has no iteration of this number there is none.
        version: Option<Integer<u64>>,
    }
}

/// The version of an iteration that is to be written to.
pub async fn iteration(db: &mut PgConnection, tenant: &Tenant, job: Uuid, number: u32) -> Outcome<u64> {
    let row: VersionRow = sqlx::query_as(concat!(
        "SELECT CASE WHEN i.number IS NOT NULL THEN ",
        version!(),
        " END AS version, j.purged_at, (SELECT reason FROM purges WHERE job = j.id) AS purge_reason
         FROM jobs j LEFT JOIN iterations i ON i.job = j.id AND i.number = $3 WHERE j.id = $1 AND j.tenant = $2"
    ))
    .bind(job)
    .bind(tenant.as_str())
    .bind(i64::from(number))
    .fetch_optional(db)
    .await?
    .ok_or(RepositoryError::NotFound(Resource::Job))?;
    row.purge.refuse()?;
    Ok(row.version.ok_or(RepositoryError::NotFound(Resource::Iteration))?.0)
}

/// PostgreSQL's integers are signed; versions and counts are far below 2⁶³, and a cursor beyond is
/// behind every row.
pub fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
