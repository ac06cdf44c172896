//! The right to do a task.

use uuid::Uuid;

/// Who does a task: valid as long as the store says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lease {
    pub task: Uuid,
    /// New each time that a task is taken.
    pub id: Uuid,
}
