//! Tasks: requests that are answered later. Leases are by the clock of the database where several
//! processes share it.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use sqlx::AssertSqlSafe;
use uuid::Uuid;

use super::{
    answers,
    db::Db,
    error::Outcome,
    gone,
    leases::without_request,
    row::{ClaimedTaskRow, TaskResultRow, claimed_task_columns, task_columns},
    value::Value,
    write::{Intent, Subject, Tx, Write},
    writes::{CancelTask, InsertTask},
};
use crate::jobs::{
    Caller, ClaimedTask, Cursor, EndedTask, Held, Lease, Page, PageRequest, RepositoryError, Resource, Scopes, Task,
    TaskResult, TaskState,
};

pub async fn task(db: &mut Db, caller: &Caller, id: &Uuid) -> Outcome<Task> {
    let sql = concat!("SELECT ", task_columns!(), " FROM operations o WHERE o.id = $1 AND o.tenant = $2");
    Ok(db.maybe(sql, args![id, &caller.tenant]).await?.ok_or(RepositoryError::NotFound(Resource::Task))?)
}

pub async fn tasks(
    db: &mut Db,
    caller: &Caller,
    of: &Scopes,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<Task>> {
    let sql = concat!(
        "SELECT ",
        task_columns!(),
        " FROM operations o WHERE o.tenant = $1 AND o.id < $2 AND ' ' || $3 || ' ' LIKE '% ' || o.scope || ' %'
          ORDER BY o.id DESC LIMIT $4"
    );
    let after = after.map_or(Uuid::max(), |Cursor(id)| id);
    let rows: Vec<Task> = db.all(sql, args![&caller.tenant, after, of.to_string(), i64::from(*limit) + 1]).await?;
    Ok(Page::of(rows, *limit, |task| Cursor(task.id)))
}

/// An answer that is kept under a key stays as it is, so both statements see the same.
pub async fn task_result(db: &mut Db, caller: &Caller, id: &Uuid) -> Outcome<(Task, Option<TaskResult>)> {
    let sql = concat!(
        "SELECT ",
        task_columns!(),
        ", o.key AS key, o.key_scope AS key_scope, o.result_headers AS result_headers, o.result AS result
         FROM operations o WHERE o.id = $1 AND o.tenant = $2"
    );
    let row: Option<TaskResultRow> = db.maybe(sql, args![id, &caller.tenant]).await?;
    let row = row.ok_or(RepositoryError::NotFound(Resource::Task))?;
    let (key, scope) = (row.key.clone(), row.key_scope.clone());
    Ok(match row.into_parts() {
        (task, Some(own)) => (task, Some(TaskResult::Own(own))),
        (task, None) if task.state == TaskState::Succeeded => {
            let answer = answers::answer(db, caller, &key, &scope).await?;
            (task, answer.map(|(_, answer)| TaskResult::Kept(answer)))
        }
        (task, None) => (task, None),
    })
}

row! {
    /// A task with the digest of its request.
    struct KeyedTask {
        @task: Task,
        request_sha256: [u8; 32],
    }
}

pub async fn task_of_key(
    db: &mut Db,
    caller: &Caller,
    key: &String,
    scope: &String,
) -> Outcome<Option<(Task, [u8; 32])>> {
    let sql = concat!(
        "SELECT ",
        task_columns!(),
        ", o.request_sha256 AS request_sha256
         FROM operations o WHERE o.tenant = $1 AND o.key = $2 AND o.key_scope = $3"
    );
    let row: Option<KeyedTask> = db.maybe(sql, args![&caller.tenant, key, scope]).await?;
    Ok(row.map(|row| (row.task, row.request_sha256)))
}

fn of_job(job: Option<Uuid>, bytes: usize) -> Intent<'static> {
    Intent { subject: job.map_or(Subject::Nothing, Subject::Job), bytes, ..Intent::default() }
}

impl Write for InsertTask {
    type Reply = Task;

    fn intent(&self) -> Intent<'_> {
        of_job(self.task.job, self.task.bytes())
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Task> {
        let (task, caller) = (&self.task, &tx.asked.caller);
        let db = &mut tx.session.db;
        if let Some(job) = task.job {
            gone::refuse(db, &caller.tenant, job).await?;
        }
        let sql = "SELECT id FROM operations WHERE tenant = $1 AND key = $2 AND key_scope = $3";
        match db.first::<Uuid>(sql, args![&caller.tenant, &task.key, &task.key_scope]).await? {
            // the answer to an earlier COMMIT of this very task was lost
            Some(id) if id == task.id => return Ok(task.begun()),
            Some(_) => return Err(RepositoryError::KeyTaken.into()),
            None => {}
        }
        let sql = "SELECT CAST(coalesce(sum(bytes), 0) AS bigint) AS bytes, count(*) AS tasks,
                          count(*) FILTER (WHERE state IN ('queued', 'running')) AS open
                   FROM operations WHERE tenant = $1";
        let held: Option<Held> = db.maybe(sql, args![&caller.tenant]).await?;
        task.fits(held.unwrap_or_default(), self.most)?;
        let sql =
            "INSERT INTO operations (id, tenant, actor, request_id, peer, scope, scopes, request, job, key, key_scope,
                                     request_sha256, headers, body, state, attempts, progress, bytes, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, 'queued', 0, 0, $15, $16)
             ON CONFLICT DO NOTHING";
        let args: &[Value<'_>] = args![
            task.id,
            &caller.tenant,
            &caller.actor,
            caller.origin.request_id.as_deref(),
            caller.origin.peer.map(|peer| peer.to_string()),
            task.scope.name(),
            task.scopes.to_string(),
            &task.request,
            task.job,
            &task.key,
            &task.key_scope,
            &task.request_sha256,
            &task.headers,
            &task.body,
            task.bytes(),
            task.created_at,
        ];
        match db.run(sql, args).await? {
            0 => Err(RepositoryError::KeyTaken.into()),
            _ => Ok(task.begun()),
        }
    }
}

impl Write for CancelTask {
    type Reply = ();

    fn intent(&self) -> Intent<'_> {
        of_job(self.job, 0)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        let (CancelTask { id, now, .. }, tenant) = (self, tx.tenant());
        let db = tx.db();
        let sql = format!("SELECT state FROM operations WHERE id = $1 AND tenant = $2{}", db.locked());
        let state: Option<TaskState> = db.first(AssertSqlSafe(sql), args![id, tenant]).await?;
        if state.ok_or(RepositoryError::NotFound(Resource::Task))?.is_end() {
            db.run("DELETE FROM operations WHERE id = $1", args![id]).await?;
            return Ok(());
        }
        let sql = concat!(
            "UPDATE operations SET state = 'cancelled', ended_at = $2, key = $3, ",
            without_request!(),
            " WHERE id = $1"
        );
        // no client's key has a space
        db.run(sql, args![id, *now, format!("cancelled {id}")]).await?;
        Ok(())
    }
}

/// Takes the task that is next.
pub struct ClaimTask {
    pub lease: Uuid,
    pub now: Timestamp,
    pub lasting: SignedDuration,
}

/// The time at which a lease that is given now ends, by the clock of PostgreSQL: $2 is its length
/// in microseconds.
macro_rules! lease_end {
    () => {
        "clock_timestamp() + $2 * interval '1 microsecond'"
    };
}

/// Returns the length of a lease for PostgreSQL, the end for SQLite.
fn lease_end(db: &Db, now: Timestamp, lasting: SignedDuration) -> Value<'static> {
    let microseconds = i64::try_from(lasting.as_micros()).unwrap_or(i64::MAX);
    db.pick((now + lasting).into(), microseconds.into())
}

impl Write for ClaimTask {
    type Reply = Option<ClaimedTask>;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Option<ClaimedTask>> {
        macro_rules! claim {
            ($end:expr, $now:literal, $index:literal, $lock:literal) => {
                concat!(
                    "WITH running AS MATERIALIZED (
                         SELECT tenant, count(*) AS tasks FROM operations ",
                    $index,
                    " WHERE state IN ('queued', 'running') AND state = 'running' GROUP BY tenant)
                     UPDATE operations SET state = 'running', lease = $1, lease_until = ",
                    $end,
                    ", attempts = attempts + 1, progress = 0, begun_at = $3, told_at = $3
                     WHERE id = (
                         SELECT o.id FROM operations o LEFT JOIN running ON running.tenant = o.tenant
                         WHERE o.state IN ('queued', 'running') AND (o.lease_until IS NULL OR o.lease_until <= ",
                    $now,
                    ") ORDER BY coalesce(running.tasks, 0), o.created_at, o.id LIMIT 1 ",
                    $lock,
                    ") RETURNING ",
                    claimed_task_columns!()
                )
            };
        }
        let db = tx.db();
        let sql = db.pick(
            claim!("$2", "$3", "INDEXED BY operations_open", ""),
            claim!(lease_end!(), "clock_timestamp()", "", "FOR NO KEY UPDATE OF o SKIP LOCKED"),
        );
        let end = lease_end(db, self.now, self.lasting);
        let row: Option<ClaimedTaskRow> = db.maybe(sql, &[self.lease.into(), end, self.now.into()]).await?;
        Ok(row.map(|row| row.under(self.lease)))
    }
}

/// Prolongs leases, each with how far its task is; returns those that hold.
pub struct RenewTasks {
    pub leases: Vec<(Lease, f64)>,
    pub now: Timestamp,
    pub lasting: SignedDuration,
}

impl Write for RenewTasks {
    type Reply = Vec<Lease>;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Vec<Lease>> {
        macro_rules! renew {
            ($end:expr) => {
                concat!(
                    "UPDATE operations SET progress = $1, lease_until = ",
                    $end,
                    ", told_at = $3 WHERE id = $4 AND lease = $5 AND state = 'running'"
                )
            };
        }
        let db = tx.db();
        let sql = db.pick(renew!("$2"), renew!(lease_end!()));
        let mut held = Vec::with_capacity(self.leases.len());
        for (lease, progress) in &self.leases {
            let end = lease_end(db, self.now, self.lasting);
            let args = [(*progress).into(), end, self.now.into(), lease.task.into(), lease.id.into()];
            held.extend((db.run(sql, &args).await? > 0).then_some(*lease));
        }
        Ok(held)
    }
}

/// Stores the end of a task; returns whether its lease held.
pub struct EndTask {
    pub ended: Arc<EndedTask>,
}

impl Write for EndTask {
    type Reply = bool;

    /// It is an event of the job.
    fn intent(&self) -> Intent<'_> {
        of_job(self.ended.job, self.ended.answer.body.len())
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<bool> {
        let (ended, db) = (&self.ended, tx.db());
        let sql = "SELECT CAST(coalesce(sum(bytes), 0) AS bigint) FROM operations
                   WHERE tenant = (SELECT tenant FROM operations WHERE id = $1) AND id <> $1";
        let held: u64 = db.one(sql, args![ended.lease.task]).await?;
        ended.fits(held)?;
        let sql = concat!(
            "UPDATE operations SET state = $3, status = $4, result_headers = $5, result = $6, ended_at = $7,
                    progress = CASE WHEN $3 = 'succeeded' THEN 1 ELSE progress END, ",
            without_request!(),
            " + $8 WHERE id = $1 AND lease = $2 AND state = 'running'"
        );
        let args: &[Value<'_>] = args![
            ended.lease.task,
            ended.lease.id,
            ended.state.name(),
            ended.answer.status,
            &ended.answer.headers,
            &ended.answer.body,
            ended.now,
            ended.answer.bytes(),
        ];
        Ok(db.run(sql, args).await? > 0)
    }
}

/// Gives a task back, to be taken after a time.
pub struct GiveTaskBack {
    pub lease: Lease,
    pub until: Timestamp,
    pub counts: bool,
}

impl Write for GiveTaskBack {
    type Reply = ();

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        let sql = "UPDATE operations SET state = 'queued', lease = NULL, lease_until = $3, attempts = attempts - $4,
                          begun_at = NULL, told_at = NULL, progress = 0
                   WHERE id = $1 AND lease = $2 AND state = 'running'";
        let attempts = i64::from(!self.counts);
        tx.db().run(sql, args![self.lease.task, self.lease.id, self.until, attempts]).await?;
        Ok(())
    }
}

/// Forgets tasks that ended before a time, at most so many; returns how many.
pub struct ForgetTasks {
    pub before: Timestamp,
    pub most: u32,
}

impl Write for ForgetTasks {
    type Reply = u64;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<u64> {
        macro_rules! forget {
            ($lock:literal) => {
                concat!(
                    "DELETE FROM operations WHERE id IN
                     (SELECT id FROM operations WHERE ended_at < $1 ORDER BY ended_at LIMIT $2",
                    $lock,
                    ")"
                )
            };
        }
        let db = tx.db();
        let sql = db.pick(forget!(""), forget!(" FOR UPDATE SKIP LOCKED"));
        Ok(db.run(sql, args![self.before, self.most]).await?)
    }
}
