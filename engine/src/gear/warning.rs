//! What must be known of a registration or a correction.

/// A stable code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Stable.
    pub code: &'static str,
    /// In words, with the numbers that matter.
    pub message: String,
}
