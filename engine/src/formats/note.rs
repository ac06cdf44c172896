//! What a reader has to say about a file that it could read all the same.

/// Why a note stands there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NoteCode {
    /// Lines of a block that is not known; they are not among the data.
    UnknownBlock,
    /// A header code that stands there twice; both lines are kept, the first one counts.
    RepeatedCode,
    /// A result code that stands there twice; both are kept.
    RepeatedResult,
    /// Angles are not decimal degrees, so none is taken from the header.
    AnglesNotDecimal,
    /// A setting with a value of no known meaning.
    UnknownSetting,
    /// A trace without its number of values: those up to the next text are taken.
    CountNotGiven,
    /// A label and its code say different sides; the code counts.
    SideDisagrees,
    /// Left and right flank have different values where a gear has one.
    FlanksDiffer,
    /// The order of a grid's values had to be assumed.
    OrderAssumed,
    /// Data that have no place on a grid.
    NotAGrid,
}

impl NoteCode {
    /// The stable name.
    pub fn as_str(self) -> &'static str {
        match self {
            NoteCode::UnknownBlock => "unknown_block",
            NoteCode::RepeatedCode => "repeated_code",
            NoteCode::RepeatedResult => "repeated_result",
            NoteCode::AnglesNotDecimal => "angles_not_decimal",
            NoteCode::UnknownSetting => "unknown_setting",
            NoteCode::CountNotGiven => "count_not_given",
            NoteCode::SideDisagrees => "side_disagrees",
            NoteCode::FlanksDiffer => "flanks_differ",
            NoteCode::OrderAssumed => "order_assumed",
            NoteCode::NotAGrid => "not_a_grid",
        }
    }
}

/// A remark about a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Stable code.
    pub code: NoteCode,
    /// From 1.
    pub line: usize,
    /// The same in words.
    pub text: String,
}

/// The remarks about a file: the first ones, and how many there were.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    list: Vec<Note>,
    count: usize,
}

impl Notes {
    /// How many notes are kept; a file of garbage must not grow with its remarks.
    pub const MOST: usize = 100;

    /// Adds a note.
    pub(super) fn push(&mut self, code: NoteCode, line: usize, text: impl Into<String>) {
        self.count += 1;
        if self.list.len() < Self::MOST {
            self.list.push(Note { code, line, text: text.into() });
        }
    }

    /// The notes kept, in the order of the file.
    pub fn list(&self) -> &[Note] {
        &self.list
    }

    /// How many there were.
    pub fn count(&self) -> usize {
        self.count
    }
}
