//! A file of values: header and numbered results.

use super::{
    super::{
        note::{Notes, Remark},
        source::{Line, Lines, number},
    },
    FileError, FileKind, Header,
    results::{Characteristic, MeasuringPosition, Statistic, code_of},
    trace_head::{is_tooth, side_of},
};
use flankfit_gear::Side;
use flankfit_numerics::cancel::Asking;

/// Stored instead of a value that was not measured.
const NOT_MEASURED: f64 = -9999.0;
/// Stored instead of a statistic that could not be formed.
const NOT_AVAILABLE: f64 = 8999.0;

/// Value of a result, or the reason why it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResultValue {
    /// µm for deviations, mm for diameters and spans.
    Value(f64),
    /// The result was not measured.
    NotMeasured,
    /// The statistic could not be formed.
    NotAvailable,
}

impl ResultValue {
    /// The number; `None` where there is none.
    pub fn value(self) -> Option<f64> {
        match self {
            ResultValue::Value(value) => Some(value),
            ResultValue::NotMeasured | ResultValue::NotAvailable => None,
        }
    }
}

/// A numbered result. Its code says what it is; the label names the tooth.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultLine {
    /// Code of the line.
    pub code: u32,
    /// Name as printed, with single spaces: `fHb links 1`.
    pub name: String,
    /// `None` for a code of no known meaning.
    pub characteristic: Option<Characteristic>,
    /// Place on the flank of the measurement.
    pub place: MeasuringPosition,
    /// Statistic of the result: of one tooth, or over all.
    pub statistic: Statistic,
    /// Flank, for a characteristic of one side.
    pub side: Option<Side>,
    /// Tooth that the label names.
    pub tooth: Option<String>,
    /// The result, or the reason why it has none.
    pub reading: ResultValue,
    /// Line in the file, from 1.
    pub line: usize,
}

/// A file of values.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Preamble and header lines.
    pub header: Header,
    /// Results, in the order of the file.
    pub results: Vec<ResultLine>,
    /// Remarks about lines that were read in spite of them.
    pub notes: Notes,
}

impl Values {
    /// Reads the text of a file.
    pub(super) fn parse(text: &str) -> Result<Self, FileError> {
        let mut lines = Lines::new(text);
        let mut notes = Notes::default();
        let header = Header::parse(&mut lines, FileKind::Values, &mut notes)?;
        let mut results = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for line in lines.filter(|line| !line.is_blank()).asking(500) {
            if let Some(result) = result_of(line, header.separator, &mut notes)? {
                if !seen.insert(result.code) {
                    notes.push(line.number, Remark::RepeatedResult(result.code));
                }
                results.push(result);
            } else {
                notes.push(line.number, Remark::NoResult(super::super::file_error::shown(line.text)));
            }
        }
        Ok(Values { header, results, notes })
    }
}

/// `10111 : fHb links 1 : -2.9`; `None` for a line that does not begin with a code.
fn result_of(line: Line, separator: char, notes: &mut Notes) -> Result<Option<ResultLine>, FileError> {
    let text = line.text.trim_start();
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 {
        return Ok(None);
    }
    let Some(rest) = text[digits..].trim_start_matches(' ').strip_prefix(separator) else { return Ok(None) };
    let code: u32 = text[..digits].parse().map_err(|_| line.expected(text, "the code of a result"))?;
    let Some((label, value)) = rest.rsplit_once(separator) else {
        return Err(line.expected(rest, "a label, the separator and a value"));
    };
    let printed = value.trim();
    let value =
        number(printed).ok_or_else(|| line.expected(if printed.is_empty() { value } else { printed }, "a value"))?;
    let reading = match value {
        NOT_MEASURED => ResultValue::NotMeasured,
        NOT_AVAILABLE => ResultValue::NotAvailable,
        value => ResultValue::Value(value),
    };
    let meaning = code_of(code);
    let words = || label.split_ascii_whitespace();
    let by_label = words().find_map(side_of);
    let by_code = meaning.and_then(|meaning| meaning.side);
    if let (Some(label), Some(code_side)) = (by_label, by_code)
        && label != code_side
    {
        notes.push(line.number, Remark::SideDisagrees(code));
    }
    let name = words().collect::<Vec<_>>().join(" ");
    let statistic = meaning.map_or(Statistic::Unknown, |meaning| meaning.statistic);
    // the last word that looks like a tooth, of a result that has one
    let tooth =
        matches!(statistic, Statistic::Tooth | Statistic::Unknown).then(|| words().rev().find(|word| is_tooth(word)));
    Ok(Some(ResultLine {
        code,
        name,
        characteristic: meaning.map(|meaning| meaning.characteristic),
        place: meaning.map_or(MeasuringPosition::Middle, |meaning| meaning.place),
        statistic,
        side: by_code.or(by_label),
        tooth: tooth.flatten().map(str::to_owned),
        reading,
        line: line.number,
    }))
}
