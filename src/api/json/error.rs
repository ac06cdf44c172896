//! Why a request cannot be taken.

use super::cursor::{Syntax, line_and_column};
use crate::api::faults::Faults;

/// Why a body was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// Not JSON (or not CSV), with the place.
    #[error("{detail}")]
    Malformed { detail: String },
    /// JSON (or CSV) that says what cannot be done.
    #[error("{} fault(s)", .0.count())]
    Invalid(Faults),
}

impl<F: Into<Faults>> From<F> for ReadError {
    fn from(faults: F) -> Self {
        ReadError::Invalid(faults.into())
    }
}

/// The refusal of a text that is not JSON.
pub fn malformed(text: &[u8], syntax: &Syntax) -> ReadError {
    let (line, column) = line_and_column(text, syntax.at);
    ReadError::Malformed { detail: format!("Line {line}, column {column}: {}.", syntax.what) }
}
