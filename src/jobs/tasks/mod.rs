//! Tasks: requests that are answered later (`Prefer: respond-async`). The interface calls them
//! operations, which is what methods of the repository are called here.
//!
//! A task is kept with its whole request, and done by whichever process takes it: that one has a
//! [`Lease`], which it renews. A task whose lease has run out is begun anew by another.
//!
//! **Nothing is stored twice.** What a task stores has a receipt as every keyed request, under the
//! key of the client or one of the task's own, and the receipt names the lease
//! ([`super::KeyedRequest::lease`]). The transaction that stores looks whether the task still runs
//! under that lease, refuses if not ([`super::RepositoryError::LeaseLost`]), and ends the task with
//! the answer that it keeps under the key. So what is stored and the end of the task are one: an
//! owner that comes late, or whose task was cancelled, stores nothing; and a task whose process was
//! killed before that commit has stored nothing, one killed after it has ended. The answer of a
//! task that stores nothing is written down by [`Tasks::end`], under the lease too.

mod desk;
mod lease;
mod task;

pub use desk::{Begun, TaskDraft};
pub use lease::Lease;
pub use task::{
    ClaimedTask, EndedTask, Held, KEPT_FOR, LEASE, MOST_ATTEMPTS, MOST_KEPT, MOST_OPEN, NewTask, Task, TaskAnswer,
    TaskQuery, TaskResult, TaskState, Tasks,
};
