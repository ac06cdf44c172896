//! What the reader of an evaluation must know.

use super::fault::TraceField;

/// Something that the reader must know, with a stable code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice<F = TraceField> {
    /// Stable code.
    pub code: &'static str,
    /// What it speaks of, where it is one thing.
    pub field: Option<F>,
    /// The same in words.
    pub message: String,
}
