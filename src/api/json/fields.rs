//! Requests other than fits: the fields of an object as slices of its text, and arrays of numbers
//! from slices.
//!
//! What is big (points, parameters, grids) goes straight into vectors; what is small is left to
//! serde on its slice.

use super::{
    cursor::{Cursor, Syntax, Token},
    error::{ReadError, malformed},
    nulls,
    numbers::Numbers,
    place::escape,
    wording::no_such_field,
};
use crate::api::faults::Faults;

/// The fields of an object, each still text.
#[derive(Debug, Default)]
pub struct Fields<'a> {
    entries: Vec<(&'static str, &'a [u8])>,
}

impl<'a> Fields<'a> {
    /// The fields of a whole request. Unknown ones and those that stand twice are faults; what is
    /// not JSON is an error.
    pub fn of_request(text: &'a [u8], keys: &[&'static str], faults: &mut Faults) -> Result<Self, ReadError> {
        let mut cursor = Cursor::new(text);
        let fields = Self::walk(&mut cursor, "", keys, faults);
        let fields =
            fields.and_then(|fields| cursor.end().map(|()| fields)).map_err(|syntax| malformed(text, &syntax))?;
        nulls::refuse(&cursor, faults);
        Ok(fields)
    }

    /// The fields of a part of a request that stands at `at`, known to be JSON; `None` where it is
    /// no object. Unknown fields and those that stand twice are faults, and the others are looked
    /// at all the same.
    pub fn of_part(slice: &'a [u8], at: &str, keys: &[&'static str], faults: &mut Faults) -> Option<Self> {
        let is_object = Cursor::new(slice).token().ok()? == Token::Object;
        let fields = Self::walk(&mut Cursor::new(slice), at, keys, faults).ok()?;
        is_object.then_some(fields)
    }

    /// The text of a field.
    pub fn get(&self, key: &str) -> Option<&'a [u8]> {
        self.entries.iter().find(|(known, _)| *known == key).map(|(_, slice)| *slice)
    }

    /// The same without a field, which is read otherwise.
    pub fn without(&self, key: &str) -> Self {
        Fields { entries: self.entries.iter().copied().filter(|(known, _)| *known != key).collect() }
    }

    /// The text of a field of the object at `at` that must be there.
    pub fn required(&self, key: &str, at: &str, faults: &mut Faults) -> Option<&'a [u8]> {
        let slice = self.get(key);
        if slice.is_none() {
            faults.push(format!("{at}/{key}"), "missing");
        }
        slice
    }

    fn walk(cursor: &mut Cursor<'a>, at: &str, keys: &[&'static str], faults: &mut Faults) -> Result<Self, Syntax> {
        let mut fields = Fields::default();
        match cursor.token()? {
            Token::Object => {}
            other => {
                faults.push(at, format!("expected an object, found {}", other.name()));
                cursor.skip_value()?;
                return Ok(fields);
            }
        }
        cursor.object(|cursor, key| {
            let slice = cursor.skip_value()?;
            match keys.iter().find(|known| **known == key) {
                None => faults.push(format!("{at}/{}", escape(&key)), no_such_field(&key, keys)),
                Some(known) if fields.get(known).is_some() => {
                    faults.push(format!("{at}/{known}"), "the field stands twice");
                }
                Some(known) => fields.entries.push((known, slice)),
            }
            Ok(())
        })?;
        Ok(fields)
    }
}

/// An array of numbers that stands at `at`, known to be JSON.
pub fn read_numbers(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Vec<f64>> {
    let numbers = read_array(slice, at, faults)?;
    if numbers.rows.is_some() {
        faults.push(format!("{at}/0"), "expected a number, found an array");
        return None;
    }
    Some(numbers.values)
}

/// Rows of numbers that stand at `at`, known to be JSON: the numbers end to end and the lengths of
/// the rows.
pub fn read_rows(slice: &[u8], at: &str, faults: &mut Faults) -> Option<(Vec<f64>, Vec<usize>)> {
    let numbers = read_array(slice, at, faults)?;
    match numbers.rows {
        Some(rows) => Some((numbers.values, rows)),
        None if numbers.values.is_empty() => Some((Vec::new(), Vec::new())),
        None => {
            faults.push(format!("{at}/0"), "expected a row of numbers, found a number");
            None
        }
    }
}

fn read_array(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Numbers> {
    let before = faults.count();
    let numbers = Numbers::read(&mut Cursor::new(slice)).ok()?;
    numbers.report(at, false, faults);
    (faults.count() == before).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(faults: &Faults) -> (&str, &str) {
        faults.list().first().map_or(("", ""), |fault| (&fault.pointer, &fault.detail))
    }

    #[test]
    fn fields_are_slices_and_strangers_are_named() {
        let mut faults = Faults::default();
        let text = br#" {"a": [1, 2], "b": {"c": 3}} "#;
        let fields = Fields::of_request(text, &["a", "b"], &mut faults).unwrap();
        assert_eq!(read_numbers(fields.get("a").unwrap(), "/a", &mut faults), Some(vec![1.0, 2.0]));
        assert_eq!(fields.get("b").unwrap(), br#"{"c": 3}"#);
        assert!(fields.required("d", "", &mut faults).is_none());
        assert_eq!(first(&faults), ("/d", "missing"));
        for (text, pointer, what) in [
            (&br#"{"x": 1}"#[..], "/x", "expected `a` or `b`"),
            (br#"{"a": 1, "a": 2}"#, "/a", "twice"),
            (br#"[1]"#, "", "expected an object, found an array"),
        ] {
            let mut faults = Faults::default();
            Fields::of_request(text, &["a", "b"], &mut faults).unwrap();
            let (place, detail) = first(&faults);
            assert!(place == pointer && detail.contains(what), "{place} {detail}");
        }
        assert!(Fields::of_request(b"{\"a\": 1} x", &["a"], &mut faults).is_err());
    }

    #[test]
    fn numbers_that_are_none_are_named() {
        for (text, pointer) in
            [("[1, \"2\"]", "/p/1"), ("[1, null]", "/p/1"), ("[[1]]", "/p/0"), ("3", "/p"), ("[1e999]", "/p/0")]
        {
            let mut faults = Faults::default();
            assert!(read_numbers(text.as_bytes(), "/p", &mut faults).is_none(), "{text}");
            assert_eq!(first(&faults).0, pointer, "{text}");
        }
        let mut faults = Faults::default();
        assert_eq!(read_rows(b"[[1, 2], [3]]", "/p", &mut faults), Some((vec![1.0, 2.0, 3.0], vec![2, 1])));
        assert!(read_rows(b"[1, 2]", "/p", &mut faults).is_none());
        assert_eq!(first(&faults).0, "/p/0");
    }
}
