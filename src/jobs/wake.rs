//! Messages between processes that use one store.

use super::callers::Owned;

/// Something that others may wait for. It carries no data: whoever hears it looks into the store,
/// so a wake that is lost costs time, and one too many a look.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Wake {
    /// Something happened to a job.
    Job(Owned),
    /// Some stream was finished or deleted.
    StreamEnd,
    /// Some key or some tenant was changed.
    Keys,
    /// Nothing was heard for a while, and anything may have happened.
    Anything,
}
