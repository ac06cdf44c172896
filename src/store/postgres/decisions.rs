//! Decisions on iterations, and changes of their measurand.

use sqlx::PgConnection;
use uuid::Uuid;

use super::{fits, locate, records, session::Session, time::stamp};
use crate::{
    jobs::{Amendment, Decision, DecisionEvent, JobGear, Stored, audit::Action},
    store::shared::{Amend, Asked, Decide, DecisionRow, Latest, Outcome, Write, target},
};

/// The latest decision on an iteration.
pub async fn latest(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<Option<DecisionEvent>> {
    let row: Option<DecisionRow> = sqlx::query_as(
        "SELECT decision, concession, reason, actor, created_at FROM decisions WHERE job = $1 AND number = $2
         ORDER BY position DESC LIMIT 1",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

async fn insert_row(db: &mut PgConnection, job: Uuid, number: i64, decision: &DecisionEvent) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO decisions (job, number, position, decision, concession, reason, actor, created_at)
         SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5, $6, $7
         FROM decisions WHERE job = $1 AND number = $2",
    )
    .bind(job)
    .bind(number)
    .bind(decision.decision.name())
    .bind(decision.concession.then_some(1_i64))
    .bind(decision.event.reason.as_deref())
    .bind(decision.event.by.as_deref())
    .bind(stamp(decision.event.created_at))
    .execute(db)
    .await?;
    Ok(())
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
        insert_row(&mut session.db, *job, i64::from(*number), decision).await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}

impl Write<Session> for Amend {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let Amend { job, number, amendment, precondition } = &asked.write;
        let Amendment { measurand, record, fit, decision } = &**amendment;
        let version = locate::iteration(&mut session.db, asked.tenant(), *job, *number).await?;
        precondition.check(version)?;
        let gear: Option<String> =
            sqlx::query_scalar("SELECT gear FROM jobs WHERE id = $1").bind(job).fetch_one(&mut session.db).await?;
        measurand.check_tooth(gear.map(JobGear::from).as_ref().and_then(JobGear::teeth))?;
        session.enter(asked, *job, Action::Amend, target::iteration(*job, *number)).await?;
        let (db, number) = (&mut session.db, i64::from(*number));
        records::insert_next(db, *job, number, record).await?;
        if let Some(fit) = fit {
            let place = fits::insert_next(db, *job, number, fit).await?;
            fits::insert_choice(db, place, &fit.choice()).await?;
        }
        if let Some(decision) = decision {
            insert_row(db, *job, number, decision).await?;
        }
        Ok(Stored { number: asked.write.number, version: version + amendment.steps() })
    }
}
