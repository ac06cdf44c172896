//! Notes of a reader on a file.

use thiserror::Error;

use flankfit_numerics::words::Shown;

/// Reason of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NoteCode {
    /// Lines of a block that is not known; they are not among the data.
    UnknownBlock,
    /// A header code that occurs twice; both lines are kept, the first one counts.
    RepeatedCode,
    /// A result code that occurs twice; both are kept.
    RepeatedResult,
    /// Angles are not decimal degrees, so none is taken from the header.
    AnglesNotDecimal,
    /// A setting with a value of no known meaning.
    UnknownSetting,
    /// A header value that cannot be read as a number; it is not taken.
    ValueNotRead,
    /// A header value in a unit that is not known; it is not taken.
    UnitNotKnown,
    /// The profile shift of the header and a tooth thickness of the same file belong to different
    /// gears.
    ProfileShiftContradicted,
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
    /// A model without a gear that is read.
    NoCylindricalGear,
    /// A flank of a gear whose component type is not supported.
    FlankNotRead,
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
            NoteCode::ValueNotRead => "value_not_read",
            NoteCode::UnitNotKnown => "unit_not_known",
            NoteCode::ProfileShiftContradicted => "profile_shift_contradicted",
            NoteCode::CountNotGiven => "count_not_given",
            NoteCode::SideDisagrees => "side_disagrees",
            NoteCode::FlanksDiffer => "flanks_differ",
            NoteCode::OrderAssumed => "order_assumed",
            NoteCode::NotAGrid => "not_a_grid",
            NoteCode::NoCylindricalGear => "no_cylindrical_gear",
            NoteCode::FlankNotRead => "flank_not_read",
        }
    }
}

/// Remark on a line.
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
    #[error("header code {0} occurs here again")]
    RepeatedCode(u32),
    /// A result code again.
    #[error("the result {0} occurs here again")]
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
        /// Text as it is in the file.
        mark: String,
        /// The number that is taken.
        taken: f64,
    },
    /// A header value that is no number.
    #[error("header code {code}: “{found}” is not a number; it is not taken")]
    ValueNotRead {
        /// Code of the line.
        code: u32,
        /// The value as found.
        found: String,
    },
    /// A header value in another unit.
    #[error("header code {code}: values in “{unit}” are not taken, only in {wanted}")]
    UnitNotKnown {
        /// Code of the line.
        code: u32,
        /// The unit in the label.
        unit: String,
        /// The unit that is read.
        wanted: &'static str,
    },
    /// The profile shift and the tooth thickness contradict each other.
    #[error(
        "the profile shift coefficient {} (code 25) and {figure} = {} mm contradict each other: x_E = {given:.4} \
         follows from {figure}",
        Shown(*.header), Shown(*.value)
    )]
    ProfileShiftContradicted {
        /// x of the header.
        header: f64,
        /// `W_k` or `M_dK`.
        figure: &'static str,
        /// The measured or prescribed figure, mm.
        value: f64,
        /// x_E that follows from it.
        given: f64,
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
        /// Differing quantities, in the plural.
        figures: &'static str,
    },
    /// The order of a grid's values.
    #[error("the order of the topography's amounts is not given; coordinates are taken to run fastest")]
    OrderAssumed,
    /// Points without a grid.
    #[error("the points of the topography fill no grid")]
    NotAGrid,
    /// No gear.
    #[error("the model has no cylindrical gear and no ring gear")]
    NoCylindricalGear,
    /// A flank that is omitted.
    #[error("the {side} flank of gear {gear}, component {flank}, is of no type that is read; it is left out")]
    FlankNotRead {
        /// Its role.
        side: &'static str,
        /// The gear's component, shortened.
        gear: String,
        /// The flank's component, shortened.
        flank: String,
    },
}

fn more(following: usize) -> String {
    if following == 0 { String::new() } else { format!(" and {following} more") }
}

impl Remark {
    /// Code of the remark.
    pub fn code(&self) -> NoteCode {
        match self {
            Remark::UnknownBlock { .. } | Remark::NoResult(_) => NoteCode::UnknownBlock,
            Remark::RepeatedCode(_) => NoteCode::RepeatedCode,
            Remark::RepeatedResult(_) => NoteCode::RepeatedResult,
            Remark::AnglesNotDecimal(_) => NoteCode::AnglesNotDecimal,
            Remark::BeyondDouble(_) | Remark::Separator(_) | Remark::UndefinedMark { .. } => NoteCode::UnknownSetting,
            Remark::ValueNotRead { .. } => NoteCode::ValueNotRead,
            Remark::UnitNotKnown { .. } => NoteCode::UnitNotKnown,
            Remark::ProfileShiftContradicted { .. } => NoteCode::ProfileShiftContradicted,
            Remark::CountNotGiven(_) => NoteCode::CountNotGiven,
            Remark::SideDisagrees(_) => NoteCode::SideDisagrees,
            Remark::FlanksDiffer { .. } => NoteCode::FlanksDiffer,
            Remark::OrderAssumed => NoteCode::OrderAssumed,
            Remark::NotAGrid => NoteCode::NotAGrid,
            Remark::NoCylindricalGear => NoteCode::NoCylindricalGear,
            Remark::FlankNotRead { .. } => NoteCode::FlankNotRead,
        }
    }
}

/// A remark about a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// From 1.
    pub line: usize,
    /// Remark on the line.
    pub remark: Remark,
}

/// The remarks about a file: the first ones, and how many there were.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    list: Vec<Note>,
    count: usize,
}

impl Notes {
    /// Number of notes that are kept; a file of garbage must not grow with its remarks.
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

    /// Number of notes that were made.
    pub fn count(&self) -> usize {
        self.count
    }
}
