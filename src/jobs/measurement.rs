//! When, with what and by whom nodes were measured.

use jiff::Timestamp;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeasurementDetails {
    pub measured_at: Option<Timestamp>,
    pub instrument: Option<String>,
    pub operator: Option<String>,
    pub note: Option<String>,
}
