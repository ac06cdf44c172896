//! Events of a job and of all jobs, which triggers write.

use jiff::SignedDuration;

use super::{prelude::*, upkeep};

from_row! {
    EventPlace { change = "changed_by", number = "place" }
}

row! {
    /// An event with the columns of other tables; its kind says which hold something.
    struct EventRow {
        number: u64,
        created_at: Timestamp,
        kind: String,
        iteration: Option<u32>,
        iteration_id: Option<Uuid>,
        fit_id: Option<Uuid>,
        choice: Option<i64>,
        choice_reason: Option<String>,
        decision: Option<Decision>,
        decision_reason: Option<String>,
        stream_id: Option<Uuid>,
        state: Option<StreamEvent>,
        sequence: Option<u64>,
        node_count: Option<u64>,
        purge_reason: Option<String>,
        record_id: Option<Uuid>,
        record_kind: Option<RecordKind>,
        job_state: Option<JobChange>,
    }
}

row! {
    /// An event among those of all jobs.
    struct ToldEventRow {
        @place: EventPlace,
        @event: EventRow,
        job_id: Uuid,
    }
}

impl EventRow {
    fn kind(&mut self) -> Option<EventKind> {
        Some(match self.kind.as_str() {
            "iteration" => {
                EventKind::Iteration { number: self.iteration?, id: self.iteration_id?, fit_id: self.fit_id? }
            }
            "fit" => EventKind::Fit {
                number: self.iteration?,
                fit_id: self.fit_id?,
                chosen: self.choice.is_some(),
                reason: self.choice_reason.take(),
            },
            "decision" => EventKind::Decision {
                number: self.iteration?,
                decision: self.decision?,
                reason: self.decision_reason.take(),
            },
            "stream" => EventKind::Stream {
                id: self.stream_id?,
                state: self.state?,
                sequence: self.sequence?,
                node_count: self.node_count?,
                iteration: self.iteration,
            },
            "record" => EventKind::Record { number: self.iteration?, id: self.record_id?, kind: self.record_kind? },
            "job" => EventKind::Job { state: self.job_state? },
            "purged" => EventKind::Purged { reason: self.purge_reason.take()? },
            _ => return None,
        })
    }

    fn read(mut self) -> Outcome<JobEvent> {
        let kind = self.kind().ok_or_else(|| RepositoryError::Failed(damaged("an event", &self.kind)))?;
        Ok(JobEvent { number: self.number, created_at: self.created_at, kind })
    }
}

/// The columns of an event that are read from other tables, of a row `e`. (The fit of the event of
/// an iteration is its first.)
macro_rules! named {
    () => {
        "e.iteration, i.id AS iteration_id, f.id AS fit_id, c.position AS choice, c.reason AS choice_reason, d.decision,
         d.reason AS decision_reason, e.stream AS stream_id, e.state, e.sequence, e.node_count,
         p.reason AS purge_reason, e.record AS record_id, r.kind AS record_kind"
    };
}

/// The tables of these columns.
macro_rules! joined {
    () => {
        " LEFT JOIN iterations i ON i.job = e.job AND i.number = e.iteration
          LEFT JOIN fits f ON f.job = e.job AND f.number = e.iteration AND f.position = coalesce(e.fit, 1)
          LEFT JOIN fit_choices c
               ON e.kind = 'fit' AND c.job = e.job AND c.number = e.iteration AND c.position = e.position
          LEFT JOIN decisions d
               ON e.kind = 'decision' AND d.job = e.job AND d.number = e.iteration AND d.position = e.position
          LEFT JOIN records r ON e.kind = 'record' AND r.job = e.job AND r.number = e.iteration AND r.id = e.record
          LEFT JOIN purges p ON e.kind = 'purged' AND p.job = e.job "
    };
}

pub async fn events(db: &mut Db, caller: &Caller, job: &Uuid, after: &u64, limit: &u32) -> Outcome<Vec<JobEvent>> {
    let sql = concat!(
        "SELECT e.number, e.created_at, e.kind, CASE WHEN e.kind = 'job' THEN 'changed' END AS job_state, ",
        named!(),
        " FROM jobs j JOIN events e ON e.job = j.id ",
        joined!(),
        "WHERE j.id = $1 AND j.tenant = $2 AND e.number > $3 ORDER BY e.number LIMIT $4",
    );
    let rows: Vec<EventRow> = db.all(sql, args![job, &caller.tenant, *after, *limit]).await?;
    rows.into_iter().map(EventRow::read).collect()
}

pub async fn last_event(db: &mut Db, caller: &Caller, job: &Uuid) -> Outcome<u64> {
    let sql = "SELECT coalesce((SELECT max(number) FROM events WHERE job = j.id), 0)
               FROM jobs j WHERE j.id = $1 AND j.tenant = $2";
    let last: Option<u64> = db.first(sql, args![job, &caller.tenant]).await?;
    Ok(last.ok_or(RepositoryError::NotFound(Resource::Job))?)
}

/// Reads no further than to the first transaction that has not ended. A job that was deleted has
/// taken its events along.
pub async fn all_events(db: &mut Db, caller: &Caller, after: &EventPlace, limit: &u32) -> Outcome<Vec<ToldEvent>> {
    let sql = concat!(
        "SELECT t.changed_by, t.place, t.job AS job_id, coalesce(e.number, 0) AS number,
                coalesce(e.created_at, t.created_at) AS created_at, coalesce(e.kind, 'job') AS kind,
                coalesce(t.state, 'changed') AS job_state, ",
        named!(),
        " FROM told t LEFT JOIN events e ON e.job = t.job AND e.number = t.number ",
        joined!(),
        "WHERE t.tenant = $1 AND (t.changed_by, t.place) > ($2, $3) AND t.changed_by < (SELECT told FROM horizon)
               AND (t.number IS NULL OR e.number IS NOT NULL)
         ORDER BY t.changed_by, t.place LIMIT $4",
    );
    let rows: Vec<ToldEventRow> = db.all(sql, args![&caller.tenant, after.change, after.number, *limit]).await?;
    let read = |row: ToldEventRow| Ok(ToldEvent { place: row.place, job: row.job_id, event: row.event.read()? });
    rows.into_iter().map(read).collect()
}

pub async fn last_place(db: &mut Db, _: &Caller) -> Outcome<EventPlace> {
    let next: u64 = db.one("SELECT told FROM horizon", args![]).await?;
    Ok(EventPlace { change: next.saturating_sub(1), number: i64::MAX.unsigned_abs() })
}

pub async fn has_all_after(db: &mut Db, _: &Caller, place: &EventPlace) -> Outcome<bool> {
    // the place may be the last one of its transaction, and need not be
    let sql = "SELECT 1 FROM told_until
               WHERE gone AND (changed_by > $1 OR changed_by = $1 AND $2 < $3)
                     AND changed_by < (SELECT told FROM horizon) LIMIT 1";
    let last_place = db.pick(0, i64::MAX);
    Ok(!db.is_there(sql, args![place.change, place.number, last_place]).await?)
}

/// How often it is noted how far the order of all jobs' events has come.
const NOTED_EVERY: SignedDuration = SignedDuration::from_hours(1);

/// Notes how far the order of all jobs' events has come, and forgets those from before a time, the
/// oldest first, at most so many; returns how many.
pub struct ForgetTold {
    pub now: Timestamp,
    pub before: Timestamp,
    pub most: u32,
}

impl Write for ForgetTold {
    type Reply = u64;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<u64> {
        let db = tx.db();
        if !upkeep::alone(db).await? {
            return Ok(0);
        }
        if db.is_postgres() {
            forget_another_servers(db).await?;
        }
        db.run(
            "INSERT INTO told_until (at, changed_by) SELECT $1, (SELECT told FROM horizon) - 1
             WHERE NOT EXISTS (SELECT 1 FROM told_until WHERE at > $2 AND at <= $1)",
            args![self.now, self.now - NOTED_EVERY],
        )
        .await?;
        db.run("UPDATE told_until SET gone = true WHERE NOT gone AND at < $1", args![self.before]).await?;
        let forgotten = db
            .run(
                "DELETE FROM told WHERE (tenant, changed_by, place) IN
                 (SELECT tenant, changed_by, place FROM told
                  WHERE changed_by <= (SELECT max(changed_by) FROM told_until WHERE gone) LIMIT $1)",
                args![self.most],
            )
            .await?;
        // the farthest of them says what is gone; those before it may be of a clock that was wrong
        db.run(
            "DELETE FROM told_until WHERE (changed_by, at) <
             (SELECT changed_by, at FROM told_until WHERE gone ORDER BY changed_by DESC, at DESC LIMIT 1)",
            args![],
        )
        .await?;
        Ok(forgotten)
    }
}

/// Forgets places that a dump has brought from another server whose transactions had come farther:
/// by these everything that happens here would count as old.
async fn forget_another_servers(db: &mut Db) -> Outcome<()> {
    let brought: bool = db
        .one(
            "WITH notes AS (DELETE FROM told_until WHERE changed_by >= (SELECT told FROM horizon) RETURNING 1)
             SELECT EXISTS (SELECT FROM notes) OR NOT EXISTS (SELECT FROM told_until)",
            args![],
        )
        .await?;
    if brought {
        let sql = "DELETE FROM told WHERE changed_by >= greatest((SELECT next FROM horizon), pg_current_xact_id()::text::bigint + 1)";
        db.run(sql, args![]).await?;
    }
    Ok(())
}
