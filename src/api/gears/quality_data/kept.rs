//! A record with what it belongs to.

use crate::jobs::{Job, MeasurementDetails, Record};

/// What a record belongs to.
pub struct Kept {
    pub record: Record,
    pub job: Job,
    /// Of the iteration.
    pub number: u32,
    pub details: MeasurementDetails,
}
