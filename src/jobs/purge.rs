//! Jobs whose nodes, results, texts and names were removed. The row, its numbers and its times are
//! kept, and so are the entries of who changed what.

use jiff::Timestamp;
use uuid::Uuid;

/// A purge of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Purge {
    pub job: Uuid,
    pub at: Timestamp,
    pub reason: String,
}
