//! Jobs and iterations that other statements are about.

use super::{
    db::Record,
    lists::{Counted, in_order},
    prelude::*,
};

/// The version of the iteration in the row `i`.
macro_rules! iteration_version {
    () => {
        "(SELECT coalesce(max(position), 0) FROM fits WHERE job = i.job AND number = i.number)
         + (SELECT coalesce(max(position), 0) FROM fit_choices WHERE job = i.job AND number = i.number)
         + (SELECT coalesce(max(position), 0) FROM decisions WHERE job = i.job AND number = i.number)
         + (SELECT count(*) FROM records
            WHERE job = i.job AND number = i.number AND kind = 'measurand' AND method = 'changed') - 1"
    };
}
pub(super) use iteration_version;

/// Refuses a job that does not exist.
pub async fn job(db: &mut Db, tenant: &Tenant, id: Uuid) -> Outcome<()> {
    match db.is_there("SELECT 1 FROM jobs WHERE id = $1 AND tenant = $2", args![id, tenant]).await? {
        true => Ok(()),
        false => Err(RepositoryError::NotFound(Resource::Job).into()),
    }
}

/// Returns the row that a statement reads of an iteration. Its values are job, tenant and number.
pub async fn row<T: Record>(db: &mut Db, sql: &'static str, (tenant, job, number): (&Tenant, Uuid, u32)) -> Outcome<T> {
    match db.maybe(sql, args![job, tenant, number]).await? {
        Some(row) => Ok(row),
        None => Err(which_is_missing(db, tenant, job).await),
    }
}

/// Refuses an iteration that does not exist.
pub async fn iteration(db: &mut Db, tenant: &Tenant, job: Uuid, number: u32) -> Outcome<()> {
    let sql = "SELECT i.number FROM jobs j JOIN iterations i ON i.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3";
    let _found: (i64,) = row(db, sql, (tenant, job, number)).await?;
    Ok(())
}

/// Returns the last entries of a list of an iteration, and how many come before them. The statement
/// reads them newest first; its values are job, number and how many.
pub async fn last<T>(db: &mut Db, sql: &'static str, job: Uuid, number: u32) -> Outcome<(Vec<T>, u64)>
where
    Counted<T>: Record,
{
    Ok(in_order(db.all::<Counted<T>>(sql, args![job, number, MAX_LISTED]).await?))
}

/// Says whether the job or only its iteration does not exist.
pub async fn which_is_missing(db: &mut Db, tenant: &Tenant, id: Uuid) -> StoreError {
    match job(db, tenant, id).await {
        Ok(()) => RepositoryError::NotFound(Resource::Iteration).into(),
        Err(error) => error,
    }
}

row! {
    struct VersionRow {
        @purge: JobPurge,
        /// None where the job has no iteration of this number.
        version: Option<u64>,
    }
}

/// Returns the version of an iteration that is to be written to.
pub async fn version(db: &mut Db, tenant: &Tenant, job: Uuid, number: u32) -> Outcome<u64> {
    let sql = concat!(
        "SELECT CASE WHEN i.number IS NOT NULL THEN ",
        iteration_version!(),
        " END AS version, j.purged_at, (SELECT reason FROM purges WHERE job = j.id) AS purge_reason
         FROM jobs j LEFT JOIN iterations i ON i.job = j.id AND i.number = $3 WHERE j.id = $1 AND j.tenant = $2"
    );
    let row: Option<VersionRow> = db.maybe(sql, args![job, tenant, number]).await?;
    let row = row.ok_or(RepositoryError::NotFound(Resource::Job))?;
    row.purge.refuse()?;
    Ok(row.version.ok_or(RepositoryError::NotFound(Resource::Iteration))?)
}
