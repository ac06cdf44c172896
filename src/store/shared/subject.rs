//! Subject of a write.

use uuid::Uuid;

use crate::jobs::audit::Contents;

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

    /// The contents of its entries, as far as they are known before it is done. One entry, whose
    /// contents are none or known only to the store, unless it is said.
    fn contents(&self) -> Vec<Contents> {
        vec![Contents::default()]
    }

    /// See [`Operation::erases`](super::operation::Operation::erases).
    fn erases(&self) -> bool {
        false
    }
}
