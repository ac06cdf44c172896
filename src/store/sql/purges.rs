//! Jobs that are purged: with a row in `purges` the database takes away nodes, results, texts and
//! names; rows, numbers and chains stay.

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    audit::{self, Readable},
    columns::Cell,
    db::{Db, Pool},
    error::{Outcome, StoreError},
    gone,
    growing::target,
    jobs,
    row::{entry_columns, purge_name},
    write::{Intent, Tx, Write},
    writes::PurgeJob,
};
use crate::jobs::{
    Job, NewPurge, RepositoryError, Seen, Stored, Tenant,
    archive::Key,
    audit::{Action, Contents, Entry, Nameless, purge_digest, purged},
};

impl Write for PurgeJob {
    type Reply = Stored;

    /// One entry of the job, and one of the tenant.
    fn intent(&self) -> Intent<'_> {
        let NewPurge { job, purge, .. } = &*self.purge;
        let of_tenant = Contents::one(&purge_name(*job), purge_digest(*job, purge));
        let entries = vec![Contents::default(), of_tenant];
        Intent { entries, erases: true, ..Intent::job(*job, Contents::default()) }.receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let (new, tenant) = (&self.purge, tx.tenant());
        let job = jobs::located(tx.db(), tenant, new.job).await?;
        tx.refuse_taken()?;
        gone::refuse(tx.db(), tenant, new.job).await?;
        let sql = "SELECT count(*) FROM operations WHERE job = $1 AND state IN ('queued', 'running')";
        let open: u64 = tx.db().one(sql, args![new.job]).await?;
        if open > 0 {
            return Err(RepositoryError::HasTasks(open).into());
        }
        if Some(seen(tx.db(), new.job).await?) != new.seen {
            return Err(RepositoryError::ArchiveDiffers.into());
        }
        // a job is locked before its tenant
        tx.session.lock_tenant(tenant).await?;
        let version = purge(tx, new, job).await.map_err(StoreError::too_late)?;
        let stored = Stored { number: 0, version };
        tx.keep(&self.receipt, stored, None, new.purge.at);
        Ok(stored)
    }
}

/// Returns how far a job has come.
async fn seen(db: &mut Db, job: Uuid) -> Outcome<Seen> {
    let head = audit::head(db, job).await?.map(|head| head.sha256);
    let sql = "SELECT coalesce(max(number), 0) FROM events WHERE job = $1";
    let last_event: u64 = db.one(sql, args![job]).await?;
    Ok(Seen { head, last_event })
}

/// Purges a job, and enters that in the chain of the job and in that of the tenant; returns the
/// version of the job afterwards.
async fn purge(tx: &mut Tx<'_>, NewPurge { purge, .. }: &NewPurge, job: Job) -> Outcome<u64> {
    let (tenant, by, after) = (tx.tenant(), tx.by(), job.purged(purge.at));
    // before anything is changed
    tx.session.chain(by, job.id).await?;
    tx.tenant_chain(tenant, None).await?;
    let db = tx.db();
    forget_answers(db, tenant, job.id).await?;
    db.run(
        "INSERT INTO purges (job, at, reason, archive_sha256) VALUES ($1, $2, $3, $4)",
        args![job.id, purge.at, &purge.reason, &purge.archive_sha256],
    )
    .await?;
    db.run(
        "UPDATE jobs SET version = $1, updated_at = $2 WHERE id = $3",
        args![after.version, after.updated_at, job.id],
    )
    .await?;
    let found = audit::found(db, tenant, job.id).await?;
    let contents = purged(&after, purge, &found, &mut nameless(db, job.id).await?);
    tx.enter_found(job.id, contents, Action::PurgeJob, target::job(job.id)).await?;
    let of_tenant = tx.asked.prepared[1].clone();
    tx.tenant_chain(tenant, None).await?.add(by, of_tenant, Action::PurgeJob, target::job(job.id));
    Ok(after.version)
}

/// Returns the entries of a job whose names were taken away.
async fn nameless(db: &mut Db, job: Uuid) -> Outcome<Nameless> {
    let sql = concat!("SELECT ", entry_columns!(), " FROM audit WHERE chain = $1 ORDER BY number");
    let rows: Vec<Readable<Entry>> = db.all(sql, args![job]).await?;
    let mut nameless = Nameless::default();
    rows.iter().filter_map(|row| row.0.as_ref()).for_each(|entry| nameless.entry(entry));
    Ok(nameless)
}

/// Forgets answers and operations about the job. (The key without an answer is the purge's own.)
async fn forget_answers(db: &mut Db, tenant: &Tenant, job: Uuid) -> Outcome<()> {
    let streams: Vec<Uuid> = db.values("SELECT id FROM streams WHERE job = $1", args![job]).await?;
    db.run("DELETE FROM operations WHERE job = $1", args![job]).await?;
    db.run("DELETE FROM idempotency_keys WHERE tenant = $1 AND job = $2", args![tenant, job]).await?;
    // a scope is method and path
    for id in streams.into_iter().chain([job]) {
        let sql = "DELETE FROM idempotency_keys WHERE tenant = $1 AND scope LIKE $2 AND status IS NOT NULL";
        db.run(sql, args![tenant, format!("%{id}%")]).await?;
    }
    Ok(())
}

/// Returns jobs without activity since a time that are not purged, the oldest first.
pub async fn untouched(from: &Pool, since: Timestamp, most: u32) -> Outcome<Vec<Key>> {
    let sql = "SELECT j.tenant, j.id FROM jobs j
               WHERE j.purged_at IS NULL AND j.changed_at < $1
                     AND NOT EXISTS (SELECT 1 FROM streams s WHERE s.job = j.id AND s.updated_at >= $1)
                     AND NOT EXISTS (SELECT 1 FROM operations o WHERE o.job = j.id AND o.state IN ('queued', 'running'))
               ORDER BY j.changed_at, j.id LIMIT $2";
    let rows: Vec<(Cell<Tenant>, Uuid)> = from.connection().await?.all(sql, args![since, most]).await?;
    Ok(rows.into_iter().map(|(Cell(tenant), job)| Key { tenant, job }).collect())
}
