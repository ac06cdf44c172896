//! Tasks.

use std::sync::Arc;

use uuid::Uuid;

use crate::jobs::{Caller, ClaimedTask, Held, Lease, Origin, Scopes, Task, TaskAnswer, Tenant};

/// The columns of a [`Task`].
macro_rules! task_columns {
    () => {
        "o.id AS id, o.scope AS scope, o.request AS request, o.job AS job, o.state AS state, o.attempts AS attempts, \
         o.progress AS progress, o.told_at AS told_at, o.created_at AS created_at, o.begun_at AS begun_at, \
         o.ended_at AS ended_at, o.status AS status, o.bytes AS bytes"
    };
}
pub(in crate::store::sql) use task_columns;

from_row! {
    Task {
        id, scope, request, job, state, attempts, progress, told_at, created_at, begun_at, ended_at, status, bytes,
    }
    Held { bytes, tasks, open }
}

row! {
    /// A task with its stored answer, and the key under which the rest is kept.
    pub struct TaskResultRow {
        @task: Task,
        pub key: String,
        pub key_scope: String,
        result_headers: Option<String>,
        result: Option<Vec<u8>>,
    }
}

impl TaskResultRow {
    /// Returns the task, and its own answer where it has one.
    pub fn into_parts(self) -> (Task, Option<TaskAnswer>) {
        let answer = self.task.status.zip(self.result_headers).zip(self.result);
        let answer = answer.map(|((status, headers), body)| TaskAnswer { status, headers, body });
        (self.task, answer)
    }
}

/// The columns of [`ClaimedTaskRow`].
macro_rules! claimed_task_columns {
    () => {
        "id, tenant, actor, request_id, peer, scopes, request, job, key, attempts, headers, body"
    };
}
pub(in crate::store::sql) use claimed_task_columns;

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
        attempts: u32,
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
            attempts: self.attempts,
            headers: self.headers,
            body: self.body,
        }
    }
}
