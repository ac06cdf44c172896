//! A task, its states, and how a store hands it out.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::lease::Lease;
use crate::jobs::{
    callers::{Caller, Scope, Scopes},
    idempotency::Answer,
    outcome::{RepositoryError, RepositoryFuture},
};

/// How long a process has a task without renewing its lease.
pub const LEASE: SignedDuration = SignedDuration::from_secs(10);
/// How often a task is begun whose processes were lost.
pub const MOST_ATTEMPTS: u32 = 3;
/// How long a task is kept once it has ended, and its result with it.
pub const KEPT_FOR: SignedDuration = SignedDuration::from_hours(1);
/// Tasks of a tenant that have not ended, at most: whoever looks for the next one passes them all.
pub const MOST_OPEN: u64 = 1_000;
/// Tasks of a tenant, those included that are kept since they ended.
pub const MOST_KEPT: u64 = 10_000;

/// Where a task stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskState {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl TaskState {
    const ALL: [TaskState; 5] =
        [TaskState::Queued, TaskState::Running, TaskState::Succeeded, TaskState::Failed, TaskState::Cancelled];

    pub fn name(self) -> &'static str {
        match self {
            TaskState::Queued => "queued",
            TaskState::Running => "running",
            TaskState::Succeeded => "succeeded",
            TaskState::Failed => "failed",
            TaskState::Cancelled => "cancelled",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }

    /// Whether nothing will change any more.
    pub fn is_end(self) -> bool {
        !matches!(self, TaskState::Queued | TaskState::Running)
    }
}

/// A task as it is told about.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    pub id: Uuid,
    /// What its request asked its caller for.
    pub scope: Scope,
    /// Path and query of its POST.
    pub request: String,
    /// Job of the request.
    pub job: Option<Uuid>,
    pub state: TaskState,
    /// How often it was begun.
    pub attempts: u32,
    /// From 0 to 1, as of `told_at`.
    pub progress: f64,
    pub told_at: Option<Timestamp>,
    pub created_at: Timestamp,
    /// The last time.
    pub begun_at: Option<Timestamp>,
    pub ended_at: Option<Timestamp>,
    /// Status of the answer.
    pub status: Option<u16>,
    /// What it takes in the store: of one that has ended its own answer.
    pub bytes: u64,
}

/// Least progress, and least time, from which the time left is told.
const TELLING: (f64, f64) = (0.01, 1.0);

impl Task {
    /// Seconds until it will have ended if it goes on as before; `None` while that means nothing.
    pub fn remaining(&self, now: Timestamp) -> Option<f64> {
        let (begun, told) = self.begun_at.zip(self.told_at).filter(|_| self.state == TaskState::Running)?;
        let taken = told.duration_since(begun).as_secs_f64();
        if !(TELLING.0..=1.0).contains(&self.progress) || taken < TELLING.1 {
            return None;
        }
        let left = taken * (1.0 - self.progress) / self.progress;
        Some((left - now.duration_since(told).as_secs_f64().max(0.0)).max(0.0))
    }
}

/// A task to be kept.
#[derive(Clone, Debug)]
pub struct NewTask {
    pub id: Uuid,
    pub scope: Scope,
    /// All that its caller may do.
    pub scopes: Scopes,
    pub request: String,
    pub job: Option<Uuid>,
    /// The idempotency key of the request, or one of the task's own; and what it is for.
    pub key: String,
    pub key_scope: String,
    pub request_sha256: [u8; 32],
    /// Headers of the request that matter, as a JSON document.
    pub headers: String,
    /// The body, compressed.
    pub body: Vec<u8>,
    pub created_at: Timestamp,
}

impl NewTask {
    /// What it takes in the store.
    pub fn bytes(&self) -> usize {
        self.request.len() + self.headers.len() + self.body.len()
    }

    /// Whether there is room for it, where the tenant's tasks may take so many bytes.
    pub fn fits(&self, held: Held, most: u64) -> Result<(), RepositoryError> {
        if held.open >= MOST_OPEN || held.tasks >= MOST_KEPT {
            return Err(RepositoryError::TooManyTasks { open: held.open, kept: held.tasks });
        }
        if held.bytes.saturating_add(self.bytes() as u64) > most {
            return Err(RepositoryError::TasksFull { held: held.bytes });
        }
        Ok(())
    }

    /// The task that it is once it is kept.
    pub fn begun(&self) -> Task {
        Task {
            id: self.id,
            scope: self.scope,
            request: self.request.clone(),
            job: self.job,
            state: TaskState::Queued,
            attempts: 0,
            progress: 0.0,
            told_at: None,
            created_at: self.created_at,
            begun_at: None,
            ended_at: None,
            status: None,
            bytes: self.bytes() as u64,
        }
    }
}

/// What the tasks of a tenant are and take in the store.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    pub bytes: u64,
    pub tasks: u64,
    /// Those of them that have not ended.
    pub open: u64,
}

/// Which tasks are listed: those whose request the caller may make.
pub type TaskQuery = Scopes;

/// A task that was taken.
#[derive(Clone, Debug)]
pub struct ClaimedTask {
    pub lease: Lease,
    /// Whose request it is.
    pub caller: Caller,
    pub scopes: Scopes,
    pub request: String,
    pub job: Option<Uuid>,
    pub key: String,
    /// This time included.
    pub attempts: u32,
    pub headers: String,
    pub body: Vec<u8>,
}

/// What is answered to the request of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskAnswer {
    pub status: u16,
    /// As a JSON document.
    pub headers: String,
    /// Compressed.
    pub body: Vec<u8>,
}

impl TaskAnswer {
    /// What it takes in the store.
    pub fn bytes(&self) -> usize {
        self.headers.len() + self.body.len()
    }
}

/// The result of a task that has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskResult {
    /// Written down with the task.
    Own(TaskAnswer),
    /// Kept under its key, with what it tells of.
    Kept(Answer),
}

/// A task that has ended.
#[derive(Clone, Debug)]
pub struct EndedTask {
    pub lease: Lease,
    pub job: Option<Uuid>,
    pub state: TaskState,
    pub answer: TaskAnswer,
    /// Bytes that the tenant's tasks may take with it.
    pub most: u64,
    pub now: Timestamp,
}

impl EndedTask {
    /// Whether there is room for its answer beside what the tenant's other tasks take.
    pub fn fits(&self, held: u64) -> Result<(), RepositoryError> {
        match held.saturating_add(self.answer.bytes() as u64) > self.most {
            true => Err(RepositoryError::TasksFull { held }),
            false => Ok(()),
        }
    }
}

/// The tasks of all tenants, for the processes that do them.
pub trait Tasks: Send + Sync + 'static {
    /// Takes the task that is next: one that waits, or whose lease has run out, of the tenant of
    /// whom the fewest are done at present, the oldest of that.
    fn claim(&self, lease: Uuid, now: Timestamp, lasting: SignedDuration) -> RepositoryFuture<'_, Option<ClaimedTask>>;

    /// Prolongs leases and writes down how far their tasks are; answers the leases that hold.
    fn renew(
        &self,
        leases: Vec<(Lease, f64)>,
        now: Timestamp,
        lasting: SignedDuration,
    ) -> RepositoryFuture<'_, Vec<Lease>>;

    /// Writes down the end of a task, if there is room for its answer; answers whether its lease
    /// held.
    fn end(&self, ended: Arc<EndedTask>) -> RepositoryFuture<'_, bool>;

    /// Gives a task back to whoever takes it after that time. An attempt that does not `count` is
    /// as if it had not been.
    fn give_back(&self, lease: Lease, until: Timestamp, counts: bool) -> RepositoryFuture<'_, ()>;

    /// Forgets tasks that ended before a time, at most so many; answers how many.
    fn forget_tasks(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64>;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(progress: f64, told_after: i64) -> Task {
        let begun = Timestamp::from_second(1_000_000).unwrap();
        Task {
            id: Uuid::nil(),
            scope: Scope::Compute,
            request: "/v1/fits".into(),
            job: None,
            state: TaskState::Running,
            attempts: 1,
            progress,
            told_at: Some(begun + SignedDuration::from_secs(told_after)),
            created_at: begun,
            begun_at: Some(begun),
            ended_at: None,
            status: None,
            bytes: 100,
        }
    }

    #[test]
    fn the_time_left_is_told_when_it_means_something() {
        let at = |second: i64| Timestamp::from_second(1_000_000 + second).unwrap();
        assert_eq!(task(0.25, 10).remaining(at(10)), Some(30.0));
        assert_eq!(task(0.25, 10).remaining(at(15)), Some(25.0), "time goes on between two tellings");
        assert_eq!(task(0.25, 10).remaining(at(100)), Some(0.0));
        assert_eq!(task(0.25, 10).remaining(at(0)), Some(30.0), "clocks of two processes differ");
        assert_eq!(task(1.0, 10).remaining(at(10)), Some(0.0));
        assert_eq!(task(0.0, 10).remaining(at(10)), None);
        assert_eq!(task(0.005, 10).remaining(at(10)), None);
        assert_eq!(task(0.5, 0).remaining(at(0)), None);
        assert_eq!(task(f64::NAN, 10).remaining(at(10)), None);
        let ended = Task { state: TaskState::Failed, ..task(0.5, 10) };
        assert_eq!(ended.remaining(at(10)), None);
        let queued = Task { state: TaskState::Queued, told_at: None, ..task(0.5, 10) };
        assert_eq!(queued.remaining(at(10)), None);
    }

    #[test]
    fn what_there_is_no_room_for_is_refused() {
        let new = NewTask {
            id: Uuid::nil(),
            scope: Scope::Compute,
            scopes: Scopes::of(&[Scope::Compute]),
            request: "/v1/fits".into(),
            job: None,
            key: "k".into(),
            key_scope: "POST /v1/fits".into(),
            request_sha256: [0; 32],
            headers: "[]".into(),
            body: vec![0; 90],
            created_at: Timestamp::UNIX_EPOCH,
        };
        let held = Held { bytes: 50, tasks: MOST_KEPT - 1, open: MOST_OPEN - 1 };
        assert!(new.fits(held, 150).is_ok());
        assert!(matches!(new.fits(held, 149), Err(RepositoryError::TasksFull { held: 50 })));
        let many = Held { open: MOST_OPEN, ..held };
        assert!(matches!(new.fits(many, 150), Err(RepositoryError::TooManyTasks { open: MOST_OPEN, .. })));
        let kept = Held { tasks: MOST_KEPT, open: 0, ..held };
        assert!(matches!(new.fits(kept, 150), Err(RepositoryError::TooManyTasks { open: 0, kept: MOST_KEPT })));
    }

    #[test]
    fn states_have_names() {
        for state in TaskState::ALL {
            assert_eq!(TaskState::named(state.name()), Some(state));
        }
        assert_eq!(TaskState::named("done"), None);
        assert_eq!(TaskState::ALL.map(TaskState::is_end), [false, false, true, true, true]);
    }
}
