//! Reasons why a table cannot be read, and assumptions about one that was.

use std::fmt;

use super::{Layout, Meaning, Unit};
use crate::file_error::FileError;
use flankfit_numerics::{
    warnings,
    words::{counted, listed},
};

/// A table that cannot be read: one fault, and the first places.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFault {
    /// Path to what is wrong in `mapping`; none where it is the table.
    pub path: Option<String>,
    /// The error in words, and its remedy.
    pub message: String,
    /// Error in the columns that distinguish flanks, if it is one.
    pub flanks: Option<FlankFault>,
    /// The first places, where there are any.
    pub places: Vec<TablePlace>,
}

/// An error in the columns that distinguish flanks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlankFault {
    /// A word for a flank is neither left nor right.
    Unknown,
    /// More flanks than are read.
    TooMany,
}

impl TableFault {
    /// Number of places that are named.
    pub const MOST_PLACES: usize = 5;

    /// A fault of the table.
    pub(super) fn of_table(message: impl fmt::Display) -> Self {
        TableFault { path: None, message: message.to_string(), flanks: None, places: Vec::new() }
    }

    /// A fault of what `mapping` says.
    pub(super) fn of_mapping(path: impl fmt::Display, message: impl fmt::Display) -> Self {
        TableFault { path: Some(path.to_string()), ..TableFault::of_table(message) }
    }
}

impl From<TableFault> for FileError {
    fn from(fault: TableFault) -> Self {
        FileError::Table(Box::new(fault))
    }
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TablePlace {
    /// Line, from 1.
    pub line: usize,
    /// Number of the cell in its line, from 1.
    pub column: usize,
    /// Name of the column; empty without a header.
    pub name: String,
    /// The beginning of what it holds.
    pub found: String,
}

impl fmt::Display for TablePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)?;
        if !self.name.is_empty() {
            write!(f, " ({})", self.name)?;
        }
        if self.found.is_empty() { write!(f, ": empty") } else { write!(f, ": `{}`", self.found) }
    }
}

/// A layout as messages call it.
pub(super) fn what(layout: Layout) -> &'static str {
    match layout {
        Layout::Grid => "nodes on a grid",
        Layout::Scattered => "scattered nodes",
        Layout::Curve => "nodes of a curve",
        Layout::Points => "points",
    }
}

impl fmt::Display for TableFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        self.places.iter().try_for_each(|place| write!(f, "; {place}"))
    }
}

warnings! {
/// Assumption about a table, or a part that was left out.
pub enum TableNote {
    /// No header names the columns; they are taken by their number.
    #[error(
        "no header names the columns; they are assumed to be {}", listed(.meanings.iter().map(|meaning| meaning.name()))
    )]
    "meaning_assumed" => MeaningAssumed { meanings: Vec<Meaning> },
    /// The header names no unit.
    #[error("the column `{name}` names no unit; `{}` is assumed", .unit.name())]
    "unit_assumed" => UnitAssumed { name: String, unit: Unit },
    /// A column is not read.
    #[error("the column `{name}` is not read")]
    "column_ignored" => ColumnIgnored { name: String },
    /// Lines before the header are no part of the table.
    #[error("{} before the table left out", counted(*.lines, "line is", "lines are"))]
    "lines_left_out" => LinesLeftOut { lines: usize },
}
}
