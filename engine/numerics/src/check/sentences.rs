//! Messages that errors of many kinds have in common.

use crate::words::{Shown, counted, entries};

/// A number that is NaN or infinite.
pub fn not_finite() -> String {
    "the number is not finite in double precision".to_owned()
}

/// A number that is not above the one before it.
pub fn not_ascending(value: f64, before: f64) -> String {
    format!("{} does not ascend: it follows {}", Shown(value), Shown(before))
}

/// A number that is below 0 or not finite.
pub fn negative(value: f64) -> String {
    format!("{} is not a finite number of at least 0", Shown(value))
}

/// A number that is 0, below 0 or not finite.
pub fn not_positive(value: f64) -> String {
    format!("{} is not a finite number above 0", Shown(value))
}

/// A list with another number of entries than there are nodes.
pub fn per_node(given: usize, nodes: usize) -> String {
    format!("{} for {}", entries(given), counted(nodes, "node", "nodes"))
}

/// A list of another length than the positions that it belongs to.
pub fn per_position(given: usize, positions: usize) -> String {
    format!("{}, but {positions} would match the positions", entries(given))
}

/// Message for a deviation above what is measured, µm.
pub fn deviation_exceeds(value: f64, most: f64) -> String {
    format!("{} exceeds {} µm: check the unit", Shown(value), Shown(most))
}

/// Message for a length above what is measured, mm.
pub fn length_exceeds(value: f64, most: f64) -> String {
    format!("{} exceeds {} mm: check the unit", Shown(value), Shown(most))
}

/// Ends of a range that do not ascend, mm.
pub fn range([from, to]: [f64; 2]) -> String {
    format!("{} to {} mm is not an ascending range", Shown(from), Shown(to))
}
