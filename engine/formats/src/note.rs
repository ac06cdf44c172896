//! Notes of a reader on a file.

use flankfit_numerics::{warnings, words::Shown};

warnings! {
/// Remark on a line.
pub enum Remark {
    /// Lines of no known block: the first, and how many follow it.
    #[error("the line {first}{} fits no known block", more(*.following))]
    "unknown_block" => UnknownBlock { first: String, following: usize },
    /// A line among results that is none.
    #[error("the line {0} is not a result")]
    "unknown_block" => NoResult(String),
    /// A header code again.
    #[error("header code {0} occurs here again")]
    "repeated_code" => RepeatedCode(u32),
    /// A result code again.
    #[error("the result {0} occurs here again")]
    "repeated_result" => RepeatedResult(u32),
    /// The unit of angles.
    #[error("angles are “{0}”; only decimal degrees are read from the header")]
    "angles_not_decimal" => AnglesNotDecimal(String),
    /// A number that no double holds.
    #[error("“{0}” exceeds the range of double precision; it is ignored")]
    "unknown_setting" => ExceedsDouble(String),
    /// A separator of more than one sign.
    #[error("the separator is not one character but “{0}”; a colon is used")]
    "unknown_setting" => Separator(String),
    /// The mark of undefined points is no number; this one is taken.
    #[error("the mark “{mark}” of undefined points is not a number; {taken} is used")]
    "unknown_setting" => UndefinedMark { mark: String, taken: f64 },
    /// A header value that is no number.
    #[error("header code {code}: “{found}” is not a number; it is ignored")]
    "value_not_read" => ValueNotRead { code: u32, found: String },
    /// A header value in another unit.
    #[error("header code {code}: values in “{unit}” are ignored, only {wanted} is known")]
    "unit_not_known" => UnitNotKnown { code: u32, unit: String, wanted: &'static str },
    /// The profile shift and the tooth thickness contradict each other.
    #[error(
        "the profile shift coefficient {} (code 25) and {figure} = {} mm contradict each other: x_E = {given:.4} \
         follows from {figure}",
        Shown(*.header), Shown(*.value)
    )]
    "profile_shift_contradicted" => ProfileShiftContradicted {
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
    "count_not_given" => CountNotGiven(String),
    /// The code of a result and its label name different flanks.
    #[error("result {0} belongs to the other flank than its label says")]
    "side_disagrees" => SideDisagrees(u32),
    /// Left and right flank have different values where a gear has one.
    #[error("left and right flank of gear {gear} have different {figures}; none is used")]
    "flanks_differ" => FlanksDiffer { gear: String, figures: &'static str },
    /// The order of a grid's values.
    #[error("the order of the topography's amounts is not given; coordinates are assumed to run fastest")]
    "order_assumed" => OrderAssumed,
    /// Points without a grid.
    #[error("the points of the topography do not form a grid")]
    "not_a_grid" => NotAGrid,
    /// No gear.
    #[error("the model has no cylindrical gear and no ring gear")]
    "no_cylindrical_gear" => NoCylindricalGear,
    /// A flank that is omitted.
    #[error("the {side} flank of gear {gear}, component {flank}, has an unknown type; it is omitted")]
    "flank_not_read" => FlankNotRead { side: &'static str, gear: String, flank: String },
}
}

fn more(following: usize) -> String {
    if following == 0 { String::new() } else { format!(" and {following} more") }
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
