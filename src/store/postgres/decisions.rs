//! What was decided of an iteration.

use sqlx::PgConnection;
use uuid::Uuid;

use super::{locate, session::Session, time::stamp};
use crate::{
    jobs::{Decision, DecisionEvent, Stored, audit::Action},
    store::shared::{Asked, Decide, DecisionRow, Latest, Outcome, Write, target},
};

/// The latest decision on an iteration.
pub async fn latest(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<Option<DecisionEvent>> {
    let row: Option<DecisionRow> = sqlx::query_as(
        "SELECT decision, reason, actor, created_at FROM decisions WHERE job = $1 AND number = $2
         ORDER BY position DESC LIMIT 1",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

impl Write<Session> for Decide {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let Decide { job, number, decision, precondition } = &asked.write;
        let db = &mut session.db;
        let version = locate::iteration(db, asked.tenant(), *job, *number).await?;
        precondition.check(version)?;
        let latest: Option<Latest<Decision>> = sqlx::query_as(
            "SELECT position, decision AS what, reason FROM decisions WHERE job = $1 AND number = $2
             ORDER BY position DESC LIMIT 1",
        )
        .bind(job)
        .bind(i64::from(*number))
        .fetch_optional(&mut *db)
        .await?;
        if latest.as_ref().is_some_and(|latest| latest.is(&decision.decision, &decision.event)) {
            return Ok(Stored { number: *number, version });
        }
        session.enter(asked, *job, Action::Decide, target::iteration(*job, *number)).await?;
        sqlx::query(
            "INSERT INTO decisions (job, number, position, decision, reason, actor, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7)",
        )
        .bind(job)
        .bind(i64::from(*number))
        .bind(Latest::next(latest.as_ref()))
        .bind(decision.decision.name())
        .bind(decision.event.reason.as_deref())
        .bind(decision.event.by.as_deref())
        .bind(stamp(decision.event.created_at))
        .execute(&mut session.db)
        .await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
