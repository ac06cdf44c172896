//! Why a table cannot be read, and what was assumed of one that was.

use std::fmt;

use super::{Decimal, Layout, Meaning, Missing, Separator, Unit, words::words_of};
use flankfit_gear::Side;
use flankfit_numerics::fault::words::{are, counted};

/// A table that cannot be read: one reason, and the first places.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFault {
    /// Why.
    pub reason: TableReason,
    /// The first places, where there are any.
    pub places: Vec<TablePlace>,
}

impl TableFault {
    /// How many places are named.
    pub const MOST_PLACES: usize = 5;
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

/// Why a table cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub enum TableReason {
    /// No line has two numbers.
    NoNumbers,
    /// A line has more cells than are read.
    TooManyColumns {
        /// The most that are read.
        most: usize,
    },
    /// There are more cells than are read.
    TooManyCells {
        /// The most that are read.
        most: usize,
    },
    /// There are more flanks than are read.
    TooManyFlanks {
        /// The most that are read.
        most: usize,
    },
    /// Rows have another number of cells than there are columns.
    Cells {
        /// How many rows have the same wrong number of cells.
        rows: usize,
        /// How many cells each of these has.
        cells: usize,
        /// How many columns there are.
        columns: usize,
        /// How the table would have as many cells as columns.
        otherwise: Option<(Separator, Decimal)>,
    },
    /// Cells hold no numbers.
    NotNumbers {
        /// How many.
        cells: usize,
        /// How they would be numbers.
        otherwise: Option<(Separator, Decimal)>,
    },
    /// The mapping has another number of columns than the table.
    Mapped {
        /// Columns of the mapping.
        given: usize,
        /// Columns of the table.
        columns: usize,
    },
    /// Two columns have the same meaning.
    Repeated {
        /// Number of the second one, from 0.
        column: usize,
        /// The meaning.
        meaning: Meaning,
    },
    /// A column has a unit that does not belong to its meaning.
    ForeignUnit {
        /// Number of the column, from 0.
        column: usize,
        /// The meaning.
        meaning: Meaning,
        /// The unit.
        unit: Unit,
    },
    /// The header of a column names a unit that is not known.
    UnknownUnit {
        /// Number of the column, from 0.
        column: usize,
        /// The unit as the header has it.
        unit: String,
    },
    /// The columns make neither nodes nor points.
    Incomplete {
        /// Names or numbers of the columns.
        names: Vec<String>,
        /// What is missing.
        missing: Missing,
        /// Whether a mapping says what the columns are.
        mapped: bool,
    },
    /// The nodes lie otherwise than the mapping says.
    Layout {
        /// As the mapping says.
        wanted: Layout,
        /// As they do.
        found: Layout,
    },
    /// A word for a flank that is neither left nor right.
    UnknownFlank {
        /// Line, from 1.
        line: usize,
        /// The word.
        found: String,
    },
    /// A direction of a point that is zero.
    ZeroDirection {
        /// Line, from 1.
        line: usize,
    },
    /// Points were wanted and the table holds nodes, or the other way round.
    OtherContent {
        /// What the table holds.
        found: Layout,
    },
}

/// How the table would be read, and what to send for that.
fn write_hint(f: &mut fmt::Formatter<'_>, (separator, decimal): (Separator, Decimal), so: &str) -> fmt::Result {
    let (name, value) = match separator {
        Separator::Comma => ("commas", ","),
        Separator::Semicolon => ("semicolons", ";"),
        Separator::Tab => ("tabs", "tab"),
        Separator::Spaces => ("blanks", "spaces"),
    };
    match decimal {
        Decimal::Comma => write!(f, "; with decimal commas {so}: send `decimal: \",\"`"),
        Decimal::Point => write!(
            f,
            "; with {name} between columns and decimal points {so}: send `separator: \"{value}\"` and `decimal: \".\"`"
        ),
    }
}

impl fmt::Display for TableReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableReason::NoNumbers => write!(f, "no line of the table has two numbers"),
            TableReason::TooManyColumns { most } => write!(f, "a line has more than {most} cells"),
            TableReason::TooManyCells { most } => write!(f, "the table has more than {most} cells: send parts of it"),
            TableReason::TooManyFlanks { most } => {
                write!(f, "the table has nodes of more than {most} flanks: send parts of it, or map fewer columns")
            }
            TableReason::Cells { rows, cells, columns, otherwise } => {
                let have = if *rows == 1 { "has" } else { "have" };
                write!(
                    f,
                    "{} {have} {} for {}",
                    counted(*rows, "row", "rows"),
                    counted(*cells, "cell", "cells"),
                    counted(*columns, "column", "columns")
                )?;
                match otherwise {
                    Some(hint) => write_hint(f, *hint, &format!("they have {columns}")),
                    None if *cells == 2 * columns => write!(
                        f,
                        "; where the comma is separator and decimal sign nothing tells them apart: separate the columns by \
                         semicolons, or write decimal points"
                    ),
                    None => Ok(()),
                }
            }
            TableReason::NotNumbers { cells, otherwise } => {
                let numbers = if *cells == 1 { "a finite number" } else { "finite numbers" };
                write!(f, "{} {} not {numbers}", counted(*cells, "cell", "cells"), are(*cells))?;
                otherwise.map_or(Ok(()), |hint| write_hint(f, hint, "they are"))
            }
            TableReason::Mapped { given, columns } => write!(
                f,
                "the mapping has {} for {} of the table",
                counted(*given, "column", "columns"),
                counted(*columns, "column", "columns")
            ),
            TableReason::Repeated { meaning, .. } => {
                write!(f, "two columns are `{}`; make one of them `ignore`", meaning.name())
            }
            TableReason::ForeignUnit { meaning, unit, .. } => {
                let units = Unit::ALL.iter().filter(|(unit, _)| meaning.takes(*unit));
                let units: Vec<String> = units.map(|(_, name)| format!("`{name}`")).collect();
                let instead =
                    if units.is_empty() { "it has no unit".into() } else { format!("send {}", units.join(" or ")) };
                write!(f, "`{}` is not in `{}`; {instead}", meaning.name(), unit.name())
            }
            TableReason::UnknownUnit { column, unit } => {
                write!(
                    f,
                    "column {} is in `{unit}`, which is no known unit of it; convert it and send its `unit` as `mapping`",
                    column + 1
                )
            }
            TableReason::Incomplete { names, missing, .. } => {
                let names: Vec<String> = names.iter().take(12).map(|name| format!("`{name}`")).collect();
                write!(
                    f,
                    "the columns are {}: {missing}; say what they are as `columns` of `mapping`",
                    names.join(", ")
                )
            }
            TableReason::Layout { wanted, found } => {
                write!(f, "the table holds {}, not {}", what(*found), what(*wanted))
            }
            TableReason::UnknownFlank { line, found } => {
                let [left, right] = [Side::Left, Side::Right].map(words_of);
                write!(f, "line {line}: `{found}` is no flank; a left one is {left}, a right one {right}")
            }
            TableReason::ZeroDirection { line } => {
                write!(f, "line {line}: i, j, k are all zero, which is no direction")
            }
            TableReason::OtherContent { found } => write!(f, "the table holds {}", what(*found)),
        }
    }
}

fn what(layout: Layout) -> &'static str {
    match layout {
        Layout::Grid => "nodes on a grid",
        Layout::Scattered => "scattered nodes",
        Layout::Curve => "nodes of a curve",
        Layout::Points => "points",
    }
}

impl fmt::Display for TableFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.reason.fmt(f)?;
        self.places.iter().try_for_each(|place| write!(f, "; {place}"))
    }
}

/// What was assumed of a table, or left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TableNote {
    /// No header names the columns; they are taken by their number.
    MeaningAssumed {
        /// What they are taken for.
        meanings: Vec<Meaning>,
    },
    /// The header names no unit.
    UnitAssumed {
        /// Name of the column.
        name: String,
        /// The unit that is taken.
        unit: Unit,
    },
    /// A column is not read.
    ColumnIgnored {
        /// Name of the column.
        name: String,
    },
    /// Lines before the header are no part of the table.
    LinesLeftOut {
        /// How many.
        lines: usize,
    },
}

impl TableNote {
    /// Stable name.
    pub fn code(&self) -> &'static str {
        match self {
            TableNote::MeaningAssumed { .. } => "meaning_assumed",
            TableNote::UnitAssumed { .. } => "unit_assumed",
            TableNote::ColumnIgnored { .. } => "column_ignored",
            TableNote::LinesLeftOut { .. } => "lines_left_out",
        }
    }
}

impl fmt::Display for TableNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableNote::MeaningAssumed { meanings } => {
                let names: Vec<&str> = meanings.iter().map(|meaning| meaning.name()).collect();
                write!(f, "no header names the columns; they are taken for {}", names.join(", "))
            }
            TableNote::UnitAssumed { name, unit } => {
                write!(f, "the column `{name}` names no unit; `{}` is assumed", unit.name())
            }
            TableNote::ColumnIgnored { name } => write!(f, "the column `{name}` is not read"),
            TableNote::LinesLeftOut { lines } => {
                write!(f, "{} before the table left out", counted(*lines, "line is", "lines are"))
            }
        }
    }
}
