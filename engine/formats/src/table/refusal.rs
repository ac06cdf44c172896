//! Refusals of whole tables.

use super::{TableFault, TableReason};
use crate::file_error::FileError;

/// A refusal without places.
pub(super) fn refused(reason: TableReason) -> FileError {
    FileError::Table(Box::new(TableFault { reason, places: Vec::new() }))
}
