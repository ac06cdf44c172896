//! Tasks.

use std::sync::Arc;

use uuid::Uuid;

use crate::{
    jobs::{Caller, ClaimedTask, Held, Lease, Origin, Scope, Scopes, Task, TaskAnswer, TaskState, Tenant},
    store::sql::columns::{Digest, Integer, Moment},
};

/// The columns of [`TaskRow`].
macro_rules! task_columns {
    () => {
        "o.id AS id, o.scope AS scope, o.request AS request, o.job AS job, o.state AS state, o.attempts AS attempts, \
         o.progress AS progress, o.told_at AS told_at, o.created_at AS created_at, o.begun_at AS begun_at, \
         o.ended_at AS ended_at, o.status AS status, o.bytes AS bytes"
    };
}
pub(in crate::store) use task_columns;

row! {
    pub struct TaskRow {
        id: Uuid,
        scope: Scope,
        request: String,
        job: Option<Uuid>,
        state: TaskState,
        attempts: Integer<u32>,
        progress: f64,
        told_at: Option<Moment>,
        created_at: Moment,
        begun_at: Option<Moment>,
        ended_at: Option<Moment>,
        status: Option<Integer<u16>>,
        bytes: Integer<u64>,
    }
}

impl From<TaskRow> for Task {
    fn from(row: TaskRow) -> Self {
        Task {
            id: row.id,
            scope: row.scope,
            request: row.request,
            job: row.job,
            state: row.state,
            attempts: row.attempts.0,
            progress: row.progress,
            told_at: row.told_at.map(|time| time.0),
            created_at: row.created_at.0,
            begun_at: row.begun_at.map(|time| time.0),
            ended_at: row.ended_at.map(|time| time.0),
            status: row.status.map(|status| status.0),
            bytes: row.bytes.0,
        }
    }
}

row! {
    /// What the tasks of a tenant are and take.
    pub struct HeldRow {
        bytes: Integer<u64>,
        tasks: Integer<u64>,
        open: Integer<u64>,
    }
}

impl From<HeldRow> for Held {
    fn from(row: HeldRow) -> Self {
        Held { bytes: row.bytes.0, tasks: row.tasks.0, open: row.open.0 }
    }
}

row! {
    /// A task with the digest of its request.
    pub struct KeyedTaskRow {
        @task: TaskRow,
        request_sha256: Digest,
    }
}

impl From<KeyedTaskRow> for (Task, [u8; 32]) {
    fn from(KeyedTaskRow { task, request_sha256 }: KeyedTaskRow) -> Self {
        (task.into(), request_sha256.0)
    }
}

row! {
    /// A task with what is written down of its answer, and the key under which the rest is kept.
    pub struct TaskResultRow {
        @task: TaskRow,
        pub key: String,
        pub key_scope: String,
        result_headers: Option<String>,
        result: Option<Vec<u8>>,
    }
}

impl TaskResultRow {
    /// The task, and its own answer where it has one.
    pub fn into_parts(self) -> (Task, Option<TaskAnswer>) {
        let status = self.task.status.map(|status| status.0);
        let answer = status.zip(self.result_headers).zip(self.result);
        let answer = answer.map(|((status, headers), body)| TaskAnswer { status, headers, body });
        (self.task.into(), answer)
    }
}

/// The columns of [`ClaimedTaskRow`].
macro_rules! claimed_task_columns {
    () => {
        "id, tenant, actor, request_id, peer, scopes, request, job, key, attempts, headers, body"
    };
}
pub(in crate::store) use claimed_task_columns;

row! {
    pub struct ClaimedTaskRow {
        id: Uuid,
        tenant: Tenant,
        actor: String,
        request_id: Option<String>,
        peer: Option<String>,
        scopes: Scopes,
        request: String,
        job: Option<Uuid>,
        key: String,
        attempts: Integer<u32>,
        headers: String,
        body: Vec<u8>,
    }
}

impl ClaimedTaskRow {
    pub fn under(self, lease: Uuid) -> ClaimedTask {
        let origin =
            Origin { request_id: self.request_id.map(Arc::from), peer: self.peer.and_then(|peer| peer.parse().ok()) };
        ClaimedTask {
            lease: Lease { task: self.id, id: lease },
            caller: Caller { tenant: self.tenant, actor: self.actor.into(), origin },
            scopes: self.scopes,
            request: self.request,
            job: self.job,
            key: self.key,
            attempts: self.attempts.0,
            headers: self.headers,
            body: self.body,
        }
    }
}
