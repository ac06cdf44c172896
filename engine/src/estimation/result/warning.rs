//! Warnings are data: a stable code, and a sentence for people.

/// A stable code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Stable code.
    pub code: &'static str,
    /// The same in words.
    pub message: String,
}
