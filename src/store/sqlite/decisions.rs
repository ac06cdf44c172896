//! What was decided of an iteration.

use sqlx::SqliteConnection;

use super::{
    audit,
    locate::{self, IterationVersion},
    time,
};
use crate::{
    jobs::{Decision, DecisionEvent, Stored, audit::Action},
    store::shared::{Asked, Decide, DecisionRow, Latest, Outcome, Write, target},
};

/// The latest decision on an iteration.
pub async fn latest(db: &mut SqliteConnection, iteration: i64) -> Outcome<Option<DecisionEvent>> {
    let row: Option<DecisionRow> = sqlx::query_as(
        "SELECT decision, reason, actor, created_at FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
    )
    .bind(iteration)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

impl Write<SqliteConnection> for Decide {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let Decide { job, number, decision, precondition } = &asked.write;
        let IterationVersion { seq, version } = locate::iteration(db, asked.tenant(), *job, *number).await?;
        precondition.check(version)?;
        let latest: Option<Latest<Decision>> = sqlx::query_as(
            "SELECT position, decision AS what, reason FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
        )
        .bind(seq)
        .fetch_optional(&mut *db)
        .await?;
        if latest.as_ref().is_some_and(|latest| latest.is(&decision.decision, &decision.event)) {
            return Ok(Stored { number: *number, version });
        }
        let mut chain = audit::of_job(db, asked.by(), *job).await?;
        sqlx::query(
            "INSERT INTO decisions (iteration, position, decision, reason, actor, created_at) VALUES (?, ?, ?, ?, ?, ?)",
        )
        .bind(seq)
        .bind(Latest::next(latest.as_ref()))
        .bind(decision.decision.name())
        .bind(decision.event.reason.as_deref())
        .bind(decision.event.by.as_deref())
        .bind(time::to_text(decision.event.created_at))
        .execute(&mut *db)
        .await?;
        asked.enter(&mut chain, Action::Decide, target::iteration(*job, *number));
        audit::store(db, chain).await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
