//! Quality data in the Q-DAS ASCII transfer format (`.dfq`; ISO/TR 11462-5): a part, its
//! characteristics with limits, and a value of each, as programs for statistical process control
//! read them.
//!
//! A file is made of lines, a key field and its content: `K2002/3 f_Halpha`. `/3` is the number of
//! the characteristic. First comes the number of characteristics (K0100), then the part (K1…), then
//! each characteristic (K2…), and last the values (K0001) with what belongs to each. Values are
//! written under their keys and not in the compact form, whose separators are control characters.
//! Texts lose control characters and are cut to the length of their field, so none can break a
//! line.
//!
//! Limits are absolute (K2110, K2111). Their kinds (K2120, K2121) are not written: a limit without
//! a kind is a limit.

mod encoding;

pub use encoding::{Charset, encode};

use std::fmt::Display;

use super::{UtcTime, number::real_within};
use flankfit_numerics::check::Faults;

/// Media type of such files in `Accept`.
pub const MEDIA_TYPE: &str = "application/x-q-das-dfq";

/// Digits behind the point of a value (K2022): of a micrometre a nanometre.
pub const DECIMALS: usize = 3;
/// Characters of a number (K0001, K2110, K2111).
const LONGEST_NUMBER: usize = 22;

/// Measured part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// K1001, by which a database knows the part; up to 30 characters.
    pub number: String,
    /// K1002; up to 80 characters.
    pub name: String,
    /// K1082: the machine that made it; up to 40 characters.
    pub machine: Option<String>,
    /// K1202: what it was measured with; up to 40 characters.
    pub instrument: Option<String>,
    /// K1222: who measured it; up to 40 characters.
    pub operator: Option<String>,
}

/// A characteristic with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Characteristic {
    /// K2001; up to 20 characters.
    pub number: String,
    /// K2002; up to 80 characters.
    pub name: String,
    /// K2142; up to 20 characters.
    pub unit: &'static str,
    /// K2110.
    pub lower_limit: Option<f64>,
    /// K2111.
    pub upper_limit: Option<f64>,
    /// K0001. None: a placeholder (K0002 is 255).
    pub value: Option<f64>,
}

/// Data that belong to every value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// K0004, in UTC.
    pub at: UtcTime,
    /// K0006; up to 14 characters.
    pub batch: Option<String>,
    /// K0009: where it comes from; up to 255 characters.
    pub remark: Option<String>,
    /// K0014: which part it was; up to 40 characters.
    pub serial_number: Option<String>,
}

/// Writes one part with one value of each characteristic, lines ended by CRLF.
///
/// ```
/// use flankfit_formats::{UtcTime, qdas::{Characteristic, Measurement, Part, write}};
///
/// let part = Part { number: "4711".into(), name: "Gear".into(), ..Part::default() };
/// let slope = Characteristic {
///     number: "1L-f_Halpha".into(),
///     name: "f_Halpha, left flank of tooth 1".into(),
///     unit: "µm",
///     lower_limit: Some(-6.0),
///     upper_limit: Some(6.0),
///     value: Some(2.25),
/// };
/// let at = UtcTime::new([2026, 11, 26], [7, 5, 9]).expect("a day");
/// let measured = Measurement { at, batch: None, remark: None, serial_number: None };
/// let text = write(&part, &[slope], &measured)?;
/// assert!(text.starts_with("K0100 1\r\nK1001/1 4711\r\n"));
/// assert!(text.contains("K2110/1 -6.000\r\n") && text.contains("K0001/1 2.250\r\n"));
/// assert!(text.contains("K0004/1 26.11.2026/07:05:09\r\n"));
/// # Ok::<(), flankfit_numerics::check::Faults>(())
/// ```
pub fn write(part: &Part, characteristics: &[Characteristic], measured: &Measurement) -> Result<String, Faults> {
    check(part, characteristics)?;
    let mut lines = Lines(String::new());
    lines.put("K0100", None, characteristics.len());
    let of_part = Some(1);
    lines.text("K1001", of_part, Some(&part.number), 30);
    lines.text("K1002", of_part, Some(&part.name), 80);
    lines.text("K1082", of_part, part.machine.as_deref(), 40);
    lines.text("K1202", of_part, part.instrument.as_deref(), 40);
    lines.text("K1222", of_part, part.operator.as_deref(), 40);
    for (k, one) in characteristics.iter().enumerate() {
        let at = Some(k + 1);
        lines.text("K2001", at, Some(&one.number), 20);
        lines.text("K2002", at, Some(&one.name), 80);
        // a measured one, not one that is counted
        lines.put("K2004", at, 0);
        lines.put("K2022", at, DECIMALS);
        for (key, limit) in [("K2110", one.lower_limit), ("K2111", one.upper_limit)] {
            if let Some(limit) = limit {
                lines.put(key, at, number(limit));
            }
        }
        lines.text("K2142", at, Some(one.unit), 20);
    }
    for (k, one) in characteristics.iter().enumerate() {
        let at = Some(k + 1);
        lines.put("K0001", at, number(one.value.unwrap_or(0.0)));
        lines.put("K0002", at, if one.value.is_some() { 0 } else { 255 });
        lines.put("K0004", at, measured.at.day_first());
        lines.text("K0006", at, measured.batch.as_deref(), 14);
        lines.text("K0009", at, measured.remark.as_deref(), 255);
        lines.text("K0014", at, measured.serial_number.as_deref(), 40);
    }
    Ok(lines.0)
}

/// Refuses what cannot be written.
fn check(part: &Part, characteristics: &[Characteristic]) -> Result<(), Faults> {
    if characteristics.is_empty() {
        return Err(Faults::one("characteristics", "there is no characteristic"));
    }
    for (path, name, text) in
        [("part.number", "the part's number", &part.number), ("part.name", "the part's name", &part.name)]
    {
        if one_line(text, 1).is_empty() {
            return Err(Faults::one(path, format_args!("{name} is empty")));
        }
    }
    let mut seen = std::collections::HashMap::with_capacity(characteristics.len());
    for (index, one) in characteristics.iter().enumerate() {
        for (name, text) in [("number", &one.number), ("name", &one.name)] {
            if one_line(text, 1).is_empty() {
                let path = format_args!("characteristics[{index}].{name}");
                return Err(Faults::one(path, format_args!("characteristic {index} has no {name}")));
            }
        }
        let number = one_line(&one.number, 20);
        if let Some(first) = seen.insert(number.clone(), index) {
            let path = format_args!("characteristics[{index}].number");
            let message = format_args!("characteristics {first} and {index} have the same number {number}");
            return Err(Faults::one(path, message));
        }
        for (field, name, value) in [
            ("value", "its value", one.value),
            ("lower_limit", "the lower limit", one.lower_limit),
            ("upper_limit", "the upper limit", one.upper_limit),
        ] {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                let path = format_args!("characteristics[{index}].{field}");
                let message = format_args!("characteristic {index}: {name} is {value}, not a finite number");
                return Err(Faults::one(path, message));
            }
        }
        if let (Some(lower), Some(upper)) = (one.lower_limit, one.upper_limit)
            && lower > upper
        {
            return Err(Faults::one(
                format_args!("characteristics[{index}].lower_limit"),
                format_args!("characteristic {index}: the lower limit {lower} lies above the upper one, {upper}"),
            ));
        }
    }
    Ok(())
}

struct Lines(String);

impl Lines {
    fn put(&mut self, key: &str, index: Option<usize>, content: impl Display) {
        let place = index.map(|index| format!("/{index}")).unwrap_or_default();
        self.0.push_str(&format!("{key}{place} {content}\r\n"));
    }

    /// A text, cut to the characters of its field; none, where nothing is left of it.
    fn text(&mut self, key: &str, index: Option<usize>, text: Option<&str>, longest: usize) {
        let content = text.map(|text| one_line(text, longest)).unwrap_or_default();
        if !content.is_empty() {
            self.put(key, index, content);
        }
    }
}

/// A text in one line: control characters, line ends and what some programs show the separators of
/// the compact form as (`¤`) are blanks.
pub fn one_line(text: &str, longest: usize) -> String {
    let blank = |c: char| if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '¤') { ' ' } else { c };
    let plain: String = text.chars().map(blank).collect();
    plain.trim().chars().take(longest).collect::<String>().trim_end().to_owned()
}

/// Number with [`DECIMALS`] digits after the point, or with an exponent if that is too long.
fn number(x: f64) -> String {
    let rounded = format!("{x:.DECIMALS$}");
    if rounded.len() > LONGEST_NUMBER {
        return real_within(x, LONGEST_NUMBER);
    }
    // no minus in front of nothing
    match rounded.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|digit| matches!(digit, b'0' | b'.')) => rest.to_owned(),
        _ => rounded,
    }
}
