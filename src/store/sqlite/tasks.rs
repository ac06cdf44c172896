//! Tasks: requests that are answered later.

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};

use super::{gone, locate::signed, time};
use crate::{
    jobs::{
        Caller, ClaimedTask, Cursor, Lease, Page, PageRequest, Receipt, RepositoryError, Resource, Task, TaskResult,
        TaskState,
    },
    store::shared::{
        Asked, CancelTask, ClaimTask, ClaimedTaskRow, EndTask, ForgetTasks, GetAnswer, GetTask, GetTaskOfKey,
        GetTaskResult, GiveTaskBack, HeldRow, InsertTask, Integer, KeyedTaskRow, ListTasks, Outcome, Read, RenewTasks,
        Run, TaskResultRow, TaskRow, Write, claimed_task_columns, task_columns,
    },
};

/// What a task that has ended keeps of its request: nothing that is long. Last come its bytes.
macro_rules! without_request {
    () => {
        "lease = NULL, lease_until = NULL, headers = '[]', body = x'', \
         bytes = bytes - length(CAST(headers AS BLOB)) - length(body)"
    };
}

impl Read<SqlitePool> for GetTask {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Task> {
        let row: Option<TaskRow> =
            sqlx::query_as(concat!("SELECT ", task_columns!(), " FROM operations o WHERE o.id = ? AND o.tenant = ?"))
                .bind(self.id)
                .bind(caller.tenant.as_str())
                .fetch_optional(from)
                .await?;
        Ok(row.ok_or(RepositoryError::NotFound(Resource::Task))?.into())
    }
}

impl Read<SqlitePool> for ListTasks {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<Task>> {
        let PageRequest { limit, after } = self.page;
        let after = after.map_or([0xff; 16].to_vec(), |Cursor(id)| id.as_bytes().to_vec());
        let rows: Vec<TaskRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            " FROM operations o WHERE o.tenant = ? AND o.id < ? AND instr(' ' || ? || ' ', ' ' || o.scope || ' ') > 0
              ORDER BY o.id DESC LIMIT ?"
        ))
        .bind(caller.tenant.as_str())
        .bind(after)
        .bind(self.of.to_string())
        .bind(i64::from(limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(Page::of(rows.into_iter().map(Task::from).collect(), limit, |task: &Task| Cursor(task.id)))
    }
}

impl Read<SqlitePool> for GetTaskResult {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<(Task, Option<TaskResult>)> {
        let row: Option<TaskResultRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            ", o.key AS key, o.key_scope AS key_scope, o.result_headers AS result_headers, o.result AS result
             FROM operations o WHERE o.id = ? AND o.tenant = ?"
        ))
        .bind(self.id)
        .bind(caller.tenant.as_str())
        .fetch_optional(from)
        .await?;
        let row = row.ok_or(RepositoryError::NotFound(Resource::Task))?;
        let kept = GetAnswer { key: row.key.clone(), scope: row.key_scope.clone() };
        Ok(match row.into_parts() {
            (task, Some(own)) => (task, Some(TaskResult::Own(own))),
            (task, None) if task.state == TaskState::Succeeded => {
                let answer = kept.read(caller, from).await?;
                (task, answer.map(|(_, answer)| TaskResult::Kept(answer)))
            }
            (task, None) => (task, None),
        })
    }
}

impl Read<SqlitePool> for GetTaskOfKey {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<(Task, [u8; 32])>> {
        let row: Option<KeyedTaskRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            ", o.request_sha256 AS request_sha256
             FROM operations o WHERE o.tenant = ? AND o.key = ? AND o.key_scope = ?"
        ))
        .bind(caller.tenant.as_str())
        .bind(self.key.as_str())
        .bind(self.scope.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Write<SqliteConnection> for InsertTask {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Task> {
        let (InsertTask { task, most }, caller) = (&asked.write, &asked.caller);
        if let Some(job) = task.job {
            gone::refuse(db, &caller.tenant, job).await?;
        }
        let taken = sqlx::query("SELECT 1 FROM operations WHERE tenant = ? AND key = ? AND key_scope = ?")
            .bind(caller.tenant.as_str())
            .bind(task.key.as_str())
            .bind(task.key_scope.as_str())
            .fetch_optional(&mut *db)
            .await?;
        if taken.is_some() {
            return Err(RepositoryError::KeyTaken.into());
        }
        let held: HeldRow = sqlx::query_as(
            "SELECT coalesce(sum(bytes), 0) AS bytes, count(*) AS tasks,
                    count(*) FILTER (WHERE state IN ('queued', 'running')) AS open
             FROM operations WHERE tenant = ?",
        )
        .bind(caller.tenant.as_str())
        .fetch_one(&mut *db)
        .await?;
        task.fits(held.into(), *most)?;
        sqlx::query(
            "INSERT INTO operations (id, tenant, actor, request_id, peer, scope, scopes, request, job, key, key_scope,
                                     request_sha256, headers, body, state, attempts, progress, bytes, created_at)
             VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'queued', 0, 0, ?, ?)",
        )
        .bind(task.id)
        .bind(caller.tenant.as_str())
        .bind(&*caller.actor)
        .bind(caller.origin.request_id.as_deref())
        .bind(caller.origin.peer.map(|peer| peer.to_string()))
        .bind(task.scope.name())
        .bind(task.scopes.to_string())
        .bind(task.request.as_str())
        .bind(task.job)
        .bind(task.key.as_str())
        .bind(task.key_scope.as_str())
        .bind(task.request_sha256.as_slice())
        .bind(task.headers.as_str())
        .bind(task.body.as_slice())
        .bind(signed(task.bytes() as u64))
        .bind(time::to_text(task.created_at))
        .execute(db)
        .await?;
        Ok(task.begun())
    }
}

impl Write<SqliteConnection> for CancelTask {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<()> {
        let CancelTask { id, now, .. } = &asked.write;
        let state: Option<TaskState> = sqlx::query_scalar("SELECT state FROM operations WHERE id = ? AND tenant = ?")
            .bind(id)
            .bind(asked.tenant().as_str())
            .fetch_optional(&mut *db)
            .await?;
        if state.ok_or(RepositoryError::NotFound(Resource::Task))?.is_end() {
            sqlx::query("DELETE FROM operations WHERE id = ?").bind(id).execute(db).await?;
            return Ok(());
        }
        sqlx::query(concat!(
            "UPDATE operations SET state = 'cancelled', ended_at = ?, ",
            without_request!(),
            // no client's key has a space
            ", key = 'cancelled ' || hex(id) WHERE id = ?"
        ))
        .bind(time::to_text(*now))
        .bind(id)
        .execute(db)
        .await?;
        Ok(())
    }
}

/// Whether the task of a receipt still runs under the receipt's lease.
pub async fn holds(db: &mut SqliteConnection, receipt: &Receipt) -> Result<bool, sqlx::Error> {
    let Some(Lease { task, id }) = receipt.request.lease else { return Ok(true) };
    let row = sqlx::query("SELECT 1 FROM operations WHERE id = ? AND lease = ? AND state = 'running'")
        .bind(task)
        .bind(id)
        .fetch_optional(db)
        .await?;
    Ok(row.is_some())
}

/// Ends the task whose answer is kept under its key.
pub async fn end_kept(db: &mut SqliteConnection, lease: Lease, status: u16, now: Timestamp) -> Outcome<()> {
    sqlx::query(concat!(
        "UPDATE operations SET state = 'succeeded', status = ?, ended_at = ?, progress = 1, ",
        without_request!(),
        " WHERE id = ? AND lease = ? AND state = 'running'"
    ))
    .bind(i64::from(status))
    .bind(time::to_text(now))
    .bind(lease.task)
    .bind(lease.id)
    .execute(db)
    .await?;
    Ok(())
}

impl Run<SqliteConnection> for ClaimTask {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<Option<ClaimedTask>> {
        let now = time::to_text(self.now);
        let row: Option<ClaimedTaskRow> = sqlx::query_as(concat!(
            "WITH running AS MATERIALIZED (
                 SELECT tenant, count(*) AS tasks FROM operations INDEXED BY operations_open
                 WHERE state IN ('queued', 'running') AND state = 'running' GROUP BY tenant)
             UPDATE operations SET state = 'running', lease = ?1, lease_until = ?2, attempts = attempts + 1,
                    progress = 0, begun_at = ?3, told_at = ?3
             WHERE id = (
                 SELECT o.id FROM operations o LEFT JOIN running ON running.tenant = o.tenant
                 WHERE o.state IN ('queued', 'running') AND (o.lease_until IS NULL OR o.lease_until <= ?3)
                 ORDER BY coalesce(running.tasks, 0), o.created_at, o.id
                 LIMIT 1)
             RETURNING ",
            claimed_task_columns!()
        ))
        .bind(self.lease)
        .bind(time::to_text(self.now + self.lasting))
        .bind(now)
        .fetch_optional(db)
        .await?;
        Ok(row.map(|row| row.under(self.lease)))
    }
}

impl Run<SqliteConnection> for RenewTasks {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<Vec<Lease>> {
        let (now, until) = (time::to_text(self.now), time::to_text(self.now + self.lasting));
        let mut held = Vec::with_capacity(self.leases.len());
        for (lease, progress) in &self.leases {
            let renewed = sqlx::query(
                "UPDATE operations SET lease_until = ?, progress = ?, told_at = ?
                 WHERE id = ? AND lease = ? AND state = 'running'",
            )
            .bind(until.as_str())
            .bind(progress)
            .bind(now.as_str())
            .bind(lease.task)
            .bind(lease.id)
            .execute(&mut *db)
            .await?;
            held.extend((renewed.rows_affected() > 0).then_some(*lease));
        }
        Ok(held)
    }
}

impl Run<SqliteConnection> for EndTask {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<bool> {
        let ended = &self.ended;
        let held: Integer<u64> = sqlx::query_scalar(
            "SELECT coalesce(sum(bytes), 0) FROM operations
             WHERE tenant = (SELECT tenant FROM operations WHERE id = ?1) AND id <> ?1",
        )
        .bind(ended.lease.task)
        .fetch_one(&mut *db)
        .await?;
        ended.fits(held.0)?;
        let row = sqlx::query(concat!(
            "UPDATE operations SET state = ?1, status = ?2, result_headers = ?3, result = ?4, ended_at = ?5,
                    progress = iif(?1 = 'succeeded', 1, progress), ",
            without_request!(),
            " + ?6 WHERE id = ?7 AND lease = ?8 AND state = 'running'"
        ))
        .bind(ended.state.name())
        .bind(i64::from(ended.answer.status))
        .bind(ended.answer.headers.as_str())
        .bind(ended.answer.body.as_slice())
        .bind(time::to_text(ended.now))
        .bind(signed(ended.answer.bytes() as u64))
        .bind(ended.lease.task)
        .bind(ended.lease.id)
        .execute(db)
        .await?;
        Ok(row.rows_affected() > 0)
    }
}

impl Run<SqliteConnection> for GiveTaskBack {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<()> {
        sqlx::query(
            "UPDATE operations SET state = 'queued', lease = NULL, lease_until = ?, attempts = attempts - ?,
                    begun_at = NULL, told_at = NULL, progress = 0
             WHERE id = ? AND lease = ? AND state = 'running'",
        )
        .bind(time::to_text(self.until))
        .bind(i64::from(!self.counts))
        .bind(self.lease.task)
        .bind(self.lease.id)
        .execute(db)
        .await?;
        Ok(())
    }
}

impl Run<SqliteConnection> for ForgetTasks {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<u64> {
        let forgotten = sqlx::query(
            "DELETE FROM operations WHERE id IN
             (SELECT id FROM operations WHERE ended_at < ? ORDER BY ended_at LIMIT ?)",
        )
        .bind(time::to_text(self.before))
        .bind(i64::from(self.most))
        .execute(db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}

/// Frees the tasks that an earlier process has left: this one is the only one.
pub async fn free_all(db: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    sqlx::query("UPDATE operations SET state = 'queued', lease = NULL, lease_until = NULL WHERE state = 'running'")
        .execute(db)
        .await?;
    Ok(())
}
