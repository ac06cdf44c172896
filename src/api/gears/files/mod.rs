//! Files of gear measurements.

pub mod curves;
pub mod gears;
pub mod points;
pub mod read;
