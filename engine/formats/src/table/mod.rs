//! Tables of nodes and of points: the one reader of CSV and of whatever else programs write with a
//! row per line.
//!
//! Separators are commas, semicolons, tabs or blanks; decimals have a point or a comma; cells may
//! be quoted. Lines that begin with `#`, `%`, `//`, `!` or `*` are comments, `[A]` begins a block.
//! A header names columns and units in any words; where it names none that is known, columns are
//! known by their number. A matrix has v in its first row, u in its first column and heights in
//! between. Whatever is not given in a [`Mapping`] is found from the content.

mod columns;
mod content;
mod crossings;
mod dialect;
mod fault;
mod head;
mod points;
mod reader;
mod rows;
mod terms;
mod words;

pub(super) use points::field;
pub(super) use reader::{looks_like_a_table, parse};
pub use {
    content::NodeSet,
    crossings::{Crossings, HelixSign},
    fault::{FlankFault, TableFault, TableNote, TablePlace},
    points::{ListedPoint, write_points},
    reader::{Table, read, shape},
    rows::MOST_COLUMNS,
    terms::{ColumnSpec, Decimal, Layout, Mapping, Missing, Separator, Shape},
    words::{Meaning, Unit},
};
