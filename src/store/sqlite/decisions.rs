//! What was decided of an iteration.

use sqlx::{FromRow, SqliteConnection};

use super::{
    locate::{self, IterationVersion},
    time,
};
use crate::{
    jobs::{Caller, Decision, DecisionEvent, Stored},
    store::shared::{Decide, DecisionRow, Outcome, Write},
};

/// The latest decision on an iteration.
pub async fn latest(db: &mut SqliteConnection, iteration: i64) -> Outcome<Option<DecisionEvent>> {
    let row: Option<DecisionRow> = sqlx::query_as(
        "SELECT decision, reason, created_at FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
    )
    .bind(iteration)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

#[derive(FromRow)]
struct LatestDecision {
    position: i64,
    decision: Decision,
    reason: Option<String>,
}

impl Write<SqliteConnection> for Decide {
    async fn write(&self, caller: &Caller, db: &mut SqliteConnection) -> Outcome<Stored> {
        let Decide { job, number, decision, precondition } = self;
        let IterationVersion { seq, version } = locate::iteration(db, &caller.tenant, *job, *number).await?;
        precondition.check(version)?;
        let latest: Option<LatestDecision> = sqlx::query_as(
            "SELECT position, decision, reason FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
        )
        .bind(seq)
        .fetch_optional(&mut *db)
        .await?;
        let same =
            |latest: &LatestDecision| (latest.decision, &latest.reason) == (decision.decision, &decision.event.reason);
        if latest.as_ref().is_some_and(same) {
            return Ok(Stored { number: *number, version });
        }
        sqlx::query("INSERT INTO decisions (iteration, position, decision, reason, created_at) VALUES (?, ?, ?, ?, ?)")
            .bind(seq)
            .bind(latest.map_or(0, |latest| latest.position) + 1)
            .bind(decision.decision.name())
            .bind(decision.event.reason.as_deref())
            .bind(time::to_text(decision.event.created_at))
            .execute(db)
            .await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
