//! A record with what it belongs to.

use crate::jobs::{Job, MeasurementDetails, Record};

/// Job and iteration of a record.
pub struct Kept {
    pub record: Record,
    pub job: Job,
    /// Number of the iteration.
    pub number: u32,
    pub details: MeasurementDetails,
}
