//! Lines of a table and their cells.

use std::borrow::Cow;

use super::{Decimal, Separator};
use crate::source::number;

/// The most columns that are read.
pub const MOST_COLUMNS: usize = 10_000;

/// Lines that a quoted cell may extend over.
const QUOTED_LINES: usize = 5;

/// A line that holds cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    /// From 1.
    pub line: usize,
    pub text: &'a str,
}

/// A line by what it is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind<'a> {
    Cells(Row<'a>),
    Comment(Row<'a>),
    /// The name in `[name]`.
    Block(&'a str),
}

/// The lines of a text that are not blank. They end with LF, CRLF or CR; a quoted cell may hold
/// line breaks.
#[derive(Clone, Debug)]
pub(super) struct Rows<'a> {
    text: &'a str,
    at: usize,
    line: usize,
}

impl<'a> Rows<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Rows { text, at: 0, line: 1 }
    }

    /// The end of the line that begins at `from`, and where the next one begins.
    fn end_of_line(&self, from: usize) -> (usize, usize) {
        let bytes = self.text.as_bytes();
        match bytes[from..].iter().position(|byte| matches!(byte, b'\n' | b'\r')) {
            None => (bytes.len(), bytes.len()),
            Some(at) => {
                let end = from + at;
                (end, end + if bytes[end..].starts_with(b"\r\n") { 2 } else { 1 })
            }
        }
    }
}

impl<'a> Iterator for Rows<'a> {
    type Item = Kind<'a>;

    fn next(&mut self) -> Option<Kind<'a>> {
        let is_open = |text: &str| text.bytes().filter(|byte| *byte == b'"').count() % 2 == 1;
        while self.at < self.text.len() {
            let (start, line) = (self.at, self.line);
            let (mut end, mut next) = self.end_of_line(start);
            let mut lines = 1;
            if is_open(&self.text[start..end]) {
                let mut further = (end, next);
                for count in 2..=QUOTED_LINES {
                    further = self.end_of_line(further.1);
                    if !is_open(&self.text[start..further.0]) {
                        (end, next, lines) = (further.0, further.1, count);
                        break;
                    }
                }
            }
            self.at = next;
            self.line += lines;
            let text = &self.text[start..end];
            // tabs and blanks at the beginning may be empty cells
            let trimmed = text.trim();
            let bare = trimmed.trim_end_matches([';', ',', '\t', ' ']);
            if bare.is_empty() {
                continue;
            }
            if ["#", "%", "//", "!", "*"].iter().any(|mark| trimmed.starts_with(mark)) {
                return Some(Kind::Comment(Row { line, text: trimmed.trim_start_matches(['#', '%', '/', '!', '*']) }));
            }
            let inner = bare.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
            if let Some(name) = inner.filter(|name| name.len() <= 64 && !name.contains(['[', ']', ';', ',', '\t'])) {
                return Some(Kind::Block(name.trim()));
            }
            return Some(Kind::Cells(Row { line, text }));
        }
        None
    }
}

/// Cuts a line into its cells, without blanks and quotes around them. At most one cell more than
/// [`MOST_COLUMNS`] is returned.
pub(super) fn split<'a>(text: &'a str, separator: Separator, cells: &mut Vec<Cow<'a, str>>) {
    cells.clear();
    let Some(mark) = separator.mark() else {
        split_at_blanks(text, cells);
        return;
    };
    let mut rest = Some(text);
    while let Some(text) = rest.filter(|_| cells.len() <= MOST_COLUMNS) {
        // a tab is a separator, or a blank like any other
        let start = text.trim_start_matches(|c: char| c != mark && c.is_whitespace());
        if let Some((cell, behind)) = quoted(start) {
            let behind = behind.trim_start_matches(|c: char| c != mark && c.is_whitespace());
            if behind.is_empty() || behind.starts_with(mark) {
                cells.push(cell);
                rest = behind.strip_prefix(mark);
                continue;
            }
        }
        let (cell, behind) = match start.split_once(mark) {
            Some((cell, behind)) => (cell, Some(behind)),
            None => (start, None),
        };
        cells.push(Cow::Borrowed(cell.trim()));
        rest = behind;
    }
}

fn split_at_blanks<'a>(text: &'a str, cells: &mut Vec<Cow<'a, str>>) {
    let mut rest = text.trim_start();
    while !rest.is_empty() && cells.len() <= MOST_COLUMNS {
        let (cell, behind) = match quoted(rest) {
            Some((cell, behind)) if behind.is_empty() || behind.starts_with(char::is_whitespace) => (cell, behind),
            _ => {
                let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
                (Cow::Borrowed(&rest[..end]), &rest[end..])
            }
        };
        cells.push(cell);
        rest = behind.trim_start();
    }
}

/// A quoted cell and what follows it; two quotes are one.
fn quoted(text: &str) -> Option<(Cow<'_, str>, &str)> {
    let inside = text.strip_prefix('"')?;
    let mut end = inside.find('"')?;
    if !inside[end + 1..].starts_with('"') {
        return Some((Cow::Borrowed(inside[..end].trim()), &inside[end + 1..]));
    }
    let mut cell = String::new();
    let mut rest = inside;
    loop {
        cell.push_str(&rest[..end]);
        rest = &rest[end + 1..];
        let Some(more) = rest.strip_prefix('"') else { break };
        cell.push('"');
        rest = more;
        end = rest.find('"')?;
    }
    Some((Cow::Owned(cell.trim().to_owned()), rest))
}

/// The number of a cell.
pub(super) fn value(cell: &str, decimal: Decimal) -> Option<f64> {
    // U+2212, which typeset tables have
    let minus = cell.strip_prefix('\u{2212}').map(|rest| format!("-{rest}"));
    let cell = minus.as_deref().unwrap_or(cell);
    let number = match decimal {
        Decimal::Comma if cell.contains('.') => None,
        Decimal::Comma if cell.contains(',') => number(&cell.replacen(',', ".", 1)),
        _ => number(cell),
    };
    // −0 is 0
    number.map(|number| number + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_line() {
        for (text, separator, wanted) in [
            ("1, 2 ,,3", Separator::Comma, &["1", "2", "", "3"][..]),
            ("\"a;1\" ; \"b\"\"c\";\"d", Separator::Semicolon, &["a;1", "b\"c", "\"d"]),
            ("\t1\t 2", Separator::Tab, &["", "1", "2"]),
            ("  1 \t \"2 3\"  4 ", Separator::Spaces, &["1", "2 3", "4"]),
            ("1;", Separator::Semicolon, &["1", ""]),
            ("\"p\"x,1", Separator::Comma, &["\"p\"x", "1"]),
        ] {
            let mut cells = Vec::new();
            split(text, separator, &mut cells);
            assert_eq!(cells, wanted, "{text}");
        }
        let long = ",".repeat(20_000);
        let mut cells = Vec::new();
        split(&long, Separator::Comma, &mut cells);
        assert_eq!(cells.len(), MOST_COLUMNS + 1);
    }

    #[test]
    fn rows_comments_and_blocks_are_recognised() {
        let text = "# c\r\n\r[A] ;\n1;\"2\n3\"\r4\n;;\n\"5;\n6";
        let kinds: Vec<String> = Rows::new(text)
            .map(|kind| match kind {
                Kind::Cells(row) => format!("{} {}", row.line, row.text),
                Kind::Comment(row) => format!("{} comment{}", row.line, row.text),
                Kind::Block(name) => format!("block {name}"),
            })
            .collect();
        assert_eq!(kinds, ["1 comment c", "block A", "4 1;\"2\n3\"", "6 4", "8 \"5;", "9 6"]);
    }

    #[test]
    fn numbers_of_cells() {
        assert_eq!(value("\u{2212}1,5", Decimal::Comma), Some(-1.5));
        assert_eq!(value("1.5", Decimal::Comma), None);
        assert_eq!(value("1,5", Decimal::Point), None);
        assert_eq!(value("-0", Decimal::Point).map(f64::to_bits), Some(0));
        assert_eq!(value("", Decimal::Point), None);
    }
}
