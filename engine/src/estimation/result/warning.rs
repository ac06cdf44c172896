//! Warnings are data: a stable code, and a sentence for people.

/// A stable code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    pub code: &'static str,
    pub message: String,
}
