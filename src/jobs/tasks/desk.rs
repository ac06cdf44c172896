//! The use cases of tasks: begun, asked after, cancelled.

use std::{sync::Arc, time::Duration};

use tokio::sync::watch;
use uuid::Uuid;

use super::task::{KEPT_FOR, NewTask, Task, TaskQuery, TaskResult};
use crate::jobs::{
    callers::{Owned, Scope, Scopes, Tenant},
    outcome::RepositoryError,
    page::{Page, PageRequest},
    service::{JobService, Jobs},
};

/// Tasks forgotten in one transaction.
const AT_A_TIME: u32 = 100;

/// A request that is to become a task.
#[derive(Clone, Debug)]
pub struct TaskDraft {
    pub id: Uuid,
    pub scope: Scope,
    pub scopes: Scopes,
    pub request: String,
    pub job: Option<Uuid>,
    /// As the client gave it.
    pub key: Option<String>,
    pub key_scope: String,
    pub request_sha256: [u8; 32],
    pub headers: String,
    pub body: Vec<u8>,
}

impl TaskDraft {
    /// The key of a task whose client gave none: what it stores is stored once all the same.
    pub fn own_key(id: Uuid) -> String {
        format!("operation-{id}")
    }
}

/// What became of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Begun {
    /// A new task.
    New(Task),
    /// The task that the same request with the same key has begun before.
    Before(Task),
    /// The key was used for another request.
    OtherRequest,
}

impl Jobs {
    /// Keeps a request as a task, unless the tenant's tasks would then take more than so many
    /// bytes.
    pub async fn begin_task(&self, draft: TaskDraft, most: u64) -> Result<Begun, RepositoryError> {
        let now = self.now();
        let id = draft.id;
        let (given, scope) = (draft.key.clone(), draft.key_scope.clone());
        let new = NewTask {
            id,
            scope: draft.scope,
            scopes: draft.scopes,
            request: draft.request,
            job: draft.job,
            key: draft.key.unwrap_or_else(|| TaskDraft::own_key(id)),
            key_scope: draft.key_scope,
            request_sha256: draft.request_sha256,
            headers: draft.headers,
            body: draft.body,
            created_at: now,
        };
        let (job, writing) = (new.job, self.repository.insert_task(Arc::new(new), most));
        match self.then_announce(job, writing).await {
            Ok(task) => Ok(Begun::New(task)),
            // the same request came to another server, or twice to this one
            Err(RepositoryError::KeyTaken) => {
                let key = given.ok_or(RepositoryError::KeyTaken)?;
                self.task_of_key(&key, &scope, &draft.request_sha256).await?.ok_or(RepositoryError::KeyTaken)
            }
            Err(error) => Err(error),
        }
    }

    /// The task that was begun with a key.
    pub async fn task_of_key(
        &self,
        key: &str,
        scope: &str,
        request_sha256: &[u8; 32],
    ) -> Result<Option<Begun>, RepositoryError> {
        let found = self.repository.task_of_key(key.to_owned(), scope.to_owned()).await?;
        let begun = |(task, first): (Task, [u8; 32])| {
            if first == *request_sha256 { Begun::Before(task) } else { Begun::OtherRequest }
        };
        Ok(found.map(begun))
    }

    pub async fn task(&self, id: Uuid) -> Result<Task, RepositoryError> {
        self.repository.task(id).await
    }

    /// Newest first.
    pub async fn tasks(&self, of: TaskQuery, page: PageRequest) -> Result<Page<Task>, RepositoryError> {
        self.repository.tasks(of, page).await
    }

    /// A task, with its result where it has one.
    pub async fn task_result(&self, id: Uuid) -> Result<(Task, Option<TaskResult>), RepositoryError> {
        self.repository.task_result(id).await
    }

    /// Cancels a task. Of one that has ended it takes away what is kept.
    pub async fn cancel_task(&self, task: &Task) -> Result<(), RepositoryError> {
        let writing = self.repository.cancel_task(task.id, task.job, self.now());
        self.then_announce(task.job, writing).await
    }

    async fn then_announce<T: Send + 'static>(
        &self,
        job: Option<Uuid>,
        writing: impl Future<Output = Result<T, RepositoryError>> + Send,
    ) -> Result<T, RepositoryError> {
        // what was asked is in the queue of the store already
        let written = writing.await?;
        self.service.announce_task(self.tenant(), job);
        Ok(written)
    }

    /// Is woken when something happens to a task, whosever it is.
    pub fn listen_to_tasks(&self) -> watch::Receiver<u64> {
        self.service.listen_to_tasks()
    }
}

impl JobService {
    /// Is woken when something happens to a task.
    pub fn listen_to_tasks(&self) -> watch::Receiver<u64> {
        self.task_changes.subscribe()
    }

    /// Something happened to a task of this tenant, and so perhaps to a job.
    pub fn announce_task(&self, tenant: &Tenant, job: Option<Uuid>) {
        self.announce_tasks();
        if let Some(id) = job {
            self.announce(&Owned { tenant: tenant.clone(), id });
        }
    }

    /// Forgets what ended long ago.
    pub(in crate::jobs) async fn forget_old_tasks(&self) -> Result<(), RepositoryError> {
        let before = self.now() - KEPT_FOR;
        while self.tasks.forget_tasks(before, AT_A_TIME).await? == u64::from(AT_A_TIME) {
            // others write meanwhile
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        Ok(())
    }
}
