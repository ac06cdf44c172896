//! Events of a job, which triggers write.

use sqlx::SqlitePool;

use super::locate::signed;
use crate::{
    jobs::{Caller, JobEvent, RepositoryError, Resource},
    store::shared::{EventRow, GetEvents, GetLastEvent, Integer, Outcome, Read},
};

impl Read<SqlitePool> for GetEvents {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Vec<JobEvent>> {
        let rows: Vec<EventRow> = sqlx::query_as(
            "SELECT e.number AS number, e.created_at AS created_at, e.kind AS kind,
                i.number AS iteration, i.id AS iteration_id,
                coalesce(f.id, (SELECT id FROM fits WHERE iteration = e.iteration ORDER BY seq LIMIT 1)) AS fit_id,
                c.position AS choice, c.reason AS choice_reason,
                d.decision AS decision, d.reason AS decision_reason,
                e.stream AS stream_id, e.state AS state, e.sequence AS sequence, e.node_count AS node_count,
                e.operation AS operation, e.operation_state AS operation_state, p.reason AS purge_reason
         FROM jobs j JOIN events e ON e.job = j.seq
              LEFT JOIN iterations i ON i.seq = e.iteration
              LEFT JOIN fits f ON f.seq = e.fit
              LEFT JOIN fit_choices c ON e.kind = 'fit' AND c.iteration = e.iteration AND c.position = e.position
              LEFT JOIN decisions d ON e.kind = 'decision' AND d.iteration = e.iteration AND d.position = e.position
              LEFT JOIN purges p ON e.kind = 'purged' AND p.job = e.job
         WHERE j.id = ? AND j.tenant = ? AND e.number > ? ORDER BY e.number LIMIT ?",
        )
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
        "SELECT coalesce((SELECT max(number) FROM events WHERE job = j.seq), 0) FROM jobs j WHERE j.id = ? AND j.tenant = ?",
    )
    .bind(self.job)
    .bind(caller.tenant.as_str())
    .fetch_optional(from)
    .await?;
        Ok(last.ok_or(RepositoryError::NotFound(Resource::Job))?.0)
    }
}
