//! Why a file cannot be read, and where.

use std::fmt;

/// A place in a file: both counted from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FilePosition {
    pub line: usize,
    pub column: usize,
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)
    }
}

/// Why nothing can be read from a file. Whatever has a place in it names line and column.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    #[error("the file is empty")]
    Empty,
    #[error("the file has {bytes} bytes; at most {most} are read")]
    TooLarge { bytes: usize, most: usize },
    #[error(
        "{place}: this is none of the formats that are read (.mka, .mew, REXS, points as CSV); it begins with {found}"
    )]
    Unrecognised { place: FilePosition, found: String },
    /// Something else stands where the format has one thing.
    #[error("{place}: expected {expected}, found {found}")]
    Expected { place: FilePosition, expected: &'static str, found: String },
    /// A trace has more or fewer values than its head says.
    #[error("{place}: {trace} announces {announced} values, found {found}{}",
        if *.found > *.announced { " or more" } else { "" })]
    ValueCount { place: FilePosition, trace: String, announced: usize, found: usize },
    #[error("{place}: more than {most} {what}")]
    TooMany { place: FilePosition, what: &'static str, most: usize },
    /// Well-formed, but not what this reader understands: other units, a document type definition,
    /// a compressed file.
    #[error("{place}: {what}")]
    Unsupported { place: FilePosition, what: String },
    /// A fault of the XML grammar.
    #[error("{place}: {detail}")]
    Xml { place: FilePosition, detail: String },
    #[error("the model has no cylindrical gear")]
    NoGear,
    #[error("the model has several gears ({}); say which", .ids.join(", "))]
    SeveralGears { ids: Vec<String> },
    #[error("the model has no gear {id}; it has {}", .ids.join(", "))]
    NoSuchGear { id: String, ids: Vec<String> },
}

impl FileError {
    /// Where the fault is, if it is anywhere.
    pub fn place(&self) -> Option<FilePosition> {
        match self {
            FileError::Unrecognised { place, .. }
            | FileError::Expected { place, .. }
            | FileError::ValueCount { place, .. }
            | FileError::TooMany { place, .. }
            | FileError::Unsupported { place, .. }
            | FileError::Xml { place, .. } => Some(*place),
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
