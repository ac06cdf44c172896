//! Purges of jobs.

use uuid::Uuid;

use super::{
    db::Db,
    error::{Outcome, StoreError},
    row::JobPurge,
};
use crate::jobs::Tenant;

/// Returns the refusal of something of a job that was taken away.
pub async fn refusal(db: &mut Db, job: Uuid) -> StoreError {
    let sql = "SELECT at AS purged_at, reason AS purge_reason FROM purges WHERE job = $1";
    match db.maybe(sql, args![job]).await {
        Ok(purge) => JobPurge::refusal(purge).into(),
        Err(error) => error.into(),
    }
}

/// Refuses a purged job. A job that does not exist is not refused.
pub async fn refuse(db: &mut Db, tenant: &Tenant, job: Uuid) -> Outcome<()> {
    let sql = "SELECT p.at AS purged_at, p.reason AS purge_reason FROM jobs j JOIN purges p ON p.job = j.id
               WHERE j.id = $1 AND j.tenant = $2";
    let purge: Option<JobPurge> = db.maybe(sql, args![job, tenant]).await?;
    Ok(purge.map_or(Ok(()), |purge| purge.refuse())?)
}
