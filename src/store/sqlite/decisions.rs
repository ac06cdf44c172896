//! Decisions on iterations, and changes of their measurand.

use sqlx::SqliteConnection;

use super::{
    audit, fits,
    locate::{self, IterationVersion},
    records, time,
};
use crate::{
    jobs::{Amendment, Decision, DecisionEvent, JobGear, Stored, audit::Action},
    store::shared::{Amend, Asked, Decide, DecisionRow, Latest, Outcome, Write, target},
};

/// The latest decision on an iteration.
pub async fn latest(db: &mut SqliteConnection, iteration: i64) -> Outcome<Option<DecisionEvent>> {
    let row: Option<DecisionRow> = sqlx::query_as(
        "SELECT decision, concession, reason, actor, created_at FROM decisions WHERE iteration = ?
         ORDER BY position DESC LIMIT 1",
    )
    .bind(iteration)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
}

async fn insert_row(db: &mut SqliteConnection, iteration: i64, position: i64, decision: &DecisionEvent) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO decisions (iteration, position, decision, concession, reason, actor, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(iteration)
    .bind(position)
    .bind(decision.decision.name())
    .bind(decision.concession.then_some(1_i64))
    .bind(decision.event.reason.as_deref())
    .bind(decision.event.by.as_deref())
    .bind(time::to_text(decision.event.created_at))
    .execute(db)
    .await?;
    Ok(())
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
        insert_row(db, seq, Latest::next(latest.as_ref()), decision).await?;
        asked.enter(&mut chain, Action::Decide, target::iteration(*job, *number));
        audit::store(db, chain).await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}

impl Write<SqliteConnection> for Amend {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let Amend { job, number, amendment, precondition } = &asked.write;
        let Amendment { measurand, record, fit, decision } = &**amendment;
        let IterationVersion { seq, version } = locate::iteration(db, asked.tenant(), *job, *number).await?;
        precondition.check(version)?;
        let gear: Option<String> =
            sqlx::query_scalar("SELECT gear FROM jobs WHERE id = ?").bind(job).fetch_one(&mut *db).await?;
        measurand.check_tooth(gear.map(JobGear::from).as_ref().and_then(JobGear::teeth))?;
        let mut chain = audit::of_job(db, asked.by(), *job).await?;
        records::insert_row(db, seq, record).await?;
        if let Some(fit) = fit {
            let row = fits::insert_row(db, seq, fit).await?;
            fits::insert_choice(db, seq, row, &fit.choice()).await?;
        }
        if let Some(decision) = decision {
            let last: i64 = sqlx::query_scalar("SELECT coalesce(max(position), 0) FROM decisions WHERE iteration = ?")
                .bind(seq)
                .fetch_one(&mut *db)
                .await?;
            insert_row(db, seq, last + 1, decision).await?;
        }
        asked.enter(&mut chain, Action::Amend, target::iteration(*job, *number));
        audit::store(db, chain).await?;
        Ok(Stored { number: *number, version: version + amendment.steps() })
    }
}
