//! Purges of jobs.

use sqlx::SqliteConnection;
use uuid::Uuid;

use crate::{
    jobs::Tenant,
    store::shared::{JobPurge, Outcome, PurgeRow, StoreError},
};

/// What is told of something of a job that is no longer there.
pub async fn told(db: &mut SqliteConnection, job: Uuid) -> StoreError {
    let row = sqlx::query_as::<_, PurgeRow>(
        "SELECT at, reason, archive_sha256 FROM purges WHERE job = (SELECT seq FROM jobs WHERE id = ?)",
    );
    match row.bind(job).fetch_optional(db).await {
        Ok(row) => PurgeRow::refusal(row).into(),
        Err(error) => error.into(),
    }
}

/// Refuses what is asked of a purged job; of one that there is not, nothing is said.
pub async fn refuse(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid) -> Outcome<()> {
    let purge: Option<JobPurge> = sqlx::query_as(
        "SELECT p.at AS purged_at, p.reason AS purge_reason FROM jobs j JOIN purges p ON p.job = j.seq
         WHERE j.id = ? AND j.tenant = ?",
    )
    .bind(job)
    .bind(tenant.as_str())
    .fetch_optional(db)
    .await?;
    Ok(purge.map_or(Ok(()), |purge| purge.refuse())?)
}
