//! Events of a job and of all jobs, which triggers write.

use sqlx::{SqliteConnection, SqlitePool};

use super::{locate::signed, time};
use crate::{
    jobs::{Caller, EventPlace, JobEvent, RepositoryError, Resource, ToldEvent},
    store::shared::{
        EventRow, ForgetTold, GetAllEvents, GetEvents, GetLastEvent, GetLastPlace, Integer, NOTED_EVERY, Outcome, Read,
        Run, TellsAllAfter, ToldEventRow,
    },
};

/// What an event names, of a row `e`.
macro_rules! named {
    () => {
        "i.number AS iteration, i.id AS iteration_id,
         coalesce(f.id, (SELECT id FROM fits WHERE iteration = e.iteration ORDER BY seq LIMIT 1)) AS fit_id,
         c.position AS choice, c.reason AS choice_reason, d.decision AS decision, d.reason AS decision_reason,
         e.stream AS stream_id, e.state AS state, e.sequence AS sequence, e.node_count AS node_count,
         e.operation AS operation, e.operation_state AS operation_state, p.reason AS purge_reason,
         e.record AS record_id, r.kind AS record_kind"
    };
}

/// Where that stands.
macro_rules! joined {
    () => {
        " LEFT JOIN iterations i ON i.seq = e.iteration
          LEFT JOIN fits f ON f.seq = e.fit
          LEFT JOIN fit_choices c ON e.kind = 'fit' AND c.iteration = e.iteration AND c.position = e.position
          LEFT JOIN decisions d ON e.kind = 'decision' AND d.iteration = e.iteration AND d.position = e.position
          LEFT JOIN records r ON e.kind = 'record' AND r.id = e.record
          LEFT JOIN purges p ON e.kind = 'purged' AND p.job = e.job "
    };
}

/// The last place, which may have been forgotten.
macro_rules! last_place {
    () => {
        "coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'told'), 0)"
    };
}

impl Read<SqlitePool> for GetEvents {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Vec<JobEvent>> {
        let rows: Vec<EventRow> = sqlx::query_as(concat!(
            "SELECT e.number AS number, e.created_at AS created_at, e.kind AS kind,
                    CASE WHEN e.kind = 'job' THEN 'changed' END AS job_state, ",
            named!(),
            " FROM jobs j JOIN events e ON e.job = j.seq ",
            joined!(),
            "WHERE j.id = ? AND j.tenant = ? AND e.number > ? ORDER BY e.number LIMIT ?",
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

impl Read<SqlitePool> for GetLastEvent {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<u64> {
        let last: Option<Integer<u64>> = sqlx::query_scalar(
            "SELECT coalesce((SELECT max(number) FROM events WHERE job = j.seq), 0)
             FROM jobs j WHERE j.id = ? AND j.tenant = ?",
        )
        .bind(self.job)
        .bind(caller.tenant.as_str())
        .fetch_optional(from)
        .await?;
        Ok(last.ok_or(RepositoryError::NotFound(Resource::Job))?.0)
    }
}

impl Read<SqlitePool> for GetAllEvents {
    /// A job that was deleted has taken its events along.
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Vec<ToldEvent>> {
        let rows: Vec<ToldEventRow> = sqlx::query_as(concat!(
            "SELECT 0 AS changed_by, t.place AS place, t.job AS job_id, coalesce(e.number, 0) AS number,
                    coalesce(e.created_at, t.created_at) AS created_at, coalesce(e.kind, 'job') AS kind,
                    coalesce(t.state, 'changed') AS job_state, ",
            named!(),
            " FROM told t LEFT JOIN jobs j ON t.number NOTNULL AND j.id = t.job
              LEFT JOIN events e ON e.job = j.seq AND e.number = t.number ",
            joined!(),
            "WHERE t.tenant = ? AND t.place > ? AND (t.number IS NULL OR e.number NOTNULL) ORDER BY t.place LIMIT ?",
        ))
        .bind(caller.tenant.as_str())
        .bind(signed(self.after.number))
        .bind(i64::from(self.limit))
        .fetch_all(from)
        .await?;
        rows.into_iter().map(ToldEvent::try_from).collect()
    }
}

impl Read<SqlitePool> for GetLastPlace {
    async fn read(&self, _: &Caller, from: &SqlitePool) -> Outcome<EventPlace> {
        let last: Integer<u64> = sqlx::query_scalar(concat!("SELECT ", last_place!())).fetch_one(from).await?;
        Ok(EventPlace { change: 0, number: last.0 })
    }
}

impl Read<SqlitePool> for TellsAllAfter {
    async fn read(&self, _: &Caller, from: &SqlitePool) -> Outcome<bool> {
        let told = sqlx::query_scalar("SELECT NOT EXISTS (SELECT 1 FROM told_until WHERE gone = 1 AND place > ?)");
        Ok(told.bind(signed(self.place.number)).fetch_one(from).await?)
    }
}

impl Run<SqliteConnection> for ForgetTold {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<u64> {
        sqlx::query(concat!(
            "INSERT INTO told_until (at, place) SELECT ?1, ",
            last_place!(),
            " WHERE NOT EXISTS (SELECT 1 FROM told_until WHERE at > ?2 AND at <= ?1)",
        ))
        .bind(time::to_text(self.now))
        .bind(time::to_text(self.now - NOTED_EVERY))
        .execute(&mut *db)
        .await?;
        sqlx::query("UPDATE told_until SET gone = 1 WHERE gone = 0 AND at < ?")
            .bind(time::to_text(self.before))
            .execute(&mut *db)
            .await?;
        let forgotten = sqlx::query(
            "DELETE FROM told WHERE place IN
             (SELECT place FROM told WHERE place <= (SELECT max(place) FROM told_until WHERE gone = 1)
              ORDER BY place LIMIT ?)",
        )
        .bind(i64::from(self.most))
        .execute(&mut *db)
        .await?;
        // the farthest of them says what is gone; those before it may be of a clock that was wrong
        sqlx::query(
            "DELETE FROM told_until WHERE (place, at) <
             (SELECT place, at FROM told_until WHERE gone = 1 ORDER BY place DESC, at DESC LIMIT 1)",
        )
        .execute(db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}
