//! Jobs that are purged: what only takes space or tells of people is taken away; rows, numbers and
//! chains stay.

use sqlx::{SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{answers, audit, audit_keys, gone, jobs, locate::signed, time};
use crate::{
    jobs::{
        Job, NewPurge, RepositoryError, Seen, Stored, Tenant,
        archive::Key,
        audit::{Action, Head, Nameless, Prepared, purged},
    },
    store::shared::{Asked, EntryRow, Integer, Outcome, PurgeJob, StoreError, Write, entry_columns, target},
};

/// What is taken away, of the job that is the variable by the row of which.
const TAKE_AWAY: [&str; 10] = [
    "UPDATE iterations SET operator = NULL, note = NULL WHERE job = ?1",
    "UPDATE nodes SET data = x'' WHERE iteration IN (SELECT seq FROM iterations WHERE job = ?1)",
    "UPDATE fits SET reason = NULL, actor = NULL, flank_figures = NULL, spec = '', result = '', frame = NULL,
                     coefficients = NULL, prior = NULL
     WHERE iteration IN (SELECT seq FROM iterations WHERE job = ?1)",
    "UPDATE fit_choices SET reason = NULL, actor = NULL WHERE iteration IN (SELECT seq FROM iterations WHERE job = ?1)",
    "UPDATE decisions SET reason = NULL, actor = NULL WHERE iteration IN (SELECT seq FROM iterations WHERE job = ?1)",
    "UPDATE records SET request = '', result = '', gear = NULL, actor = NULL
     WHERE iteration IN (SELECT seq FROM iterations WHERE job = ?1)",
    "DELETE FROM stream_states WHERE stream IN (SELECT seq FROM streams WHERE job = ?1)",
    "DELETE FROM stream_blocks WHERE stream IN (SELECT seq FROM streams WHERE job = ?1)",
    "UPDATE streams SET spec = '' WHERE job = ?1",
    // without the salt, which stands first
    "UPDATE audit SET actor = '',
            contents = CASE WHEN substr(contents, 1, 6) = x'055F73616C74' THEN substr(contents, 39) ELSE contents END
     WHERE chain = (SELECT id FROM jobs WHERE seq = ?1)",
];

impl Write<SqliteConnection> for PurgeJob {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (PurgeJob { purge: new, receipt }, tenant) = (&asked.write, asked.tenant());
        let (seq, job) = jobs::located(db, tenant, new.job).await?;
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        gone::refuse(db, tenant, new.job).await?;
        let open: Integer<u64> =
            sqlx::query_scalar("SELECT count(*) FROM operations WHERE job = ? AND state IN ('queued', 'running')")
                .bind(new.job)
                .fetch_one(&mut *db)
                .await?;
        if open.0 > 0 {
            return Err(RepositoryError::HasTasks(open.0).into());
        }
        if Some(seen(db, seq, new.job).await?) != new.seen {
            return Err(RepositoryError::ArchiveDiffers.into());
        }
        let version = purge(asked, db, (seq, job)).await.map_err(StoreError::too_late)?;
        let stored = Stored { number: 0, version };
        answers::keep(db, tenant, receipt.as_ref(), stored, new.purge.at, None).await?;
        Ok(stored)
    }
}

/// How far a job has come.
async fn seen(db: &mut SqliteConnection, seq: i64, job: Uuid) -> Outcome<Seen> {
    let head = audit::head(db, job).await?.map(|row| Head::from(row).sha256);
    let last: Integer<u64> =
        sqlx::query_scalar("SELECT coalesce(max(number), 0) FROM events WHERE job = ?").bind(seq).fetch_one(db).await?;
    Ok(Seen { head, last_event: last.0 })
}

/// Takes away what is to be taken away, and tells of it in the chain of the job and in that of the
/// tenant; the job's version afterwards.
async fn purge(asked: &Asked<PurgeJob>, db: &mut SqliteConnection, (seq, job): (i64, Job)) -> Outcome<u64> {
    let NewPurge { purge, .. } = &*asked.write.purge;
    let (tenant, after) = (asked.tenant(), job.purged(purge.at));
    let mut chain = audit::of_job(db, asked.by(), job.id).await?;
    let mut tenants_own = audit_keys::of_tenant(db, asked.by(), tenant).await?;
    sqlx::query("INSERT INTO purges (job, at, reason, archive_sha256) VALUES (?, ?, ?, ?)")
        .bind(seq)
        .bind(time::to_text(purge.at))
        .bind(purge.reason.as_str())
        .bind(purge.archive_sha256.as_slice())
        .execute(&mut *db)
        .await?;
    sqlx::query("UPDATE jobs SET version = ?, updated_at = ? WHERE seq = ?")
        .bind(signed(after.version))
        .bind(time::to_text(after.updated_at))
        .bind(seq)
        .execute(&mut *db)
        .await?;
    forget_answers(db, tenant, seq, job.id).await?;
    for sql in TAKE_AWAY {
        sqlx::query(sql).bind(seq).execute(&mut *db).await?;
    }
    let found = audit::found(db, tenant, job.id).await?;
    let contents = purged(&after, purge, &found, &mut nameless(db, job.id).await?);
    let prepared = Prepared { contents, ..asked.prepared() };
    chain.add(asked.by(), prepared, Action::PurgeJob, target::job(job.id));
    asked.enter_second(&mut tenants_own, Action::PurgeJob, target::job(job.id));
    audit::store(db, chain).await?;
    audit::store(db, tenants_own).await?;
    Ok(after.version)
}

/// The entries of a job whose names were taken away.
async fn nameless(db: &mut SqliteConnection, job: Uuid) -> Outcome<Nameless> {
    let rows: Vec<EntryRow> =
        sqlx::query_as(concat!("SELECT ", entry_columns!(), " FROM audit WHERE chain = ? ORDER BY number"))
            .bind(job)
            .fetch_all(db)
            .await?;
    let mut nameless = Nameless::default();
    rows.into_iter().filter_map(EntryRow::entry).for_each(|entry| nameless.entry(&entry));
    Ok(nameless)
}

/// Forgets answers and operations that tell of the job.
async fn forget_answers(db: &mut SqliteConnection, tenant: &Tenant, seq: i64, job: Uuid) -> Outcome<()> {
    let streams: Vec<Uuid> =
        sqlx::query_scalar("SELECT id FROM streams WHERE job = ?").bind(seq).fetch_all(&mut *db).await?;
    sqlx::query("DELETE FROM operations WHERE job = ?").bind(job).execute(&mut *db).await?;
    sqlx::query(
        "DELETE FROM idempotency_keys WHERE fit IN
             (SELECT f.seq FROM iterations i JOIN fits f ON f.iteration = i.seq WHERE i.job = ?)",
    )
    .bind(seq)
    .execute(&mut *db)
    .await?;
    // a scope is method and path; the index has it, so no answer is read
    for id in streams.into_iter().chain([job]) {
        sqlx::query(
            "DELETE FROM idempotency_keys
             WHERE seq IN (SELECT seq FROM idempotency_keys WHERE tenant = ? AND instr(scope, ?) > 0)",
        )
        .bind(tenant.as_str())
        .bind(id.to_string())
        .execute(&mut *db)
        .await?;
    }
    Ok(())
}

/// Jobs without activity since a time and that are not purged, those that rest longest
/// first.
pub async fn untouched(from: &SqlitePool, since: &str, most: u32) -> Outcome<Vec<Key>> {
    let rows: Vec<(Tenant, Uuid)> = sqlx::query_as(
        "SELECT j.tenant, j.id FROM jobs j
         WHERE j.purged_at IS NULL AND j.changed_at < ?1
               AND NOT EXISTS (SELECT 1 FROM streams s WHERE s.job = j.seq AND s.updated_at >= ?1)
               AND NOT EXISTS (SELECT 1 FROM operations o WHERE o.job = j.id AND o.state IN ('queued', 'running'))
         ORDER BY j.changed_at, j.id LIMIT ?2",
    )
    .bind(since)
    .bind(i64::from(most))
    .fetch_all(from)
    .await?;
    Ok(rows.into_iter().map(|(tenant, job)| Key { tenant, job }).collect())
}
