//! Preamble and numbered lines, kept whole whether their codes are known or not.

use super::{
    super::file_error::shown,
    super::note::{Notes, Remark},
    super::source::{Line, Lines, number},
    FileError, trace_head,
};

/// Most header lines that are kept; real files have about 130.
const MOST_LINES: usize = 10_000;

/// Content of a file after its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// `KS.MK.FILE`
    Curves,
    /// `KS.MW.FILE`
    Values,
}

/// A line of the preamble.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// `UNITS`, `FILTER LEAD`
    pub key: String,
    /// Text after the key.
    pub value: String,
    /// Line in the file, from 1.
    pub line: usize,
}

/// A numbered header line.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaderLine {
    /// Number of the line, which says what it holds.
    pub code: u32,
    /// Without leaders: `Normalmodul mn [mm]`.
    pub label: String,
    /// Text after the label, split at the file's separator, trimmed.
    pub fields: Vec<String>,
    /// Line in the file, from 1.
    pub line: usize,
}

impl HeaderLine {
    /// Every number among the fields, in their order; words are passed over, `52   external` has
    /// one.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        self.fields.iter().flat_map(|field| field.split_ascii_whitespace()).filter_map(number)
    }

    /// Returns the unit that the label has in brackets: `mm` for `Normalmodul mn [mm]`.
    pub fn unit(&self) -> Option<&str> {
        let (_, rest) = self.label.rsplit_once('[')?;
        rest.split_once(']').map(|(unit, _)| unit.trim()).filter(|unit| !unit.is_empty())
    }

    /// Returns the first word that resembles a number but cannot be read as one, such as `0,203`.
    pub(super) fn unreadable(&self) -> Option<&str> {
        let meant = |word: &&str| {
            let of_numbers = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b',' | b'-' | b'+' | b'\'');
            word.bytes().all(of_numbers) && word.bytes().any(|b| b.is_ascii_digit()) && number(word).is_none()
        };
        self.fields.iter().flat_map(|field| field.split_ascii_whitespace()).find(meant)
    }

    /// The fields behind a short name in capitals (`BZGFL: 1: Z` has two), or all of them.
    pub fn settings(&self) -> &[String] {
        let is_name = |field: &String| {
            let mut bytes = field.bytes();
            field.len() >= 3
                && bytes.next().is_some_and(|b| b.is_ascii_uppercase())
                && bytes.all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_')
        };
        // a number before it is a setting already, and the capitals its word
        let mut before = self.fields.iter().take_while(|field| number(field).is_none());
        let start = before.position(is_name).map_or(0, |at| at + 1);
        &self.fields[start..]
    }

    /// Text of fields and label in lower case, for words such as the hand of a helix.
    pub(super) fn words(&self) -> String {
        self.fields.join(" ").to_lowercase()
    }
}

/// Preamble and header lines of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Kind of the file: curves or values.
    pub kind: FileKind,
    /// Lines of the preamble, in the order of the file.
    pub preamble: Vec<Setting>,
    /// Numbered lines, in the order of the file.
    pub lines: Vec<HeaderLine>,
    pub(super) separator: char,
}

impl Header {
    /// Reads up to the first line that is neither preamble nor header.
    pub(super) fn parse(lines: &mut Lines, kind: FileKind, notes: &mut Notes) -> Result<Self, FileError> {
        let wanted = match kind {
            FileKind::Curves => "HEADER KS.MK.FILE",
            FileKind::Values => "HEADER KS.MW.FILE",
        };
        let first = lines.find(|line| !line.is_blank()).ok_or(FileError::Empty)?;
        if kind_of(first.text) != Some(kind) {
            return Err(first.expected(first.text, wanted));
        }
        let mut header = Header { kind, preamble: Vec::new(), lines: Vec::new(), separator: ':' };
        while let Some(line) = lines.peek() {
            if !line.is_blank() && !header.take(line, notes)? {
                break;
            }
            lines.next();
        }
        Ok(header)
    }

    /// Takes a line that belongs to the header; false where the header has ended.
    fn take(&mut self, line: Line, notes: &mut Notes) -> Result<bool, FileError> {
        if self.lines.len() + self.preamble.len() >= MOST_LINES {
            return Err(FileError::TooMany { place: line.place(line.text), what: "header lines", most: MOST_LINES });
        }
        if let Some((code, text)) = self.numbered(line) {
            if self.get(code).is_some() {
                notes.push(line.number, Remark::RepeatedCode(code));
            }
            let (label, fields) = text.split_once(self.separator).unwrap_or((text, ""));
            let fields: Vec<String> = fields.split(self.separator).map(|field| field.trim().to_owned()).collect();
            let beyond = |word: &&str| {
                word.bytes().any(|b| b.is_ascii_digit()) && word.parse::<f64>().is_ok_and(f64::is_infinite)
            };
            for word in fields.iter().flat_map(|field| field.split_ascii_whitespace()).filter(beyond) {
                notes.push(line.number, Remark::ExceedsDouble(shown(word)));
            }
            self.lines.push(HeaderLine { code, label: plain_label(label), fields, line: line.number });
            return Ok(true);
        }
        if !self.lines.is_empty() || trace_head::is_trace_head(line) {
            return Ok(false);
        }
        let Some((key, value)) = preamble_entry(line.text) else { return Ok(false) };
        if key == "SEPARATOR" {
            self.set_separator(value, line, notes);
        }
        if key == "UNITS" && !value.eq_ignore_ascii_case("mm") {
            let what = format!("lengths in {value}; only files in mm are read");
            return Err(FileError::Unsupported { place: line.place(line.text), what });
        }
        self.preamble.push(Setting { key: key.into(), value: value.into(), line: line.number });
        Ok(true)
    }

    /// Code and rest of a numbered line: up to four digits and the separator. Results have five
    /// digits.
    fn numbered<'a>(&self, line: Line<'a>) -> Option<(u32, &'a str)> {
        let text = line.text.trim_start();
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        if !(1..=4).contains(&digits) {
            return None;
        }
        let rest = text[digits..].trim_start_matches(' ').strip_prefix(self.separator)?;
        Some((text[..digits].parse().ok()?, rest))
    }

    fn set_separator(&mut self, value: &str, line: Line, notes: &mut Notes) {
        let mut chars = value.chars();
        match (chars.next(), chars.next()) {
            _ if value.eq_ignore_ascii_case("tab") => self.separator = '\t',
            (Some(c), None) if !c.is_ascii_alphanumeric() && !matches!(c, '.' | '-' | '+') => self.separator = c,
            _ => notes.push(line.number, Remark::Separator(value.to_owned())),
        }
    }

    /// The first line of a code.
    pub fn get(&self, code: u32) -> Option<&HeaderLine> {
        self.lines.iter().find(|line| line.code == code)
    }

    /// The first number of a code.
    pub fn number(&self, code: u32) -> Option<f64> {
        self.get(code)?.numbers().next()
    }

    /// The value of a key of the preamble.
    pub fn preamble(&self, key: &str) -> Option<&str> {
        self.preamble.iter().find(|setting| setting.key == key).map(|setting| setting.value.as_str())
    }
}

/// Kind of content that a first line declares.
pub(super) fn kind_of(line: &str) -> Option<FileKind> {
    let mut words = line.split_ascii_whitespace();
    if !words.next()?.eq_ignore_ascii_case("HEADER") {
        return None;
    }
    match words.next()? {
        word if word.eq_ignore_ascii_case("KS.MK.FILE") => Some(FileKind::Curves),
        word if word.eq_ignore_ascii_case("KS.MW.FILE") => Some(FileKind::Values),
        _ => None,
    }
}

/// `KEY value ! comment`, or `TWO WORDS: value ! comment`. Keys are in capitals.
fn preamble_entry(text: &str) -> Option<(&str, &str)> {
    let body = text.split('!').next().unwrap_or_default().trim();
    let is_key = |key: &str| {
        key.bytes().next().is_some_and(|b| b.is_ascii_uppercase())
            && key.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || matches!(b, b'_' | b' '))
    };
    if let Some((key, value)) = body.split_once(':')
        && !key.ends_with(' ')
        && is_key(key)
    {
        return Some((key, value.trim()));
    }
    let (key, value) = body.split_once([' ', '\t']).unwrap_or((body, ""));
    is_key(key).then_some((key, value.trim()))
}

/// A label without its leaders of dots.
fn plain_label(label: &str) -> String {
    let mut out = String::with_capacity(label.len());
    for word in label.split("..").flat_map(str::split_whitespace) {
        let word = word.trim_matches('.');
        if !word.is_empty() {
            if !out.is_empty() {
                out.push(' ');
            }
            out.push_str(word);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preamble_lines() {
        assert_eq!(preamble_entry("UNITS     mm        ! Units mm or inch"), Some(("UNITS", "mm")));
        assert_eq!(preamble_entry("SEPARATOR :         ! column separators"), Some(("SEPARATOR", ":")));
        assert_eq!(preamble_entry("FILTER LEAD:    F:S 2"), Some(("FILTER LEAD", "F:S 2")));
        assert_eq!(preamble_entry("Flankenlinie:"), None);
        assert_eq!(preamble_entry("! comment"), None);
    }

    #[test]
    fn labels_and_settings() {
        assert_eq!(plain_label("Normalmodul mn................  [mm]...."), "Normalmodul mn [mm]");
        assert_eq!(plain_label("Zeichnungsnr......"), "Zeichnungsnr");
        let fields = ["0-VDI / 1-DIN", "R_FHB", "1", "L", "+", "R", "-"].map(String::from).to_vec();
        let line = HeaderLine { code: 165, label: String::new(), fields, line: 1 };
        assert_eq!(line.settings(), ["1", "L", "+", "R", "-"]);
        let fields = ["52     external".to_owned()].to_vec();
        let line = HeaderLine { code: 22, label: String::new(), fields, line: 1 };
        assert_eq!(line.numbers().collect::<Vec<_>>(), [52.0]);
        assert_eq!(line.settings().len(), 1);
    }
}
