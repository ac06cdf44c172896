//! Events of a job and of all jobs, which triggers write.

use sqlx::{PgConnection, PgPool};

use super::{locate::signed, session::Session, time::stamp, upkeep};
use crate::{
    jobs::{Caller, EventPlace, JobEvent, RepositoryError, Resource, ToldEvent},
    store::shared::{
        EventRow, ForgetTold, GetAllEvents, GetEvents, GetLastEvent, GetLastPlace, Integer, NOTED_EVERY, Outcome, Read,
        Run, TellsAllAfter, ToldEventRow,
    },
};

/// What an event names, of a row `e`. (The fit of an iteration's event is its first.)
macro_rules! named {
    () => {
        "e.iteration, i.id AS iteration_id, f.id AS fit_id, c.position AS choice, c.reason AS choice_reason, d.decision,
         d.reason AS decision_reason, e.stream AS stream_id, e.state, e.sequence, e.node_count, e.operation,
         e.operation_state, p.reason AS purge_reason, e.record AS record_id, r.kind AS record_kind"
    };
}

/// Where that stands.
macro_rules! joined {
    () => {
        " LEFT JOIN iterations i ON i.job = e.job AND i.number = e.iteration
          LEFT JOIN fits f ON f.job = e.job AND f.number = e.iteration AND f.position = coalesce(e.fit, 1)
          LEFT JOIN fit_choices c
               ON e.kind = 'fit' AND c.job = e.job AND c.number = e.iteration AND c.position = e.position
          LEFT JOIN decisions d
               ON e.kind = 'decision' AND d.job = e.job AND d.number = e.iteration AND d.position = e.position
          LEFT JOIN records r ON e.kind = 'record' AND r.id = e.record
          LEFT JOIN purges p ON e.kind = 'purged' AND p.job = e.job "
    };
}

impl Read<PgPool> for GetEvents {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Vec<JobEvent>> {
        let rows: Vec<EventRow> = sqlx::query_as(concat!(
            "SELECT e.number, e.created_at, e.kind, CASE WHEN e.kind = 'job' THEN 'changed' END AS job_state, ",
            named!(),
            " FROM jobs j JOIN events e ON e.job = j.id ",
            joined!(),
            "WHERE j.id = $1 AND j.tenant = $2 AND e.number > $3 ORDER BY e.number LIMIT $4",
        ))
        .bind(self.job)
        .bind(caller.tenant.as_str())
        .bind(signed(self.after))
        .bind(i64::from(self.limit))
        .fetch_all(from)
        .await?;
        rows.into_iter().map(JobEvent::try_from).collect()
    }
}

impl Read<PgPool> for GetLastEvent {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<u64> {
        let last: Option<Integer<u64>> = sqlx::query_scalar(
            "SELECT coalesce((SELECT max(number) FROM events WHERE job = j.id), 0)
             FROM jobs j WHERE j.id = $1 AND j.tenant = $2",
        )
        .bind(self.job)
        .bind(caller.tenant.as_str())
        .fetch_optional(from)
        .await?;
        Ok(last.ok_or(RepositoryError::NotFound(Resource::Job))?.0)
    }
}

impl Read<PgPool> for GetAllEvents {
    /// No further than to the first transaction that has not ended. A job that was deleted has
    /// taken its events along.
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Vec<ToldEvent>> {
        let rows: Vec<ToldEventRow> = sqlx::query_as(concat!(
            "SELECT t.changed_by, t.place, t.job AS job_id, coalesce(e.number, 0) AS number,
                    coalesce(e.created_at, t.created_at) AS created_at, coalesce(e.kind, 'job') AS kind,
                    coalesce(t.state, 'changed') AS job_state, ",
            named!(),
            " FROM told t LEFT JOIN events e ON e.job = t.job AND e.number = t.number ",
            joined!(),
            "WHERE t.tenant = $1 AND (t.changed_by, t.place) > ($2, $3)
                   AND t.changed_by < pg_snapshot_xmin(pg_current_snapshot())::text::bigint
                   AND (t.number IS NULL OR e.number IS NOT NULL)
             ORDER BY t.changed_by, t.place LIMIT $4",
        ))
        .bind(caller.tenant.as_str())
        .bind(signed(self.after.change))
        .bind(signed(self.after.number))
        .bind(i64::from(self.limit))
        .fetch_all(from)
        .await?;
        rows.into_iter().map(ToldEvent::try_from).collect()
    }
}

impl Read<PgPool> for GetLastPlace {
    async fn read(&self, _: &Caller, from: &PgPool) -> Outcome<EventPlace> {
        let next: Integer<u64> =
            sqlx::query_scalar("SELECT pg_snapshot_xmin(pg_current_snapshot())::text::bigint").fetch_one(from).await?;
        Ok(EventPlace { change: next.0.saturating_sub(1), number: i64::MAX.unsigned_abs() })
    }
}

impl Read<PgPool> for TellsAllAfter {
    async fn read(&self, _: &Caller, from: &PgPool) -> Outcome<bool> {
        // of a transaction that is gone the place may be the last one, and need not be
        let told = sqlx::query_scalar(
            "SELECT NOT EXISTS
                 (SELECT FROM told_until WHERE gone AND (changed_by, 9223372036854775807::bigint) > ($1, $2)
                  AND changed_by < pg_snapshot_xmin(pg_current_snapshot())::text::bigint)",
        );
        Ok(told.bind(signed(self.place.change)).bind(signed(self.place.number)).fetch_one(from).await?)
    }
}

impl Run<Session> for ForgetTold {
    /// One process at a time does so. Each tenant's part is looked up by the primary key.
    async fn run(&self, session: &mut Session) -> Outcome<u64> {
        let db = &mut session.db;
        if !upkeep::alone(db).await? {
            return Ok(0);
        }
        forget_what_another_server_told(db).await?;
        sqlx::query(
            "INSERT INTO told_until (at, changed_by)
             SELECT $1, pg_snapshot_xmin(pg_current_snapshot())::text::bigint - 1
             WHERE NOT EXISTS (SELECT FROM told_until WHERE at > $2 AND at <= $1)",
        )
        .bind(stamp(self.now))
        .bind(stamp(self.now - NOTED_EVERY))
        .execute(&mut *db)
        .await?;
        sqlx::query("UPDATE told_until SET gone = true WHERE NOT gone AND at < $1")
            .bind(stamp(self.before))
            .execute(&mut *db)
            .await?;
        let forgotten = sqlx::query(
            "WITH RECURSIVE whose AS (
                 (SELECT tenant FROM told ORDER BY tenant LIMIT 1)
                 UNION ALL
                 SELECT (SELECT t.tenant FROM told t WHERE t.tenant > w.tenant ORDER BY t.tenant LIMIT 1)
                 FROM whose w WHERE w.tenant IS NOT NULL
             ), old AS (
                 SELECT o.tenant, o.changed_by, o.place FROM whose w CROSS JOIN LATERAL
                     (SELECT t.tenant, t.changed_by, t.place FROM told t
                      WHERE t.tenant = w.tenant AND t.changed_by <= (SELECT max(changed_by) FROM told_until WHERE gone)
                      ORDER BY t.changed_by, t.place LIMIT $1) AS o
                 LIMIT $1
             )
             DELETE FROM told t USING old
             WHERE t.tenant = old.tenant AND t.changed_by = old.changed_by AND t.place = old.place",
        )
        .bind(i64::from(self.most))
        .execute(&mut *db)
        .await?;
        // the farthest of them says what is gone; those before it may be of a clock that was wrong
        sqlx::query(
            "DELETE FROM told_until WHERE (changed_by, at) <
             (SELECT changed_by, at FROM told_until WHERE gone ORDER BY changed_by DESC, at DESC LIMIT 1)",
        )
        .execute(db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}

/// A dump brings places among the transactions of the server that it is of, to which this one has
/// yet to come: by these everything that happens here would count as told long ago.
async fn forget_what_another_server_told(db: &mut PgConnection) -> Outcome<()> {
    let brought: bool = sqlx::query_scalar(
        "WITH notes AS (DELETE FROM told_until
                        WHERE changed_by >= pg_snapshot_xmin(pg_current_snapshot())::text::bigint RETURNING 1)
         SELECT EXISTS (SELECT FROM notes) OR NOT EXISTS (SELECT FROM told_until)",
    )
    .fetch_one(&mut *db)
    .await?;
    if brought {
        sqlx::query(
            "DELETE FROM told WHERE changed_by >=
             greatest(pg_snapshot_xmax(pg_current_snapshot())::text::bigint, pg_current_xact_id()::text::bigint + 1)",
        )
        .execute(db)
        .await?;
    }
    Ok(())
}
