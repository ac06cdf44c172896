//! Arrays of numbers, flat or in rows, straight into a vector.
//!
//! Anything else than a number is recorded with its place and skipped, so that every bad node is
//! named at once.

use super::{
    cursor::{Cursor, Syntax, Token},
    wording::BEYOND,
};
use crate::api::faults::Faults;
use flankfit_engine::numerics::cancel;

/// Numbers after which the length of the array is estimated.
const SAMPLE: usize = 4096;

/// Numbers as they stood, with what was wrong among them.
#[derive(Debug, Default)]
pub struct Numbers {
    /// All of them, rows end to end; NaN marks whatever was not a number.
    pub values: Vec<f64>,
    /// Lengths of the rows, when there were rows.
    pub rows: Option<Vec<usize>>,
    /// Whether there was no array at all.
    pub no_array: bool,
    /// Arrays among numbers that are not in rows.
    pub arrays: usize,
    /// Start of the row that is being read.
    row_begin: usize,
    /// Places of `null`, which in a grid's heights are missing nodes.
    nulls: Faults,
    /// Values found in place of numbers.
    wrong: Faults,
}

impl Numbers {
    /// Reads the value at the cursor.
    pub fn read(cursor: &mut Cursor) -> Result<Self, Syntax> {
        let mut numbers = Numbers::default();
        match cursor.token()? {
            Token::Array => {}
            other => {
                numbers.no_array = true;
                numbers.wrong.push("", format!("expected an array of numbers, found {}", other.name()));
                cursor.skip_value()?;
                return Ok(numbers);
            }
        }
        let mut ahead = cursor.clone();
        ahead.at += 1;
        ahead.skip_space();
        if ahead.peek() != Some(b'[') {
            numbers.read_row(cursor)?;
            return Ok(numbers);
        }
        numbers.rows = Some(Vec::new());
        cursor.array(|cursor, row| {
            numbers.row_begin = numbers.values.len();
            match cursor.token()? {
                Token::Array => numbers.read_row(cursor)?,
                other => {
                    numbers.wrong.push(format!("/{row}"), format!("expected a row of numbers, found {}", other.name()));
                    cursor.skip_value()?;
                }
            }
            let length = numbers.values.len() - numbers.row_begin;
            numbers.rows.get_or_insert_default().push(length);
            Ok(())
        })?;
        Ok(numbers)
    }

    fn read_row(&mut self, cursor: &mut Cursor) -> Result<(), Syntax> {
        let begin = cursor.at;
        cursor.at += 1;
        if cursor.takes(b']') {
            return Ok(());
        }
        loop {
            cursor.skip_space();
            cancel::every(20, self.values.len());
            match cursor.peek() {
                Some(b'-' | b'0'..=b'9') => {
                    let value = cursor.number()?;
                    if value.is_infinite() {
                        self.wrong.push(self.place(), BEYOND);
                    }
                    self.values.push(value);
                }
                _ => self.read_other(cursor)?,
            }
            if self.values.len() == SAMPLE {
                self.reserve(cursor, cursor.at - begin);
            }
            cursor.skip_space();
            match cursor.peek() {
                Some(b',') => cursor.at += 1,
                Some(b']') => {
                    cursor.at += 1;
                    return Ok(());
                }
                _ => return cursor.unexpected("`,` or `]` after a number"),
            }
        }
    }

    /// Reserves memory for the numbers to come, judging by how long the last ones were: a big array
    /// is neither copied nor held twice while it grows. (Memory that turns out not to be needed is
    /// never written to.)
    #[cold]
    fn reserve(&mut self, cursor: &Cursor, row_bytes: usize) {
        let in_row = self.values.len() - self.row_begin;
        let bytes = if self.rows.is_none() { cursor.to_bracket() } else { cursor.to_end() };
        let each = (row_bytes / in_row).max(2);
        // Only a saving: without it the vector grows as it goes.
        let _taken = self.values.try_reserve(bytes / each + bytes / (64 * each) + 1);
    }

    #[cold]
    fn read_other(&mut self, cursor: &mut Cursor) -> Result<(), Syntax> {
        match cursor.token()? {
            Token::Null => {
                self.nulls.push(
                    self.place(),
                    "null marks a missing node only in the heights of `nodes` of type `grid`; omit the node, or send a \
                     grid",
                );
            }
            other => {
                self.arrays += usize::from(self.rows.is_none() && matches!(other, Token::Array));
                self.wrong.push(self.place(), format!("expected a number, found {}", other.name()));
            }
        }
        cursor.skip_value()?;
        self.values.push(f64::NAN);
        Ok(())
    }

    /// Place of the next number, as the rest of a pointer.
    fn place(&self) -> String {
        let i = self.values.len() - self.row_begin;
        match &self.rows {
            Some(rows) => format!("/{}/{i}", rows.len()),
            None => format!("/{i}"),
        }
    }

    /// Hands over what was wrong; `null` is a missing node where `null_is_missing`.
    pub fn report(&self, pointer: &str, null_is_missing: bool, faults: &mut Faults) {
        faults.append(self.wrong.clone().within(pointer));
        if !null_is_missing {
            faults.append(self.nulls.clone().within(pointer));
        }
    }
}

/// Reads an array of numbers at `at`, known to be JSON.
pub fn read_numbers(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Vec<f64>> {
    let numbers = read_array(slice, at, false, faults)?;
    if numbers.rows.is_some() {
        faults.push(format!("{at}/0"), "expected a number, found an array");
        return None;
    }
    Some(numbers.values)
}

/// Rows of numbers that stand at `at`, known to be JSON: the numbers end to end and the lengths of
/// the rows.
pub fn read_rows(slice: &[u8], at: &str, faults: &mut Faults) -> Option<(Vec<f64>, Vec<usize>)> {
    rows(read_array(slice, at, false, faults)?, at, faults)
}

/// The same of heights; `null` is NaN: missing.
pub fn read_rows_of_heights(slice: &[u8], at: &str, faults: &mut Faults) -> Option<(Vec<f64>, Vec<usize>)> {
    rows(read_heights(slice, at, faults)?, at, faults)
}

fn rows(numbers: Numbers, at: &str, faults: &mut Faults) -> Option<(Vec<f64>, Vec<usize>)> {
    match numbers.rows {
        Some(rows) => Some((numbers.values, rows)),
        None if numbers.values.is_empty() => Some((Vec::new(), Vec::new())),
        None => {
            faults.push(format!("{at}/0"), "expected a row of numbers, found a number");
            None
        }
    }
}

/// Heights that stand at `at`, known to be JSON, as numbers or in rows; `null` is NaN: missing.
pub fn read_heights(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Numbers> {
    read_array(slice, at, true, faults)
}

fn read_array(slice: &[u8], at: &str, null_is_missing: bool, faults: &mut Faults) -> Option<Numbers> {
    let before = faults.count();
    let numbers = Numbers::read(&mut Cursor::new(slice)).ok()?;
    numbers.report(at, null_is_missing, faults);
    (faults.count() == before).then_some(numbers)
}
