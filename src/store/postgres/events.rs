//! Events of a job, which triggers write.

use sqlx::PgPool;

use super::locate::signed;
use crate::{
    jobs::{Caller, JobEvent, RepositoryError, Resource},
    store::shared::{EventRow, GetEvents, GetLastEvent, Integer, Outcome, Read},
};

impl Read<PgPool> for GetEvents {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Vec<JobEvent>> {
        // the fit of an iteration's event is its first
        let rows: Vec<EventRow> = sqlx::query_as(
            "SELECT e.number, e.created_at, e.kind, e.iteration, i.id AS iteration_id, f.id AS fit_id,
                    c.position AS choice, c.reason AS choice_reason, d.decision, d.reason AS decision_reason,
                    e.stream AS stream_id, e.state, e.sequence, e.node_count, e.operation, e.operation_state,
                    p.reason AS purge_reason
             FROM jobs j JOIN events e ON e.job = j.id
                  LEFT JOIN iterations i ON i.job = e.job AND i.number = e.iteration
                  LEFT JOIN fits f ON f.job = e.job AND f.number = e.iteration AND f.position = coalesce(e.fit, 1)
                  LEFT JOIN fit_choices c
                       ON e.kind = 'fit' AND c.job = e.job AND c.number = e.iteration AND c.position = e.position
                  LEFT JOIN decisions d
                       ON e.kind = 'decision' AND d.job = e.job AND d.number = e.iteration AND d.position = e.position
                  LEFT JOIN purges p ON e.kind = 'purged' AND p.job = e.job
             WHERE j.id = $1 AND j.tenant = $2 AND e.number > $3 ORDER BY e.number LIMIT $4",
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
