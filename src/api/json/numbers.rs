//! Arrays of numbers, flat or in rows, straight into a vector.
//!
//! Anything else than a number is recorded with its place and skipped, so that every bad node is
//! named at once.

use super::cursor::{Cursor, Syntax, Token};
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
    nulls: Noted,
    /// Values found in place of numbers.
    wrong: Noted,
}

/// The first places and what stood there; all are counted.
#[derive(Debug, Default)]
struct Noted {
    list: Vec<(String, String)>,
    count: usize,
}

impl Noted {
    fn report(&self, pointer: &str, faults: &mut Faults) {
        for i in 0..self.count {
            match self.list.get(i) {
                Some((place, what)) => faults.push(format!("{pointer}{place}"), what.as_str()),
                None => faults.push("", ""),
            }
        }
    }
}

impl Numbers {
    /// Reads the value at the cursor.
    pub fn read(cursor: &mut Cursor) -> Result<Self, Syntax> {
        let mut numbers = Numbers::default();
        match cursor.token()? {
            Token::Array => {}
            other => {
                numbers.no_array = true;
                numbers.wrong.count = 1;
                numbers
                    .wrong
                    .list
                    .push((String::new(), format!("expected an array of numbers, found {}", other.name())));
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
                    let what = format!("expected a row of numbers, found {}", other.name());
                    note(&mut numbers.wrong, || (format!("/{row}"), what));
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
            match cursor.usual_number() {
                Some(value) => {
                    cancel::every(20, self.values.len());
                    self.values.push(value);
                }
                None => self.read_unusual(cursor)?,
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

    #[inline(never)]
    fn read_unusual(&mut self, cursor: &mut Cursor) -> Result<(), Syntax> {
        if !matches!(cursor.peek(), Some(b'-' | b'0'..=b'9')) {
            return self.read_other(cursor);
        }
        let value = cursor.number()?;
        if value.is_infinite() {
            self.note_wrong("the number exceeds the range of double precision (about 1.8e308)".into());
        }
        self.values.push(value);
        Ok(())
    }

    #[cold]
    fn read_other(&mut self, cursor: &mut Cursor) -> Result<(), Syntax> {
        match cursor.token()? {
            Token::Null => {
                let place = self.place();
                note(&mut self.nulls, || {
                    (
                        place,
                        "null marks a missing node only in the heights of `nodes` of type `grid`; omit the node, or \
                         send a grid"
                            .into(),
                    )
                });
            }
            other => {
                self.arrays += usize::from(self.rows.is_none() && matches!(other, Token::Array));
                self.note_wrong(format!("expected a number, found {}", other.name()));
            }
        }
        cursor.skip_value()?;
        self.values.push(f64::NAN);
        Ok(())
    }

    #[cold]
    fn note_wrong(&mut self, what: String) {
        let place = self.place();
        note(&mut self.wrong, || (place, what));
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
        self.wrong.report(pointer, faults);
        if !null_is_missing {
            self.nulls.report(pointer, faults);
        }
    }
}

fn note(noted: &mut Noted, what: impl FnOnce() -> (String, String)) {
    noted.count += 1;
    if noted.list.len() < Faults::MOST {
        noted.list.push(what());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_are_named() {
        let first = |faults: &Faults| faults.list()[0].pointer.clone();
        for (text, pointer) in
            [("[1, \"2\"]", "/p/1"), ("[1, null]", "/p/1"), ("[[1]]", "/p/0"), ("3", "/p"), ("[1e999]", "/p/0")]
        {
            let mut faults = Faults::default();
            assert!(read_numbers(text.as_bytes(), "/p", &mut faults).is_none(), "{text}");
            assert_eq!(first(&faults), pointer, "{text}");
        }
        let mut faults = Faults::default();
        assert_eq!(read_rows(b"[[1, 2], [3]]", "/p", &mut faults), Some((vec![1.0, 2.0, 3.0], vec![2, 1])));
        assert!(read_rows(b"[1, 2]", "/p", &mut faults).is_none());
        assert_eq!(first(&faults), "/p/0");
    }

    #[test]
    fn rows_of_heights_are_concatenated_with_missing_ones() {
        let mut faults = Faults::default();
        let rows = read_heights(b"[[1, null], [], [3]]", "/p", &mut faults).unwrap();
        assert_eq!(rows.rows, Some(vec![2, 0, 1]));
        assert!(rows.values[0] == 1.0 && rows.values[1].is_nan() && rows.values[2] == 3.0);
        let flat = read_heights(b"[null, 2]", "/p", &mut faults).unwrap();
        assert!(flat.rows.is_none() && flat.values[0].is_nan() && flat.values[1] == 2.0);
        assert_eq!(read_rows_of_heights(b"[[1], [null, 2]]", "/p", &mut faults).unwrap().1, [1, 2]);
        assert!(faults.is_empty() && read_heights(b"[[1], 2]", "/p", &mut faults).is_none());
        assert_eq!(faults.list()[0].pointer, "/p/1");
        let mut faults = Faults::default();
        assert!(read_rows_of_heights(b"[1, null]", "/p", &mut faults).is_none());
        assert_eq!(faults.list()[0].pointer, "/p/0");
    }
}
