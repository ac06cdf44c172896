//! Messages that faults of many kinds have in common.

use crate::fault::words::Shown;

/// A number that is NaN or infinite.
pub fn not_finite() -> String {
    "the number is not finite in double precision".to_owned()
}

/// A number that is not above the one before it.
pub fn not_ascending(value: f64, before: f64) -> String {
    format!("{} does not ascend: it follows {}", Shown(value), Shown(before))
}
