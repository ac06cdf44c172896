//! Jobs that are purged: with a row in `purges` the database removes nodes, results, texts and
//! names; rows and numbers stay.

use futures_util::TryStreamExt as _;

use super::{db::Pool, gone, jobs, prelude::*, subject};
use crate::jobs::{archive::Key, audit::left, rows::OF_JOBS};

pub async fn purge_job(tx: &mut Tx<'_>, write: &PurgeJob) -> Outcome<Stored> {
    let (new, tenant) = (&write.purge, tx.tenant());
    let job = jobs::located(tx.db(), tenant, new.job).await?;
    tx.refuse_taken()?;
    gone::refuse(tx.db(), tenant, new.job).await?;
    let version = purge(tx, new, job).await.map_err(StoreError::too_late)?;
    Ok(tx.keep(&write.receipt, Stored { number: 0, version }, None, new.at))
}

/// Purges a job, and enters that with digests of all that is left; returns the version of the job
/// afterwards.
async fn purge(tx: &mut Tx<'_>, purge: &Purge, job: Job) -> Outcome<u64> {
    let (tenant, after) = (tx.tenant(), job.purged(purge.at));
    let mut entry = tx.draft(job.id, Action::PurgeJob, subject::job(job.id))?;
    let db = tx.db();
    // also that to the request by which it was stored, perhaps with other jobs
    db.run(
        "DELETE FROM idempotency_keys WHERE tenant = $1 AND status IS NOT NULL
         AND (about = $2 OR about IN (SELECT id FROM streams WHERE job = $2) OR created_at = $3)",
        args![tenant, job.id, job.created_at],
    )
    .await?;
    let streams: Vec<(Uuid,)> = db.all("SELECT id FROM streams WHERE job = $1", args![job.id]).await?;
    db.run("INSERT INTO purges (job, at, reason) VALUES ($1, $2, $3)", args![job.id, purge.at, &purge.reason]).await?;
    db.run(
        "UPDATE jobs SET version = $1, updated_at = $2 WHERE id = $3",
        args![after.version, after.updated_at, job.id],
    )
    .await?;
    entry.note_stored(db, "jobs", "id = $1", args![job.id]).await?;
    entry.note_stored(db, "purges", "job = $1", args![job.id]).await?;
    let mut fields = left(entry.salt());
    for table in OF_JOBS.iter().filter(|table| !["jobs", "purges"].contains(&table.name)) {
        let condition = format!("{} ORDER BY {}", table.of, table.order());
        let mut rows = db.rows(table, &condition, args![job.id, tenant])?;
        while let Some(row) = rows.try_next().await? {
            fields = fields.bytes(&table.digest(entry.salt(), &row.values));
        }
    }
    entry.note_digest("left".to_owned(), fields.digest());
    tx.enter(entry);
    // those of the same transaction are not in the table yet
    tx.session.keys.forget(tenant, |about, at| {
        about == Some(job.id) || streams.iter().any(|(stream,)| about == Some(*stream)) || at == job.created_at
    });
    Ok(after.version)
}

/// Returns jobs without activity since a time that are not purged, after one, in the order of
/// tenants and ids.
pub async fn untouched(from: &Pool, since: Timestamp, after: Option<Key>, most: u32) -> Outcome<Vec<Key>> {
    let sql = "SELECT j.tenant, j.id FROM jobs j
               WHERE j.purged_at IS NULL AND j.changed_at < $1
                     AND NOT EXISTS (SELECT 1 FROM streams s WHERE s.job = j.id AND s.updated_at >= $1)
                     AND (j.tenant, j.id) > ($2, $3)
               ORDER BY j.tenant, j.id LIMIT $4";
    let (tenant, job) = after.map_or((String::new(), Uuid::nil()), |key| (key.tenant.as_str().to_owned(), key.job));
    let rows: Vec<(Cell<Tenant>, Uuid)> = from.connection().await?.all(sql, args![since, tenant, job, most]).await?;
    Ok(rows.into_iter().map(|(Cell(tenant), job)| Key { tenant, job }).collect())
}
