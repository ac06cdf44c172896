//! Files of gear measurements.

pub mod content;
pub mod curves;
pub mod gears;
pub mod listed;
pub mod pitch;
pub mod points;
pub mod proposal;
pub mod read;
pub mod spec;
