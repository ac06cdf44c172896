//! Messages that writers share.

use flankfit_numerics::check::Faults;

/// Refuses to write a file with nothing in it.
pub(crate) fn nothing() -> Faults {
    Faults::one("", "there is nothing to write")
}

/// Message for a node outside the range of the file's numbers.
pub(crate) fn node_range(index: usize) -> String {
    format!("node {index} exceeds the range of the file's numbers")
}

/// The message of a file with more lines than the format can number.
pub(crate) fn too_long(lines: usize, most: usize) -> String {
    format!("the file would have {lines} lines; this format numbers at most {most}")
}
