//! Decisions on iterations, and changes of their measurand.

use super::{fits, locate, prelude::*, records, subject};

/// Returns the latest decision on an iteration.
pub async fn latest(db: &mut Db, job: Uuid, number: u32) -> Outcome<Option<DecisionEvent>> {
    let sql = "SELECT decision, concession IS NOT NULL AS concession, reason, actor, created_at
               FROM decisions WHERE job = $1 AND number = $2
               ORDER BY position DESC LIMIT 1";
    Ok(db.maybe(sql, args![job, number]).await?)
}

/// Returns the last decisions on an iteration, and how many come before them.
pub async fn last(db: &mut Db, job: Uuid, number: u32) -> Outcome<(Vec<DecisionEvent>, u64)> {
    let sql = "SELECT decision, concession IS NOT NULL AS concession, reason, actor, created_at,
                      (SELECT count(*) FROM decisions WHERE job = $1 AND number = $2) AS total
               FROM decisions WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3";
    locate::last(db, sql, job, number).await
}

async fn insert(db: &mut Db, job: Uuid, number: u32, decision: &DecisionEvent, entry: &mut Draft) -> Outcome<()> {
    let DecisionEvent { decision, concession, event } = decision;
    db.run(
        "INSERT INTO decisions (job, number, position, decision, concession, reason, actor, created_at)
         SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5, $6, $7
         FROM decisions WHERE job = $1 AND number = $2",
        args![
            job,
            number,
            decision.name(),
            concession.then_some(1_i64),
            event.reason.as_deref(),
            event.by.as_deref(),
            event.created_at,
        ],
    )
    .await?;
    let last = "job = $1 AND number = $2 ORDER BY position DESC LIMIT 1";
    entry.note_stored(db, "decisions", last, args![job, number]).await
}

pub async fn decide(tx: &mut Tx<'_>, write: &Decide) -> Outcome<Stored> {
    let (Decide { job, number, decision, precondition }, tenant) = (write, tx.tenant());
    let version = locate::version(tx.db(), tenant, *job, *number).await?;
    precondition.check(version)?;
    let latest = latest(tx.db(), *job, *number).await?;
    let is_same = |latest: DecisionEvent| {
        (latest.decision, latest.event.reason) == (decision.decision, decision.event.reason.clone())
    };
    if latest.is_some_and(is_same) {
        return Ok(Stored { number: *number, version });
    }
    let mut entry = tx.draft(*job, Action::Decide, subject::iteration(*job, *number))?;
    insert(tx.db(), *job, *number, decision, &mut entry).await?;
    tx.enter(entry);
    Ok(Stored { number: *number, version: version + 1 })
}

pub async fn amend(tx: &mut Tx<'_>, write: &Amend) -> Outcome<Stored> {
    let (Amend { job, number, amendment, precondition }, tenant) = (write, tx.tenant());
    let version = locate::version(tx.db(), tenant, *job, *number).await?;
    precondition.check(version)?;
    let gear: Option<JobGear> = tx.db().one("SELECT gear FROM jobs WHERE id = $1", args![job]).await?;
    let teeth = gear.as_ref().and_then(JobGear::teeth);
    amendment.measurand.check_tooth(teeth)?;
    let mut entry = tx.draft(*job, Action::Amend, subject::iteration(*job, *number))?;
    let db = tx.db();
    records::insert_next(db, *job, *number, &amendment.record, &mut entry).await?;
    if let Some(fit) = &amendment.fit {
        let place = fits::insert_next(db, *job, *number, fit, &mut entry).await?;
        fits::insert_choice(db, place, &fit.choice(), &mut entry).await?;
    }
    if let Some(decision) = &amendment.decision {
        insert(db, *job, *number, decision, &mut entry).await?;
    }
    tx.enter(entry);
    Ok(Stored { number: *number, version: version + amendment.steps() })
}
