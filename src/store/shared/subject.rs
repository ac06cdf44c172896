//! What a write changes.

use uuid::Uuid;

/// What a write changes: no two writes of one subject are done at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    Job(Uuid),
    /// A stream, and so the job that it is of.
    Stream(Uuid),
    /// No job, or new ones alone.
    Nothing,
}

/// A write that says what it changes.
pub trait About {
    fn about(&self) -> Subject;
}
