//! Tasks: requests that are answered later. Leases are by the clock of the database, which is one
//! for all processes.

use jiff::SignedDuration;
use sqlx::{PgPool, postgres::types::PgInterval};
use uuid::Uuid;

use super::{gone, leases::without_request, locate::signed, session::Session, time::stamp};
use crate::{
    jobs::{
        Caller, ClaimedTask, Cursor, Lease, Page, PageRequest, RepositoryError, Resource, Task, TaskResult, TaskState,
    },
    store::shared::{
        Asked, CancelTask, ClaimTask, ClaimedTaskRow, EndTask, ForgetTasks, GetAnswer, GetTask, GetTaskOfKey,
        GetTaskResult, GiveTaskBack, HeldRow, InsertTask, Integer, KeyedTaskRow, ListTasks, Outcome, Read, RenewTasks,
        Run, TaskResultRow, TaskRow, Write, claimed_task_columns, task_columns,
    },
};

impl Read<PgPool> for GetTask {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Task> {
        let row: Option<TaskRow> =
            sqlx::query_as(concat!("SELECT ", task_columns!(), " FROM operations o WHERE o.id = $1 AND o.tenant = $2"))
                .bind(self.id)
                .bind(caller.tenant.as_str())
                .fetch_optional(from)
                .await?;
        Ok(row.ok_or(RepositoryError::NotFound(Resource::Task))?.into())
    }
}

impl Read<PgPool> for ListTasks {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<Task>> {
        let PageRequest { limit, after } = self.page;
        let rows: Vec<TaskRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            " FROM operations o WHERE o.tenant = $1 AND o.id < $2 AND o.scope = ANY(string_to_array($3, ' '))
              ORDER BY o.id DESC LIMIT $4"
        ))
        .bind(caller.tenant.as_str())
        .bind(after.map_or(Uuid::max(), |Cursor(id)| id))
        .bind(self.of.to_string())
        .bind(i64::from(limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(Page::of(rows.into_iter().map(Task::from).collect(), limit, |task: &Task| Cursor(task.id)))
    }
}

impl Read<PgPool> for GetTaskResult {
    /// What is kept under a key stays as it is, so two looks see one state.
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<(Task, Option<TaskResult>)> {
        let row: Option<TaskResultRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            ", o.key, o.key_scope, o.result_headers, o.result FROM operations o WHERE o.id = $1 AND o.tenant = $2"
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

impl Read<PgPool> for GetTaskOfKey {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Option<(Task, [u8; 32])>> {
        let row: Option<KeyedTaskRow> = sqlx::query_as(concat!(
            "SELECT ",
            task_columns!(),
            ", o.request_sha256 FROM operations o WHERE o.tenant = $1 AND o.key = $2 AND o.key_scope = $3"
        ))
        .bind(caller.tenant.as_str())
        .bind(self.key.as_str())
        .bind(self.scope.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Write<Session> for InsertTask {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Task> {
        let (InsertTask { task, most }, caller) = (&asked.write, &asked.caller);
        let db = &mut session.db;
        if let Some(job) = task.job {
            gone::refuse(db, &caller.tenant, job).await?;
        }
        let before: Option<Uuid> =
            sqlx::query_scalar("SELECT id FROM operations WHERE tenant = $1 AND key = $2 AND key_scope = $3")
                .bind(caller.tenant.as_str())
                .bind(task.key.as_str())
                .bind(task.key_scope.as_str())
                .fetch_optional(&mut *db)
                .await?;
        match before {
            // the answer to an earlier COMMIT of this very task was lost
            Some(id) if id == task.id => return Ok(task.begun()),
            Some(_) => return Err(RepositoryError::KeyTaken.into()),
            None => {}
        }
        let held: HeldRow = sqlx::query_as(
            "SELECT coalesce(sum(bytes), 0)::bigint AS bytes, count(*) AS tasks,
                    count(*) FILTER (WHERE state IN ('queued', 'running')) AS open
             FROM operations WHERE tenant = $1",
        )
        .bind(caller.tenant.as_str())
        .fetch_one(&mut *db)
        .await?;
        task.fits(held.into(), *most)?;
        let stored = sqlx::query(
            "INSERT INTO operations (id, tenant, actor, request_id, peer, scope, scopes, request, job, key, key_scope,
                                     request_sha256, headers, body, state, attempts, progress, bytes, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, 'queued', 0, 0, $15, $16)
             ON CONFLICT DO NOTHING",
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
        .bind(stamp(task.created_at))
        .execute(db)
        .await?;
        if stored.rows_affected() == 0 {
            return Err(RepositoryError::KeyTaken.into());
        }
        Ok(task.begun())
    }
}

impl Write<Session> for CancelTask {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<()> {
        let CancelTask { id, now, .. } = &asked.write;
        let db = &mut session.db;
        let state: Option<TaskState> =
            sqlx::query_scalar("SELECT state FROM operations WHERE id = $1 AND tenant = $2 FOR NO KEY UPDATE")
                .bind(id)
                .bind(asked.tenant().as_str())
                .fetch_optional(&mut *db)
                .await?;
        if state.ok_or(RepositoryError::NotFound(Resource::Task))?.is_end() {
            sqlx::query("DELETE FROM operations WHERE id = $1").bind(id).execute(db).await?;
            return Ok(());
        }
        sqlx::query(concat!(
            "UPDATE operations SET state = 'cancelled', ended_at = $2, ",
            without_request!(),
            // no client's key has a space
            ", key = 'cancelled ' || id WHERE id = $1"
        ))
        .bind(id)
        .bind(stamp(*now))
        .execute(db)
        .await?;
        Ok(())
    }
}

fn interval(lasting: SignedDuration) -> PgInterval {
    let microseconds = i64::try_from(lasting.as_micros()).unwrap_or(i64::MAX);
    PgInterval { months: 0, days: 0, microseconds }
}

impl Run<Session> for ClaimTask {
    async fn run(&self, session: &mut Session) -> Outcome<Option<ClaimedTask>> {
        let row: Option<ClaimedTaskRow> = sqlx::query_as(concat!(
            "WITH running AS MATERIALIZED (
                 SELECT tenant, count(*) AS tasks FROM operations WHERE state = 'running' GROUP BY tenant)
             UPDATE operations SET state = 'running', lease = $1, lease_until = clock_timestamp() + $2,
                    attempts = attempts + 1, progress = 0, begun_at = $3, told_at = $3
             WHERE id = (
                 SELECT o.id FROM operations o LEFT JOIN running ON running.tenant = o.tenant
                 WHERE o.state IN ('queued', 'running')
                       AND (o.lease_until IS NULL OR o.lease_until <= clock_timestamp())
                 ORDER BY coalesce(running.tasks, 0), o.created_at, o.id
                 LIMIT 1 FOR NO KEY UPDATE OF o SKIP LOCKED)
             RETURNING ",
            claimed_task_columns!()
        ))
        .bind(self.lease)
        .bind(interval(self.lasting))
        .bind(stamp(self.now))
        .fetch_optional(&mut session.db)
        .await?;
        Ok(row.map(|row| row.under(self.lease)))
    }
}

impl Run<Session> for RenewTasks {
    async fn run(&self, session: &mut Session) -> Outcome<Vec<Lease>> {
        let of = |part: fn(&Lease) -> Uuid| self.leases.iter().map(|(lease, _)| part(lease)).collect::<Vec<_>>();
        let held: Vec<(Uuid, Uuid)> = sqlx::query_as(
            "UPDATE operations o SET lease_until = clock_timestamp() + $1, progress = n.progress, told_at = $2
             FROM unnest($3::uuid[], $4::uuid[], $5::float8[]) AS n (id, lease, progress)
             WHERE o.id = n.id AND o.lease = n.lease AND o.state = 'running' RETURNING o.id, o.lease",
        )
        .bind(interval(self.lasting))
        .bind(stamp(self.now))
        .bind(of(|lease| lease.task))
        .bind(of(|lease| lease.id))
        .bind(self.leases.iter().map(|(_, progress)| *progress).collect::<Vec<_>>())
        .fetch_all(&mut session.db)
        .await?;
        Ok(held.into_iter().map(|(task, id)| Lease { task, id }).collect())
    }
}

impl Run<Session> for EndTask {
    async fn run(&self, session: &mut Session) -> Outcome<bool> {
        let ended = &self.ended;
        let held: Integer<u64> = sqlx::query_scalar(
            "SELECT coalesce(sum(bytes), 0)::bigint FROM operations
             WHERE tenant = (SELECT tenant FROM operations WHERE id = $1) AND id <> $1",
        )
        .bind(ended.lease.task)
        .fetch_one(&mut session.db)
        .await?;
        ended.fits(held.0)?;
        let row = sqlx::query(concat!(
            "UPDATE operations SET state = $3, status = $4, result_headers = $5, result = $6, ended_at = $7,
                    progress = CASE WHEN $3 = 'succeeded' THEN 1 ELSE progress END, ",
            without_request!(),
            " + $8 WHERE id = $1 AND lease = $2 AND state = 'running'"
        ))
        .bind(ended.lease.task)
        .bind(ended.lease.id)
        .bind(ended.state.name())
        .bind(i64::from(ended.answer.status))
        .bind(ended.answer.headers.as_str())
        .bind(ended.answer.body.as_slice())
        .bind(stamp(ended.now))
        .bind(signed(ended.answer.bytes() as u64))
        .execute(&mut session.db)
        .await?;
        Ok(row.rows_affected() > 0)
    }
}

impl Run<Session> for GiveTaskBack {
    async fn run(&self, session: &mut Session) -> Outcome<()> {
        sqlx::query(
            "UPDATE operations SET state = 'queued', lease = NULL, lease_until = $3, attempts = attempts - $4,
                    begun_at = NULL, told_at = NULL, progress = 0
             WHERE id = $1 AND lease = $2 AND state = 'running'",
        )
        .bind(self.lease.task)
        .bind(self.lease.id)
        .bind(stamp(self.until))
        .bind(i64::from(!self.counts))
        .execute(&mut session.db)
        .await?;
        Ok(())
    }
}

impl Run<Session> for ForgetTasks {
    async fn run(&self, session: &mut Session) -> Outcome<u64> {
        let forgotten = sqlx::query(
            "DELETE FROM operations WHERE id IN
             (SELECT id FROM operations WHERE ended_at < $1 ORDER BY ended_at LIMIT $2 FOR UPDATE SKIP LOCKED)",
        )
        .bind(stamp(self.before))
        .bind(i64::from(self.most))
        .execute(&mut session.db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}
