//! The shape of a table, from its first lines: how it is written, its header, its width, and where
//! the numbers begin.

use std::{borrow::Cow, collections::BTreeMap};

use super::{
    ColumnSpec, Decimal, MOST_COLUMNS, Mapping, Separator, TableFault, Unit, dialect,
    rows::{Kind, Row, Rows, split, value},
    words::meaning_of,
};
use crate::file_error::FileError;

/// Rows that are looked at.
const SAMPLE: usize = 1000;
/// Their text, bytes, from the third row on.
const SAMPLE_BYTES: usize = 1 << 18;
/// Characters of a name in the header that are kept.
const LONGEST_NAME: usize = 200;

pub(super) struct Head<'a> {
    pub separator: Separator,
    pub decimal: Decimal,
    pub matrix: bool,
    /// Columns; of a matrix with that of u.
    pub width: usize,
    /// Names of the header; of a matrix that of its corner.
    pub names: Option<Vec<String>>,
    /// Units in a line of their own.
    pub units: Option<Vec<Option<Unit>>>,
    /// First line with numbers.
    pub first_line: usize,
    /// Lines before the table.
    pub left_out: usize,
    /// The first rows.
    pub sample: Vec<Row<'a>>,
    header: Option<&'a str>,
}

/// Numbers of cells of a line by kind.
#[derive(Clone, Copy)]
struct Counts {
    cells: usize,
    numbers: usize,
    texts: usize,
    /// Cells up to the last that is not empty.
    filled: usize,
}

impl Counts {
    fn is_data(&self) -> bool {
        self.numbers >= 2 || (self.numbers == 1 && self.texts == 0)
    }
}

fn counts(cells: &[Cow<'_, str>], decimal: Decimal) -> Counts {
    let numbers = cells.iter().filter(|cell| value(cell, decimal).is_some()).count();
    let empty = cells.iter().filter(|cell| cell.is_empty()).count();
    let filled = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
    Counts { cells: cells.len(), numbers, texts: cells.len() - empty - numbers, filled }
}

fn cells_of(text: &str, separator: Separator) -> Vec<Cow<'_, str>> {
    let mut cells = Vec::new();
    split(text, separator, &mut cells);
    cells
}

/// Number of cells with known names.
fn known(cells: &[Cow<'_, str>]) -> usize {
    cells.iter().filter(|cell| meaning_of(cell).is_some()).count()
}

impl<'a> Head<'a> {
    pub(super) fn of(text: &'a str, mapping: &Mapping) -> Result<Self, FileError> {
        let (mut sample, mut comments) = (Vec::new(), Vec::new());
        let mut separator = mapping.separator;
        let mut bytes = 0;
        for kind in Rows::new(text) {
            match kind {
                Kind::Comment(row) if comments.len() < SAMPLE => comments.push(row),
                Kind::Cells(row) => {
                    // line with which Excel is given the separator
                    let mark = row.text.trim().strip_prefix("sep=").filter(|_| sample.is_empty());
                    match mark.and_then(|mark| mark.chars().next()) {
                        Some(';') => separator = separator.or(Some(Separator::Semicolon)),
                        Some(',') => separator = separator.or(Some(Separator::Comma)),
                        Some('\t') => separator = separator.or(Some(Separator::Tab)),
                        _ => {
                            bytes += row.text.len();
                            sample.push(row);
                        }
                    }
                }
                Kind::Comment(_) | Kind::Block(_) => {}
            }
            if sample.len() == SAMPLE || (sample.len() > 2 && bytes > SAMPLE_BYTES) {
                break;
            }
        }
        let (separator, decimal) = dialect::detect(&sample, separator, mapping.decimal);
        let mut head = Head {
            separator,
            decimal,
            matrix: false,
            width: 0,
            names: None,
            units: None,
            first_line: usize::MAX,
            left_out: 0,
            sample,
            header: None,
        };
        head.find(&comments, mapping)?;
        for name in head.names.iter_mut().flatten() {
            let end = name.char_indices().nth(LONGEST_NAME).map_or(name.len(), |(end, _)| end);
            name.truncate(end);
        }
        Ok(head)
    }

    fn find(&mut self, comments: &[Row<'a>], mapping: &Mapping) -> Result<(), FileError> {
        let all: Vec<Counts> =
            self.sample.iter().map(|row| counts(&cells_of(row.text, self.separator), self.decimal)).collect();
        if all.iter().any(|counts| counts.cells > MOST_COLUMNS) {
            return Err(TableFault::of_table(format_args!("a line has more than {MOST_COLUMNS} cells")).into());
        }
        let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
        for counts in all.iter().filter(|counts| counts.is_data() && counts.cells >= 2) {
            *lengths.entry(counts.cells).or_default() += 1;
        }
        let length = lengths.iter().max_by_key(|(_, rows)| **rows).map(|(length, _)| *length);
        let found = length.and_then(|length| {
            let first = all.iter().position(|counts| counts.is_data() && counts.cells == length)?;
            let filled = all.iter().filter(|counts| counts.cells == length && counts.is_data());
            Some((first, filled.map(|counts| counts.filled).max()?))
        });
        let Some((first, width)) = found else { return self.without_numbers(mapping) };
        self.width = width;
        if mapping.matrix != Some(false) && self.is_matrix(first, &all, mapping.matrix == Some(true)) {
            return Ok(());
        }
        self.first_line = self.sample[first].line;
        self.left_out = first;
        if mapping.header == Some(false) {
            return Ok(());
        }
        let given = mapping.header == Some(true);
        if given && first == 0 {
            // numbers may be names
            self.header = Some(self.sample[0].text.trim());
            self.first_line = self.sample.get(1).map_or(self.first_line + 1, |row| row.line);
            let names = cells_of(self.sample[0].text, self.separator).into_iter().map(Cow::into_owned);
            self.names = Some(names.take(self.width).collect());
            return Ok(());
        }
        let mut before = first;
        if before >= 2 {
            let cells = cells_of(self.sample[before - 1].text, self.separator);
            let units: Vec<Option<Unit>> = cells.iter().map(|cell| Unit::of_word(cell)).collect();
            let each = cells
                .iter()
                .zip(&units)
                .all(|(cell, unit)| cell.trim_matches(['[', ']', '-']).is_empty() || unit.is_some());
            if each && units.iter().any(Option::is_some) {
                self.units = Some(units);
                before -= 1;
            }
        }
        if before > 0 && self.takes_header(self.sample[before - 1], length.unwrap_or(width), given) {
            self.left_out = before - 1;
            self.header = Some(self.sample[before - 1].text.trim());
        } else if let Some(comment) = comments.iter().rfind(|comment| comment.line < self.first_line) {
            // a header behind a mark for comments
            let names = cells_of(comment.text, self.separator);
            if names.len() == self.width && known(&names) >= 2 {
                self.names = Some(names.into_iter().map(Cow::into_owned).collect());
            }
        }
        Ok(())
    }

    /// A header without numbers behind it.
    fn without_numbers(&mut self, mapping: &Mapping) -> Result<(), FileError> {
        let Some(row) = self.sample.first().copied() else { return Err(FileError::Empty) };
        let each = [self.separator, Separator::Semicolon, Separator::Comma, Separator::Tab, Separator::Spaces];
        let free = mapping.separator.is_none();
        for separator in each.into_iter().take(if free { 5 } else { 1 }) {
            let cells = cells_of(row.text, separator);
            if known(&cells) >= 2 {
                self.separator = separator;
                self.width = counts(&cells, self.decimal).filled;
                self.names = Some(cells.into_iter().take(self.width).map(Cow::into_owned).collect());
                self.first_line = row.line + 1;
                self.header = Some(row.text.trim());
                return Ok(());
            }
        }
        Err(TableFault::of_table("no line of the table has two numbers").into())
    }

    /// Takes a line for the header if it is one. It may be separated otherwise than the numbers.
    fn takes_header(&mut self, row: Row<'a>, length: usize, given: bool) -> bool {
        for separator in [self.separator, Separator::Semicolon, Separator::Comma, Separator::Tab, Separator::Spaces] {
            let cells = cells_of(row.text, separator);
            let counts = counts(&cells, self.decimal);
            let fits = counts.cells == length || counts.filled == self.width;
            let is_header = counts.numbers == 0 && counts.texts >= self.width.min(2) && (fits || known(&cells) >= 2);
            if is_header || (given && separator == self.separator) {
                if !fits {
                    self.width = counts.filled;
                }
                self.width = self.width.max(counts.filled);
                let mut names: Vec<String> = cells.into_iter().map(Cow::into_owned).collect();
                names.resize(self.width, String::new());
                self.names = Some(names);
                return true;
            }
        }
        false
    }

    /// True if the rows from `first` on are a matrix; `given` if the caller says so.
    fn is_matrix(&mut self, first: usize, all: &[Counts], given: bool) -> bool {
        let monotone = |numbers: &[Option<f64>]| {
            let known: Vec<f64> = numbers.iter().flatten().copied().collect();
            known.len() == numbers.len()
                && known.len() >= 2
                && (known.windows(2).all(|pair| pair[0] < pair[1]) || known.windows(2).all(|pair| pair[0] > pair[1]))
        };
        let numbers = |row: &Row<'_>| -> Vec<Option<f64>> {
            cells_of(row.text, self.separator).iter().map(|cell| value(cell, self.decimal)).collect()
        };
        // the first row may lack its corner
        let before = first
            .checked_sub(1)
            .filter(|before| all[*before].cells + 1 == all[first].cells && all[*before].numbers == all[*before].cells);
        let top = before.unwrap_or(first);
        let across = numbers(&self.sample[top]);
        let skip = usize::from(before.is_none());
        let across = &across[skip.min(across.len())..];
        let across = &across[..across.len().min(self.width - 1)];
        let rows = &self.sample[top + 1..];
        let along: Vec<Option<f64>> = rows.iter().map(|row| numbers(row).first().copied().flatten()).collect();
        let corner_is_number = before.is_none() && numbers(&self.sample[top]).first().copied().flatten().is_some();
        let rest_is_numbers = all[top + 1..].iter().all(|counts| counts.texts == 0);
        let is_one = monotone(across) && monotone(&along) && rest_is_numbers;
        let wide = self.width >= if corner_is_number { 5 } else { 3 };
        let is_list = corner_is_number && top > 0 && all[top - 1].numbers == 0 && all[top - 1].texts >= 2;
        if !(given || (is_one && wide && !is_list)) {
            return false;
        }
        let corner = cells_of(self.sample[top].text, self.separator).into_iter().next();
        self.names = corner.filter(|_| !corner_is_number && before.is_none()).map(|corner| vec![corner.into_owned()]);
        self.matrix = true;
        self.first_line = self.sample[top].line;
        self.left_out = top;
        true
    }

    /// True if this has the columns or the numbers of a table of nodes or points.
    pub(super) fn looks_like_a_table(&self) -> bool {
        let named = |names: &Vec<String>| names.iter().filter(|name| meaning_of(name).is_some()).count() >= 2;
        let data = self.sample.iter().filter(|row| row.line >= self.first_line);
        let counts = data.take(3).map(|row| counts(&cells_of(row.text, self.separator), self.decimal));
        self.matrix
            || self.names.as_ref().is_some_and(named)
            || (self.width >= 2 && self.first_line < usize::MAX && counts.into_iter().all(|row| row.numbers >= 2))
    }

    /// True if a line is the header, which blocks may repeat.
    pub(super) fn is_header(&self, text: &str) -> bool {
        self.header.is_some_and(|header| header == text.trim())
    }

    /// Drops empty cells behind the last column; whether there are as many cells as columns.
    pub(super) fn fit(&self, cells: &mut Vec<Cow<'_, str>>) -> bool {
        if cells.len() > self.width && cells[self.width..].iter().all(|cell| cell.is_empty()) {
            cells.truncate(self.width);
        }
        cells.len() == self.width
    }

    /// Another way in which the first rows have as many numbers as there are columns.
    pub(super) fn otherwise(&self, columns: &[ColumnSpec]) -> Option<(Separator, Decimal)> {
        let own = (self.separator, self.decimal);
        let rows: Vec<&Row<'_>> = self.sample.iter().filter(|row| row.line >= self.first_line).collect();
        let reads = |(separator, decimal): (Separator, Decimal)| {
            rows.iter().all(|row| {
                let mut cells = cells_of(row.text, separator);
                self.fit(&mut cells)
                    && cells.iter().zip(columns).all(|(cell, column)| {
                        !column.meaning.is_number() || cell.is_empty() || value(cell, decimal).is_some()
                    })
            })
        };
        dialect::candidates(None, None).filter(|pair| *pair != own).find(|pair| !rows.is_empty() && reads(*pair))
    }
}
