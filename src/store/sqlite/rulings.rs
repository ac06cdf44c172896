//! What was decided of an iteration.

use sqlx::{FromRow, SqliteConnection};

use super::{
    locate::{self, IterationVersion},
    time,
};
use crate::{
    jobs::{Decision, Ruling, Stored},
    store::shared::{Outcome, Rule, RulingRow, Run},
};

/// The latest ruling on an iteration.
pub async fn latest(db: &mut SqliteConnection, iteration: i64) -> Outcome<Option<Ruling>> {
    let row: Option<RulingRow> = sqlx::query_as(
        "SELECT decision, reason, created_at FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
    )
    .bind(iteration)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

#[derive(FromRow)]
struct LatestRuling {
    position: i64,
    decision: Decision,
    reason: Option<String>,
}

impl Run<SqliteConnection> for Rule {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<Stored> {
        let Rule { job, number, ruling, precondition } = self;
        let IterationVersion { seq, version } = locate::iteration(db, *job, *number).await?;
        precondition.check(version)?;
        let latest: Option<LatestRuling> = sqlx::query_as(
            "SELECT position, decision, reason FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
        )
        .bind(seq)
        .fetch_optional(&mut *db)
        .await?;
        let same = |latest: &LatestRuling| (latest.decision, &latest.reason) == (ruling.decision, &ruling.event.reason);
        if latest.as_ref().is_some_and(same) {
            return Ok(Stored { number: *number, version });
        }
        sqlx::query("INSERT INTO decisions (iteration, position, decision, reason, created_at) VALUES (?, ?, ?, ?, ?)")
            .bind(seq)
            .bind(latest.map_or(0, |latest| latest.position) + 1)
            .bind(ruling.decision.name())
            .bind(ruling.event.reason.as_deref())
            .bind(time::to_text(ruling.event.created_at))
            .execute(db)
            .await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
