//! What a reader has to say about a file that it could read all the same.

use thiserror::Error;

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

/// What there is to say of a line.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Remark {
    /// Lines of no known block: the first, and how many follow it.
    #[error("the line {first}{} fits no known block", more(*.following))]
    UnknownBlock {
        /// Its text, shortened.
        first: String,
        /// Lines behind it.
        following: usize,
    },
    /// A line among results that is none.
    #[error("the line {0} is no result")]
    NoResult(String),
    /// A header code again.
    #[error("header code {0} stands here again")]
    RepeatedCode(u32),
    /// A result code again.
    #[error("the result {0} stands here again")]
    RepeatedResult(u32),
    /// The unit of angles.
    #[error("angles are “{0}”; only decimal degrees are taken from the header")]
    AnglesNotDecimal(String),
    /// A number that no double holds.
    #[error("“{0}” is beyond the numbers that there are; it is not taken")]
    BeyondDouble(String),
    /// A separator of more than one sign.
    #[error("the separator is not one sign but “{0}”; a colon is taken")]
    Separator(String),
    /// The mark of undefined points is no number; this one is taken.
    #[error("undefined points are marked by “{mark}”, no number; {taken} is taken")]
    UndefinedMark {
        /// As it stands there.
        mark: String,
        /// The number that is taken.
        taken: f64,
    },
    /// A trace of this tooth without its number of values.
    #[error("the trace of tooth {0} does not say how many values it has")]
    CountNotGiven(String),
    /// The code of a result and its label name different flanks.
    #[error("result {0} belongs to the other flank than its label says")]
    SideDisagrees(u32),
    /// Left and right flank have different values where a gear has one.
    #[error("left and right flank of gear {gear} have different {figures}; none is taken")]
    FlanksDiffer {
        /// The gear's name, shortened.
        gear: String,
        /// What differs, in the plural.
        figures: &'static str,
    },
    /// The order of a grid's values.
    #[error("the order of the topography's amounts is not said; coordinates are taken to run fastest")]
    OrderAssumed,
    /// Points without a grid.
    #[error("the points of the topography fill no grid")]
    NotAGrid,
}

fn more(following: usize) -> String {
    if following == 0 { String::new() } else { format!(" and {following} more") }
}

impl Remark {
    /// Why it is made.
    pub fn code(&self) -> NoteCode {
        match self {
            Remark::UnknownBlock { .. } | Remark::NoResult(_) => NoteCode::UnknownBlock,
            Remark::RepeatedCode(_) => NoteCode::RepeatedCode,
            Remark::RepeatedResult(_) => NoteCode::RepeatedResult,
            Remark::AnglesNotDecimal(_) => NoteCode::AnglesNotDecimal,
            Remark::BeyondDouble(_) | Remark::Separator(_) | Remark::UndefinedMark { .. } => NoteCode::UnknownSetting,
            Remark::CountNotGiven(_) => NoteCode::CountNotGiven,
            Remark::SideDisagrees(_) => NoteCode::SideDisagrees,
            Remark::FlanksDiffer { .. } => NoteCode::FlanksDiffer,
            Remark::OrderAssumed => NoteCode::OrderAssumed,
            Remark::NotAGrid => NoteCode::NotAGrid,
        }
    }
}

/// A remark about a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// From 1.
    pub line: usize,
    /// What there is to say of it.
    pub remark: Remark,
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
    pub(super) fn push(&mut self, line: usize, remark: Remark) {
        self.count += 1;
        if self.list.len() < Self::MOST {
            self.list.push(Note { line, remark });
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
