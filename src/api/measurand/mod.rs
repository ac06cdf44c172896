//! What was measured: flank, tooth and the meaning of the axes.

pub mod axes;
pub mod profile_axis;
pub mod side;
pub mod units;
