//! Reads tables.

use std::{
    borrow::Cow,
    collections::{BTreeMap, HashMap},
};

use super::{
    ColumnSpec, Decimal, Layout, Mapping, Meaning, Missing, Separator, Shape, TableFault, TableNote, TablePlace, Unit,
    columns::{self, Roles},
    fault::what,
    head::Head,
    rows::{Kind, Row, Rows, split, value},
};
use crate::{file_error::FileError, source::decode};
use flankfit_numerics::{
    cancel,
    words::{are, counted},
};

/// A table, read.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Separator of cells.
    pub separator: Separator,
    /// The decimal sign.
    pub decimal: Decimal,
    /// True if there is a header.
    pub header: bool,
    /// True if the table is a matrix.
    pub matrix: bool,
    /// The columns in their order; of a matrix first column, first row and heights.
    pub columns: Vec<ColumnSpec>,
    /// Assumptions, and parts that were left out.
    pub notes: Vec<TableNote>,
    /// Nodes or points that the columns form.
    pub(super) roles: Result<Roles, Missing>,
    /// Layout given by the mapping.
    pub(super) given_layout: Option<Layout>,
    /// True if the mapping says what the columns are.
    pub(super) mapped: bool,
    /// Line of each row, from 1.
    pub(super) lines: Vec<usize>,
    /// The cells, column by column.
    pub(super) cells: Vec<Cells>,
}

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cells {
    /// NaN where a cell is empty.
    Numbers(Vec<f64>),
    /// Numbers of distinct texts, and these.
    Texts(Vec<u32>, Vec<String>),
    Ignored,
}

/// Most cells that are read: two million nodes of a list, six of a matrix.
const MOST_CELLS: usize = 6_000_000;

/// Reads a table.
///
/// ```
/// use flankfit_formats::table::{self, Layout, Mapping, Meaning};
///
/// // Decimal commas and semicolons, as a German spreadsheet writes them.
/// let rows = "5,9;0,5;1,2\n5,9;1,5;-0,3\n6,1;0,5;0\n6,1;1,5;2\n";
/// let text = format!("Rollweg [mm];Breite [mm];Abweichung [µm]\n{rows}");
/// let table = table::read(text.as_bytes(), &Mapping::default())?;
/// assert_eq!(table.columns[0].meaning, Meaning::RollLength);
/// assert_eq!(table.layout(), Some(Layout::Grid));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(bytes: &[u8], mapping: &Mapping) -> Result<Table, FileError> {
    parse(&decode(bytes)?, mapping)
}

/// The form of a table; `None` where it cannot be read without a mapping.
pub fn shape(bytes: &[u8]) -> Option<Shape> {
    let text = decode(bytes).ok()?;
    let Head { separator, decimal, matrix, width, names, .. } = Head::of(&text, &Mapping::default()).ok()?;
    Some(Shape { separator, decimal, columns: if matrix { 3 } else { width }, names: names.unwrap_or_default() })
}

/// True if the first lines of a text are like those of a table.
pub(crate) fn looks_like_a_table(text: &str) -> bool {
    Head::of(text, &Mapping::default()).is_ok_and(|head| head.looks_like_a_table())
}

pub(crate) fn parse(text: &str, mapping: &Mapping) -> Result<Table, FileError> {
    let head = Head::of(text, mapping)?;
    let (columns, mut notes) = columns::of(&head, mapping)?;
    let roles = Roles::of(&columns);
    if head.left_out > 0 {
        notes.push(TableNote::LinesLeftOut { lines: head.left_out });
    }
    let mut table = Table {
        separator: head.separator,
        decimal: head.decimal,
        header: head.names.is_some() && !head.matrix,
        matrix: head.matrix,
        cells: columns
            .iter()
            .map(|column| match column.meaning {
                Meaning::Ignore => Cells::Ignored,
                meaning if meaning.is_number() => Cells::Numbers(Vec::new()),
                _ => Cells::Texts(Vec::new(), Vec::new()),
            })
            .collect(),
        columns,
        notes,
        roles,
        given_layout: mapping.layout,
        mapped: mapping.columns.is_some(),
        lines: Vec::new(),
    };
    let faults = if head.matrix { table.fill_matrix(text, &head) } else { table.fill(text, &head) };
    faults.into_result(&head, &table.columns, mapping)?;
    table.convert();
    if let (Some(wanted), Some(found)) = (mapping.layout, table.layout())
        && wanted != found
    {
        let message = format_args!("the table holds {}, not {}", what(found), what(wanted));
        return Err(TableFault::of_mapping("mapping.layout", message).into());
    }
    Ok(table)
}

/// Cells that cannot be read, counted, with the first places.
#[derive(Default)]
struct Faulty {
    /// Numbers of rows with another number of cells, by that number.
    rows: BTreeMap<usize, usize>,
    row_places: Vec<TablePlace>,
    numbers: usize,
    number_places: Vec<TablePlace>,
    /// Cells so far, and whether they are more than are read.
    cells: usize,
    too_many: bool,
}

impl Faulty {
    /// Counts cells; returns false where there are too many.
    fn count(&mut self, cells: usize) -> bool {
        self.cells += cells;
        self.too_many = self.cells > MOST_CELLS;
        !self.too_many
    }

    fn row(&mut self, row: Row<'_>, cells: &[Cow<'_, str>], width: usize) {
        *self.rows.entry(cells.len()).or_default() += 1;
        let column = cells.len().min(width).max(1);
        let found = cells.get(column - 1).map_or("", |cell| cell);
        push(&mut self.row_places, row.line, column, "", found);
    }

    fn cell(&mut self, line: usize, column: usize, name: &str, found: &str) {
        self.numbers += 1;
        push(&mut self.number_places, line, column, name, found);
    }

    fn into_result(self, head: &Head<'_>, columns: &[ColumnSpec], mapping: &Mapping) -> Result<(), TableFault> {
        if self.too_many {
            let message = format_args!("the table has more than {MOST_CELLS} cells: split it");
            return Err(TableFault::of_table(message));
        }
        let most = self.rows.iter().max_by_key(|(_, rows)| **rows).map(|(cells, rows)| (*cells, *rows));
        let (message, places, so) = match most {
            Some((cells, rows)) => {
                (row_message(rows, cells, head.width), self.row_places, format!("they have {}", head.width))
            }
            None if self.numbers > 0 => {
                let numbers = if self.numbers == 1 { "a finite number" } else { "finite numbers" };
                let cells = counted(self.numbers, "cell", "cells");
                let message = format!("{cells} {} not {numbers}", are(self.numbers));
                (message, self.number_places, "they are".to_owned())
            }
            None => return Ok(()),
        };
        let fault = match head.otherwise(columns) {
            Some(other) => {
                let (path, hint) = hint(other, &so, mapping);
                TableFault { path, ..TableFault::of_table(format_args!("{message}{hint}")) }
            }
            None if most.is_some_and(|(cells, _)| cells == 2 * head.width) => TableFault::of_table(format_args!(
                "{message}; a comma cannot be both separator and decimal sign: separate the columns by semicolons, or \
                 write decimal points"
            )),
            None => TableFault::of_table(message),
        };
        Err(TableFault { places, ..fault })
    }
}

/// The message of rows with another number of cells than there are columns.
fn row_message(rows: usize, cells: usize, columns: usize) -> String {
    let have = if rows == 1 { "has" } else { "have" };
    let (rows, cells) = (counted(rows, "row", "rows"), counted(cells, "cell", "cells"));
    format!("{rows} {have} {cells} for {}", counted(columns, "column", "columns"))
}

/// Other dialect in which the table can be read, the members to send for it, and the path of the
/// one that contradicts it in `mapping`.
fn hint((separator, decimal): (Separator, Decimal), so: &str, mapping: &Mapping) -> (Option<String>, String) {
    let (name, value) = match separator {
        Separator::Comma => ("commas", ","),
        Separator::Semicolon => ("semicolons", ";"),
        Separator::Tab => ("tabs", "tab"),
        Separator::Spaces => ("blanks", "spaces"),
    };
    let mut hint = match decimal {
        Decimal::Comma => format!("; with decimal commas {so}: send `decimal: \",\"`"),
        Decimal::Point => format!(
            "; with {name} between columns and decimal points {so}: send `separator: \"{value}\"` and `decimal: \".\"`"
        ),
    };
    let path = if mapping.separator.is_some_and(|given| given != separator) {
        if decimal == Decimal::Comma {
            hint.push_str(" and leave out `separator`");
        }
        Some("mapping.separator")
    } else {
        mapping.decimal.is_some_and(|given| given != decimal).then_some("mapping.decimal")
    };
    (path.map(str::to_owned), hint)
}

fn push(places: &mut Vec<TablePlace>, line: usize, column: usize, name: &str, found: &str) {
    if places.len() < TableFault::MOST_PLACES {
        let found = found.chars().take(40).collect();
        places.push(TablePlace { line, column, name: name.to_owned(), found });
    }
}

impl Table {
    /// Reads the rows of a list.
    fn fill(&mut self, text: &str, head: &Head<'_>) -> Faulty {
        let mut faults = Faulty::default();
        let mut names = vec![HashMap::<String, u32>::new(); self.columns.len()];
        let mut cells = Vec::new();
        let mut block = None;
        // an empty height is a missing node; a direction may not have been measured
        let (height, direction) = match &self.roles {
            Ok(Roles::Surface { height, .. } | Roles::Curve { height, .. }) => (Some(*height), None),
            Ok(Roles::Points { direction, .. }) => (None, *direction),
            Err(_) => (None, None),
        };
        for kind in Rows::new(text) {
            let row = match kind {
                Kind::Comment(_) => continue,
                Kind::Block(name) => {
                    block = Some(name);
                    continue;
                }
                Kind::Cells(row) => row,
            };
            if row.line < head.first_line || head.is_header(row.text) {
                continue;
            }
            cancel::every(10, row.line);
            split(row.text, head.separator, &mut cells);
            if !faults.count(cells.len()) {
                break;
            }
            if !head.fit(&mut cells) {
                faults.row(row, &cells, head.width);
                continue;
            }
            let empty = |column: usize| cells[column].is_empty();
            let missing = height.is_some_and(empty);
            let without = direction.is_some_and(|direction| direction.into_iter().all(empty));
            for (column, spec) in self.columns.iter().enumerate() {
                let cell = &cells[column];
                match &mut self.cells[column] {
                    Cells::Ignored => {}
                    Cells::Texts(of_rows, texts) => {
                        let whole: Cow<'_, str> = match (spec.meaning, block) {
                            (Meaning::Id, Some(block)) => format!("{block} {cell}").into(),
                            _ => Cow::Borrowed(cell.as_ref()),
                        };
                        let number = names[column].get(whole.as_ref()).copied().unwrap_or_else(|| {
                            let number = u32::try_from(texts.len()).unwrap_or(u32::MAX);
                            texts.push(whole.clone().into_owned());
                            names[column].insert(whole.into_owned(), number);
                            number
                        });
                        of_rows.push(number);
                    }
                    Cells::Numbers(numbers) => match value(cell, head.decimal) {
                        Some(number) => numbers.push(number),
                        None => {
                            let may_be_empty = Some(column) == height
                                || (missing && spec.meaning == Meaning::Weight)
                                || (without && direction.is_some_and(|direction| direction.contains(&column)));
                            if !(cell.is_empty() && may_be_empty) {
                                faults.cell(row.line, column + 1, &spec.name, cell);
                            }
                            numbers.push(f64::NAN);
                        }
                    },
                }
            }
            self.lines.push(row.line);
        }
        faults
    }

    /// Reads the rows of a matrix as those of a list.
    fn fill_matrix(&mut self, text: &str, head: &Head<'_>) -> Faulty {
        let mut faults = Faulty::default();
        let mut cells = Vec::new();
        let mut across = Vec::new();
        let mut columns = [Vec::new(), Vec::new(), Vec::new()];
        for kind in Rows::new(text) {
            let Kind::Cells(row) = kind else { continue };
            if row.line < head.first_line {
                continue;
            }
            cancel::every(10, row.line);
            split(row.text, head.separator, &mut cells);
            if !faults.count(cells.len()) {
                break;
            }
            if row.line == head.first_line && cells.len() + 1 == head.width {
                // without a corner
                cells.insert(0, Cow::Borrowed(""));
            }
            if !head.fit(&mut cells) {
                faults.row(row, &cells, head.width);
                continue;
            }
            let mut number = |column: usize| {
                value(&cells[column], head.decimal).unwrap_or_else(|| {
                    faults.cell(row.line, column + 1, "", &cells[column]);
                    f64::NAN
                })
            };
            if row.line == head.first_line {
                across = (1..head.width).map(number).collect();
                continue;
            }
            let along = number(0);
            for (column, v) in (1..).zip(&across) {
                let height = if cells[column].is_empty() { f64::NAN } else { number(column) };
                for (list, x) in columns.iter_mut().zip([along, *v, height]) {
                    list.push(x);
                }
                self.lines.push(row.line);
            }
        }
        self.cells = columns.into_iter().map(Cells::Numbers).collect();
        faults
    }

    /// Roll angles in radians become degrees, the only unit of the service with no name for them.
    fn convert(&mut self) {
        for (spec, cells) in self.columns.iter().zip(&mut self.cells) {
            if let (Some(Unit::Radian), Cells::Numbers(numbers)) = (spec.unit, cells) {
                numbers.iter_mut().for_each(|x| *x = x.to_degrees());
            }
        }
    }
}
