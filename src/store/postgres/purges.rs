//! Jobs that are purged: what only takes space or tells of people is taken away; rows, numbers and
//! chains stay.

use std::time::Duration;

use sqlx::{Connection as _, PgConnection, PgPool};
use uuid::Uuid;

use super::{audit, gone, jobs, locate::signed, session::Session, settings::PostgresSettings, time::stamp};
use crate::{
    jobs::{
        Job, NewPurge, RepositoryError, Seen, Stored, Tenant, Turn,
        archive::Key,
        audit::{Action, Head, Nameless, Prepared, purged},
    },
    store::shared::{Asked, EntryRow, Integer, Outcome, PurgeJob, StoreError, Write, entry_columns, target},
};

impl Write<Session> for PurgeJob {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (PurgeJob { purge: new, receipt }, tenant) = (&asked.write, asked.tenant());
        let job = jobs::located(&mut session.db, tenant, new.job).await?;
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        gone::refuse(&mut session.db, tenant, new.job).await?;
        let open: Integer<u64> =
            sqlx::query_scalar("SELECT count(*) FROM operations WHERE job = $1 AND state IN ('queued', 'running')")
                .bind(new.job)
                .fetch_one(&mut session.db)
                .await?;
        if open.0 > 0 {
            return Err(RepositoryError::HasTasks(open.0).into());
        }
        if Some(seen(&mut session.db, new.job).await?) != new.seen {
            return Err(RepositoryError::ArchiveDiffers.into());
        }
        // jobs are locked before tenants, by whoever changes both
        session.lock_tenant(tenant).await?;
        let version = purge(asked, session, job).await.map_err(StoreError::too_late)?;
        let stored = Stored { number: 0, version };
        session.keys.keep(tenant, receipt.as_ref(), stored, new.purge.at, None);
        Ok(stored)
    }
}

/// How far a job has come.
async fn seen(db: &mut PgConnection, job: Uuid) -> Outcome<Seen> {
    let head = audit::heads(db, &[job]).await?.pop().map(|(_, row)| Head::from(row).sha256);
    let last: Integer<u64> = sqlx::query_scalar("SELECT coalesce(max(number), 0) FROM events WHERE job = $1")
        .bind(job)
        .fetch_one(db)
        .await?;
    Ok(Seen { head, last_event: last.0 })
}

/// Takes away what is to be taken away, and tells of it in the chain of the job and in that of the
/// tenant; the job's version afterwards.
async fn purge(asked: &Asked<PurgeJob>, session: &mut Session, job: Job) -> Outcome<u64> {
    let NewPurge { purge, .. } = &*asked.write.purge;
    let (tenant, after) = (asked.tenant(), job.purged(purge.at));
    session.chain(asked.by(), job.id).await?;
    session.tenant_chain(asked.by(), tenant, None).await?;
    let db = &mut session.db;
    sqlx::query("INSERT INTO purges (job, at, reason, archive_sha256) VALUES ($1, $2, $3, $4)")
        .bind(job.id)
        .bind(stamp(purge.at))
        .bind(purge.reason.as_str())
        .bind(purge.archive_sha256.as_slice())
        .execute(&mut *db)
        .await?;
    sqlx::query("UPDATE jobs SET version = $1, updated_at = $2 WHERE id = $3")
        .bind(signed(after.version))
        .bind(stamp(after.updated_at))
        .bind(job.id)
        .execute(&mut *db)
        .await?;
    forget_answers(db, tenant, job.id).await?;
    sqlx::query("SELECT take_away($1)").bind(job.id).execute(&mut *db).await?;
    for sql in [
        "DELETE FROM stream_states WHERE stream IN (SELECT id FROM streams WHERE job = $1)",
        "DELETE FROM stream_blocks WHERE stream IN (SELECT id FROM streams WHERE job = $1)",
        "UPDATE streams SET spec = '' WHERE job = $1",
    ] {
        sqlx::query(sql).bind(job.id).execute(&mut *db).await?;
    }
    let found = audit::found(db, tenant, job.id).await?;
    let contents = purged(&after, purge, &found, &mut nameless(db, job.id).await?);
    let prepared = Prepared { contents, ..asked.prepared() };
    let chain = session.chain(asked.by(), job.id).await?;
    chain.add(asked.by(), prepared, Action::PurgeJob, target::job(job.id));
    let tenants_own = session.tenant_chain(asked.by(), tenant, None).await?;
    asked.enter_second(tenants_own, Action::PurgeJob, target::job(job.id));
    Ok(after.version)
}

/// The entries of a job whose names were taken away.
async fn nameless(db: &mut PgConnection, job: Uuid) -> Outcome<Nameless> {
    let rows: Vec<EntryRow> =
        sqlx::query_as(concat!("SELECT ", entry_columns!(), " FROM audit WHERE chain = $1 ORDER BY number"))
            .bind(job)
            .fetch_all(db)
            .await?;
    let mut nameless = Nameless::default();
    rows.into_iter().filter_map(EntryRow::entry).for_each(|entry| nameless.entry(&entry));
    Ok(nameless)
}

/// Forgets answers and operations that tell of the job. (What has no answer yet is the purge's own
/// key.)
async fn forget_answers(db: &mut PgConnection, tenant: &Tenant, job: Uuid) -> Outcome<()> {
    sqlx::query("DELETE FROM operations WHERE job = $1").bind(job).execute(&mut *db).await?;
    sqlx::query(
        "DELETE FROM idempotency_keys k WHERE k.tenant = $1 AND k.body IS NOT NULL
         AND (k.job = $2 OR strpos(k.scope, $2::text) > 0
              OR EXISTS (SELECT FROM streams s WHERE s.job = $2 AND strpos(k.scope, s.id::text) > 0))",
    )
    .bind(tenant.as_str())
    .bind(job)
    .execute(db)
    .await?;
    Ok(())
}

/// Jobs without activity since a time and that are not purged, those that rest longest
/// first.
pub async fn untouched(from: &PgPool, since: jiff::Timestamp, most: u32) -> Result<Vec<Key>, sqlx::Error> {
    let rows: Vec<(Tenant, Uuid)> = sqlx::query_as(
        "SELECT j.tenant, j.id FROM jobs j
         WHERE j.purged_at IS NULL AND j.changed_at < $1
               AND NOT EXISTS (SELECT FROM streams s WHERE s.job = j.id AND s.updated_at >= $1)
               AND NOT EXISTS (SELECT FROM operations o WHERE o.job = j.id AND o.state IN ('queued', 'running'))
         ORDER BY j.changed_at, j.id LIMIT $2",
    )
    .bind(stamp(since))
    .bind(i64::from(most))
    .fetch_all(from)
    .await?;
    Ok(rows.into_iter().map(|(tenant, job)| Key { tenant, job }).collect())
}

/// A turn, of which there is one for all processes: it ends by [`Turn::end`], or with its
/// connection.
///
/// The lock is the session's, not a transaction's. A turn lasts for many transactions of other
/// connections, each of which purges a job for good, and a transaction that is idle meanwhile would
/// be ended by the server, and the lock with it. (Nothing depends on the turn but work that would
/// be done twice: a purge looks itself whether there was one.)
pub async fn turn(settings: &PostgresSettings) -> Result<Option<Turn>, sqlx::Error> {
    let mut db = PgConnection::connect_with(&settings.past_a_pooler()).await?;
    let own: bool =
        sqlx::query_scalar("SELECT pg_try_advisory_lock(hashtext('flankfit retention'))").fetch_one(&mut db).await?;
    if own {
        return Ok(Some(Turn(Some(Box::pin(end_turn(db))))));
    }
    // another process has it
    let _closed = db.close().await;
    Ok(None)
}

/// How long the end of a turn waits for the server.
const LONGEST_END: Duration = Duration::from_secs(5);

/// The server notices a moment later that a connection was closed, so it is told to unlock before.
async fn end_turn(mut db: PgConnection) {
    let ended = async {
        // where the connection was lost the turn has ended with it
        let unlock = "SELECT pg_advisory_unlock(hashtext('flankfit retention'))";
        let _unlocked = sqlx::query(unlock).execute(&mut db).await;
        let _closed = db.close().await;
    };
    // a connection that says nothing is dropped
    let _late = tokio::time::timeout(LONGEST_END, ended).await;
}
