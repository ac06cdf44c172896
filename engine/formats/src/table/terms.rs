//! Terms of a table: its dialect and the meaning of its columns.

use std::fmt;

use super::words::{Meaning, Unit};

/// Separator of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = TableSeparator)
)]
pub enum Separator {
    /// `,`
    #[cfg_attr(feature = "contract", serde(rename = ","))]
    Comma,
    /// `;`
    #[cfg_attr(feature = "contract", serde(rename = ";"))]
    Semicolon,
    /// A tab.
    Tab,
    /// Any number of blanks and tabs.
    Spaces,
}

impl Separator {
    /// The character; `None` for blanks.
    pub fn mark(self) -> Option<char> {
        match self {
            Separator::Comma => Some(','),
            Separator::Semicolon => Some(';'),
            Separator::Tab => Some('\t'),
            Separator::Spaces => None,
        }
    }
}

/// The decimal sign of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TableDecimal)
)]
pub enum Decimal {
    /// `.`
    #[cfg_attr(feature = "contract", serde(rename = "."))]
    Point,
    /// `,`
    #[cfg_attr(feature = "contract", serde(rename = ","))]
    Comma,
}

/// Layout of the nodes of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = TableLayout)
)]
pub enum Layout {
    /// On the crossings of a few u and v; crossings may be missing.
    Grid,
    /// Anywhere on a surface.
    Scattered,
    /// Along a curve.
    Curve,
    /// Points in space.
    Points,
}

/// A column, or of a matrix its first column, its first row or its heights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnSpec {
    /// Name in the header; empty without a header.
    pub name: String,
    /// Meaning of the column.
    pub meaning: Meaning,
    /// Its unit, where it has one.
    pub unit: Option<Unit>,
}

/// Known properties of a table; everything else is found from its content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mapping {
    /// Separator of cells.
    pub separator: Option<Separator>,
    /// The decimal sign.
    pub decimal: Option<Decimal>,
    /// True if a line with names comes before the numbers.
    pub header: Option<bool>,
    /// True if the table is a matrix: v in the first row, u in the first column, heights in
    /// between.
    pub matrix: Option<bool>,
    /// The columns in their order; of a matrix first column, first row and heights.
    pub columns: Option<Vec<ColumnSpec>>,
    /// Layout of the nodes.
    pub layout: Option<Layout>,
}

/// The form of a table as it is read without a mapping: the same for tables that a program writes
/// alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Separator of cells.
    pub separator: Separator,
    /// The decimal sign.
    pub decimal: Decimal,
    /// Number of columns: of a matrix three, since its rows are as long as it has v.
    pub columns: usize,
    /// The header, or the corner of a matrix; empty without one.
    pub names: Vec<String>,
}

/// Columns that are missing for nodes or points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Missing {
    /// None is known.
    All,
    /// No column with heights.
    Height,
    /// No column with a place.
    Place,
    /// Some of i, j and k, but not all.
    Direction,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Missing::All => "their meaning is not known",
            Missing::Height => "none of them has heights (`deviation`; `z` with u and v, `y` with x)",
            Missing::Place => "none of them has the places of the heights on the flank",
            Missing::Direction => "give all of i, j and k or none",
        })
    }
}
