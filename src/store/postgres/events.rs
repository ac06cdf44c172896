//! Events of a job and of all jobs, which triggers write.

use sqlx::PgPool;

use super::locate::signed;
use crate::{
    jobs::{Caller, EventPlace, JobEvent, RepositoryError, Resource, ToldEvent},
    store::shared::{
        EventRow, GetAllEvents, GetEvents, GetLastEvent, GetLastPlace, Integer, Outcome, Read, ToldEventRow,
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
