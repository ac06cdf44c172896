//! Description of the measurement: flank, tooth and axes.

pub mod axes;
pub mod units;
