//! Text of a file: its characters, its lines, its numbers.
//!
//! Bytes that are UTF-8 are taken as such, with or without a byte order mark. UTF-16 is known by
//! its mark, or by the zero bytes of its first characters. Anything else is Latin-1, which every
//! sequence of bytes is. Lines end with LF or CRLF.

use std::borrow::Cow;

use super::file_error::{FileError, FilePosition, shown};
use flankfit_numerics::cancel;

/// Largest file that is read. Text of measured gears is a thousandth of that.
pub const MOST_BYTES: usize = 1 << 28;

/// The characters of a file, without byte order mark.
pub(super) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, FileError> {
    if bytes.len() > MOST_BYTES {
        return Err(FileError::TooLarge { bytes: bytes.len(), most: MOST_BYTES });
    }
    let start = FilePosition { line: 1, column: 1 };
    if bytes.starts_with(super::archive::MAGIC) || bytes.starts_with(&[0x1F, 0x8B]) {
        return Err(FileError::Unsupported { place: start, what: "a compressed file; unpack it first".into() });
    }
    if let Some(pair) = utf16(bytes) {
        let units: Vec<u16> = bytes.chunks(2).map(|two| pair([two[0], two.get(1).copied().unwrap_or(0)])).collect();
        let text = String::from_utf16_lossy(&units);
        let text = text.trim_start_matches('\u{feff}').trim_end_matches('\0');
        return if text.trim().is_empty() { Err(FileError::Empty) } else { Ok(Cow::Owned(text.to_owned())) };
    }
    let marked = bytes.strip_prefix(b"\xEF\xBB\xBF");
    let text = match std::str::from_utf8(marked.unwrap_or(bytes)) {
        Ok(text) => Cow::Borrowed(text),
        Err(fault) if marked.is_some() => {
            let bytes = marked.unwrap_or(bytes);
            let before = String::from_utf8_lossy(&bytes[..fault.valid_up_to()]);
            let found = format!("the byte {:#04x}", bytes[fault.valid_up_to()]);
            return Err(FileError::Expected {
                place: place_in(&before, before.len()),
                expected: "UTF-8, as the mark at its start says",
                found,
            });
        }
        Err(_) => Cow::Owned(bytes.iter().copied().map(char::from).collect()),
    };
    if text.trim().is_empty() { Err(FileError::Empty) } else { Ok(text) }
}

/// Reader of a unit of UTF-16 from two bytes, if the text is in UTF-16.
fn utf16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes {
        [0xFF, 0xFE, ..] => return Some(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => return Some(u16::from_be_bytes),
        _ => {}
    }
    // without a mark: every other byte of digits and Latin letters is zero
    let first = bytes.get(..8)?;
    let zeros = |from: usize| first.iter().skip(from).step_by(2).all(|byte| *byte == 0);
    let others = |from: usize| first.iter().skip(from).step_by(2).all(|byte| *byte != 0);
    if zeros(1) && others(0) {
        return Some(u16::from_le_bytes);
    }
    (zeros(0) && others(1)).then_some(u16::from_be_bytes)
}

/// The place of a byte of a text.
pub(super) fn place_in(text: &str, offset: usize) -> FilePosition {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let before = &text[..offset];
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    FilePosition { line: before.matches('\n').count() + 1, column: before[start..].chars().count() + 1 }
}

/// A line without its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    /// From 1.
    pub number: usize,
    pub text: &'a str,
}

impl<'a> Line<'a> {
    /// Place at which a part of this line begins. Only a slice of the line has a place; anything
    /// else is put at its end.
    pub(crate) fn place(&self, part: &str) -> FilePosition {
        let offset = (part.as_ptr() as usize).wrapping_sub(self.text.as_ptr() as usize).min(self.text.len());
        let before = self.text.get(..offset).unwrap_or(self.text);
        FilePosition { line: self.number, column: before.chars().count() + 1 }
    }

    /// True if there is nothing but white space.
    pub(crate) fn is_blank(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// Begins like a number?
    pub(crate) fn is_numeric(&self) -> bool {
        self.text.trim_start().bytes().next().is_some_and(|b| b.is_ascii_digit() || matches!(b, b'-' | b'+' | b'.'))
    }

    /// A fault at a part of this line.
    pub(crate) fn expected(&self, part: &str, expected: &'static str) -> FileError {
        FileError::Expected { place: self.place(part), expected, found: shown(part) }
    }

    /// The number that a part of this line is.
    pub(crate) fn number_at(&self, part: &'a str) -> Result<f64, FileError> {
        let part = if part.trim().is_empty() { part } else { part.trim() };
        number(part).ok_or_else(|| self.expected(part, "a number"))
    }
}

/// The lines of a text, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lines<'a> {
    rest: Option<&'a str>,
    number: usize,
    last: Line<'a>,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Lines { rest: Some(text), number: 0, last: Line { number: 1, text: "" } }
    }

    /// The next line, left where it is.
    pub(crate) fn peek(&self) -> Option<Line<'a>> {
        let mut copy = *self;
        copy.next()
    }

    /// Number of bytes that are left: no list that is read from here can have more entries.
    pub(crate) fn bytes_left(&self) -> usize {
        self.rest.map_or(0, str::len)
    }

    /// Behind the last line that was taken.
    pub(crate) fn place(&self) -> FilePosition {
        FilePosition { line: self.last.number, column: self.last.text.chars().count() + 1 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let rest = self.rest?;
        let (text, rest) = match rest.find('\n') {
            Some(at) => (&rest[..at], Some(&rest[at + 1..])),
            None => (rest, None),
        };
        self.rest = rest.filter(|rest| !rest.is_empty());
        self.number += 1;
        let text = text.strip_suffix('\r').unwrap_or(text);
        let line = Line { number: self.number, text };
        self.last = line;
        Some(line)
    }
}

/// Powers of ten that doubles hold exactly.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// A finite decimal number: digits, one point at most (also first or last), an exponent after `e`
/// or Fortran's `d`.
pub(super) fn number(token: &str) -> Option<f64> {
    match short_number(token.as_bytes()) {
        Some((value, length)) if length == token.len() => Some(value),
        _ => long_number(token),
    }
}

/// The number at the start of some bytes and its length, if whole digits and power of ten are exact
/// doubles, so that one division rounds correctly.
fn short_number(bytes: &[u8]) -> Option<(f64, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let mut at = usize::from(negative || bytes.first() == Some(&b'+'));
    let start = at;
    let mut whole = 0u64;
    while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
        whole = whole.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    let mut digits = at - start;
    let mut decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        let point = at;
        while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
            whole = whole.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        decimals = at - point;
        digits += decimals;
    }
    // 15 digits stay below 2⁵³
    if digits == 0 || digits > 15 {
        return None;
    }
    let value = whole as f64 / TENS[decimals];
    Some((if negative { -value } else { value }, at))
}

fn long_number(token: &str) -> Option<f64> {
    let decimal = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b'+' | b'-' | b'e' | b'E' | b'd' | b'D');
    if !token.bytes().all(decimal) {
        return None;
    }
    let value = match token.find(['d', 'D']) {
        Some(_) => token.replace(['d', 'D'], "e").parse(),
        None => token.parse(),
    };
    value.ok().filter(|value: &f64| value.is_finite())
}

/// Appends the numbers of a line; `Err` with the first piece that is none.
pub(super) fn append_numbers<'a>(line: &'a str, out: &mut Vec<f64>) -> Result<(), &'a str> {
    let bytes = line.as_bytes();
    let mut at = 0;
    loop {
        while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
            at += 1;
        }
        if at == bytes.len() {
            return Ok(());
        }
        if let Some((value, length)) = short_number(&bytes[at..])
            && bytes.get(at + length).is_none_or(u8::is_ascii_whitespace)
        {
            cancel::every(20, out.len());
            out.push(value);
            at += length;
            continue;
        }
        let token = line[at..].split_ascii_whitespace().next().unwrap_or_default();
        out.push(long_number(token).ok_or(token)?);
        at += token.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_as_files_have_them() {
        for (token, value) in [
            ("1", 1.0),
            (".011", 0.011),
            ("-.034", -0.034),
            ("5.", 5.0),
            ("+2.50", 2.5),
            ("-2147483.648", -2_147_483.648),
            ("1d-3", 1e-3),
            ("1.5E2", 150.0),
            ("0.12345678901234567890", 0.123_456_789_012_345_68),
        ] {
            assert_eq!(number(token), Some(value), "{token}");
        }
        for token in ["", "-", ".", "1,5", "nan", "inf", "1e999", "0x10", "1.2.3", "1e", "--1", "1_0", "infinity"] {
            assert_eq!(number(token), None, "{token}");
        }
    }

    #[test]
    fn places_count_characters() {
        let line = Line { number: 7, text: "Zähne ß: 12" };
        let part = &line.text[line.text.len() - 2..];
        assert_eq!(line.place(part), FilePosition { line: 7, column: 10 });
        assert_eq!(place_in("ä\nbc", 4), FilePosition { line: 2, column: 2 });
        assert_eq!(place_in("", 9), FilePosition { line: 1, column: 1 });
    }

    #[test]
    fn bytes_become_text() {
        assert_eq!(decode(b"\xEF\xBB\xBFZ\xC3\xA4").unwrap(), "Zä");
        assert_eq!(decode(b"Z\xE4").unwrap(), "Zä");
        assert_eq!(decode(b" \r\n"), Err(FileError::Empty));
        assert_eq!(decode(b"\xFF\xFEZ\0\xE4\0").unwrap(), "Zä");
        assert_eq!(decode(b"\xFE\xFF\0Z\0\xE4").unwrap(), "Zä");
        assert_eq!(decode(b"u\0,\0v\0,\0z\0").unwrap(), "u,v,z");
        assert_eq!(decode(b"\0u\0,\0v\0,\0z").unwrap(), "u,v,z");
        assert_eq!(decode(b"\xFF\xFE"), Err(FileError::Empty));
        let fault = decode(b"\xEF\xBB\xBFa\nb\xE4").unwrap_err();
        assert_eq!(fault.place(), Some(FilePosition { line: 2, column: 2 }));
    }

    proptest! {
        #[test]
        fn as_the_standard_library_reads(x in -1e7f64..1e7, decimals in 0usize..9) {
            let token = format!("{x:.decimals$}");
            prop_assert_eq!(number(&token).unwrap().to_bits(), token.parse::<f64>().unwrap().to_bits());
        }

        #[test]
        fn lines_are_the_text(text in "[a\r\n ]{0,40}") {
            // a last line that ends with CR alone loses it here
            prop_assume!(!text.ends_with('\r'));
            let own: Vec<_> = Lines::new(&text).map(|line| line.text.to_owned()).collect();
            let std: Vec<_> = text.lines().map(str::to_owned).collect();
            // an empty text has no line for the standard library, here one, so that it has a place
            prop_assert!(own == std || (text.is_empty() && own == [""]) , "{own:?} {std:?}");
        }
    }
}
