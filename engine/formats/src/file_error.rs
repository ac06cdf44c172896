//! Reasons why a file cannot be read, with their places.

use std::fmt;

use super::table::TableFault;

/// A place in a file: both counted from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FilePosition {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)
    }
}

/// Reason why nothing can be read from a file. Variants with a place name line and column.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// The file is larger than what is read.
    #[error("the file has {bytes} bytes; at most {most} are read")]
    TooLarge {
        /// Size of the file, bytes.
        bytes: usize,
        /// The most that is read, bytes.
        most: usize,
    },
    /// The file is of no format that is read.
    #[error(
        "{place}: unknown format, beginning with {found}; known are .mka, .mew, REXS, and tables of nodes or points"
    )]
    Unrecognised {
        /// Beginning of the file.
        place: FilePosition,
        /// First characters of the file.
        found: String,
    },
    /// Something other than what the format requires.
    #[error("{place}: expected {expected}, found {found}")]
    Expected {
        /// Place of what was found.
        place: FilePosition,
        /// Content that the format requires.
        expected: &'static str,
        /// Content that was found.
        found: String,
    },
    /// A trace has more or fewer values than its head says.
    #[error("{place}: {trace} announces {announced} values, found {found}{}",
        if *.found > *.announced { " or more" } else { "" })]
    ValueCount {
        /// Place at which the values of the trace begin or end.
        place: FilePosition,
        /// Name of the trace.
        trace: String,
        /// Values that its head announces.
        announced: usize,
        /// Values found.
        found: usize,
    },
    /// More entries than are read.
    #[error("{place}: more than {most} {what}")]
    TooMany {
        /// Place of the first one too many.
        place: FilePosition,
        /// Name of what is too many, as a plural.
        what: &'static str,
        /// The most that are read.
        most: usize,
    },
    /// Well-formed, but not what this reader understands: other units, a document type definition,
    /// a compressed file.
    #[error("{place}: {what}")]
    Unsupported {
        /// Place of what is not understood.
        place: FilePosition,
        /// Name of what is not understood.
        what: String,
    },
    /// A fault of the XML grammar.
    #[error("{place}: {detail}")]
    Xml {
        /// Place of the error.
        place: FilePosition,
        /// Description of the error.
        detail: String,
    },
    /// A table of nodes or points that cannot be read.
    #[error("{0}")]
    Table(Box<TableFault>),
    /// The model has no cylindrical gear.
    #[error("the model has no cylindrical gear")]
    NoGear,
    /// The model has several gears, and none was chosen.
    #[error("the model has several gears ({}); name one", .ids.join(", "))]
    SeveralGears {
        /// Identifiers of its gears.
        ids: Vec<String>,
    },
    /// The model has no gear of the identifier chosen.
    #[error("the model has no gear {id}; it has {}", .ids.join(", "))]
    NoSuchGear {
        /// The identifier chosen.
        id: String,
        /// Identifiers of its gears.
        ids: Vec<String>,
    },
}

impl FileError {
    /// Place of the error, if it has one.
    pub fn place(&self) -> Option<FilePosition> {
        match self {
            FileError::Unrecognised { place, .. }
            | FileError::Expected { place, .. }
            | FileError::ValueCount { place, .. }
            | FileError::TooMany { place, .. }
            | FileError::Unsupported { place, .. }
            | FileError::Xml { place, .. } => Some(*place),
            FileError::Table(fault) => {
                fault.places.first().map(|place| FilePosition { line: place.line, column: place.column })
            }
            FileError::Empty
            | FileError::TooLarge { .. }
            | FileError::NoGear
            | FileError::SeveralGears { .. }
            | FileError::NoSuchGear { .. } => None,
        }
    }
}

/// A piece of a file as a message shows it: quoted, and no longer than a glance.
pub(super) fn shown(text: &str) -> String {
    const MOST: usize = 40;
    let mut out: String = text.trim().chars().take(MOST).flat_map(char::escape_debug).collect();
    if out.is_empty() {
        return "nothing".into();
    }
    if text.trim().chars().nth(MOST).is_some() {
        out.push('…');
    }
    format!("“{out}”")
}
