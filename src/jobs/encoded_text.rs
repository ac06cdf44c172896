//! Documents on their way to the store.

use std::{cell::RefCell, io, ops::Deref, sync::Arc};

use serde::Deserialize;
use serde_json::{Deserializer, value::RawValue};
use zstd::{bulk::Compressor, zstd_safe::CParameter};

use super::frames;

/// Longer texts are compressed.
pub const LONG: usize = 8 << 10;
/// Coefficients and prior of longer results are stored separately, for the trace.
pub const READ_AT_ONCE: usize = 64 << 10;
/// Fast: whoever posts a fit waits for it.
const LEVEL: i32 = 1;
/// Places, as a power of two, of the table for texts up to [`SMALL`]: it stays in the
/// nearest cache, where the level's own does not, and hardly less is found by it.
const SMALL_TABLE: u32 = 12;
const SMALL: usize = 64 << 10;
/// First bytes of frames of zstd; the second byte begins no letter of UTF-8.
const FRAME: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

thread_local! {
    /// Making one anew takes longer than a short text does.
    static COMPRESSOR: RefCell<Option<Compressor<'static>>> = const { RefCell::new(None) };
}

/// A document, with what is stored of it, made before the store takes it.
#[derive(Clone, Debug)]
pub struct EncodedText {
    text: Arc<str>,
    frame: Option<Arc<[u8]>>,
}

impl EncodedText {
    pub fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// The frame, or the text where there is none.
    pub fn bytes(&self) -> &[u8] {
        self.frame.as_deref().unwrap_or(self.text.as_bytes())
    }

    /// Returns the text of [`Self::bytes`], or an error for other bytes.
    pub fn read(bytes: &[u8]) -> io::Result<String> {
        let text = match bytes.starts_with(&FRAME) {
            true => frames::unpacked(bytes, frames::LONGEST)?,
            false => bytes.to_vec(),
        };
        String::from_utf8(text).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not in UTF-8"))
    }
}

impl From<Arc<str>> for EncodedText {
    fn from(text: Arc<str>) -> Self {
        let frame = (text.len() > LONG).then(|| compressed(text.as_bytes())).flatten();
        let frame = frame.filter(|frame| frame.len() < text.len()).map(Into::into);
        EncodedText { text, frame }
    }
}

impl From<String> for EncodedText {
    fn from(text: String) -> Self {
        Arc::<str>::from(text).into()
    }
}

impl From<&str> for EncodedText {
    fn from(text: &str) -> Self {
        Arc::<str>::from(text).into()
    }
}

impl PartialEq for EncodedText {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Deref for EncodedText {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

/// None where it cannot be done: then the text is stored.
fn compressed(text: &[u8]) -> Option<Vec<u8>> {
    COMPRESSOR.with_borrow_mut(|kept| {
        if kept.is_none() {
            *kept = Compressor::new(LEVEL).ok();
        }
        let compressor = kept.as_mut()?;
        // 0: as the level has it
        let table = if text.len() <= SMALL { SMALL_TABLE } else { 0 };
        compressor.set_parameter(CParameter::HashLog(table)).ok()?;
        compressor.compress(text).ok()
    })
}

/// The response of a fit. Coefficients and prior of a long one are stored separately.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedResult {
    whole: EncodedText,
    beside: KeptBeside,
}

/// Parts of a result that are stored separately; none of one that is read at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptBeside {
    pub coefficients: Option<EncodedText>,
    pub prior: Option<EncodedText>,
}

impl EncodedResult {
    pub fn kept_parts(&self) -> &KeptBeside {
        &self.beside
    }
}

impl From<Arc<str>> for EncodedResult {
    fn from(text: Arc<str>) -> Self {
        let beside = if text.len() > READ_AT_ONCE { Told::of(&text).into() } else { KeptBeside::default() };
        EncodedResult { whole: text.into(), beside }
    }
}

impl From<Told<'_>> for KeptBeside {
    fn from(Told { coefficients, prior }: Told<'_>) -> Self {
        KeptBeside { coefficients: coefficients.map(Into::into), prior: prior.map(Into::into) }
    }
}

impl From<String> for EncodedResult {
    fn from(text: String) -> Self {
        Arc::<str>::from(text).into()
    }
}

impl From<&str> for EncodedResult {
    fn from(text: &str) -> Self {
        Arc::<str>::from(text).into()
    }
}

impl Deref for EncodedResult {
    type Target = EncodedText;

    fn deref(&self) -> &EncodedText {
        &self.whole
    }
}

/// Parts of a result in the trace, as they are in the text of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told<'a> {
    pub coefficients: Option<&'a str>,
    pub prior: Option<&'a str>,
}

#[derive(Default, Deserialize)]
struct Parts<'a> {
    #[serde(borrow)]
    coefficients: Option<&'a RawValue>,
    #[serde(borrow)]
    prior: Option<&'a RawValue>,
}

impl<'a> Told<'a> {
    pub fn of(result: &'a str) -> Self {
        Told::of_the_beginning(result).unwrap_or_else(|| Told::of_the_whole(result))
    }

    /// Answers begin with their coefficients, and few have a prior: the rest need not be read. A
    /// word in a text has its quotation marks escaped, so it is not taken for a field.
    fn of_the_beginning(result: &'a str) -> Option<Self> {
        let array = result.strip_prefix(r#"{"coefficients":"#).filter(|rest| !rest.contains(r#""prior":"#))?;
        let coefficients: &RawValue = Deserializer::from_str(array).into_iter().next()?.ok()?;
        coefficients.get().starts_with('[').then(|| Told { coefficients: Some(coefficients.get()), prior: None })
    }

    fn of_the_whole(result: &'a str) -> Self {
        let Parts { coefficients, prior } = serde_json::from_str(result).unwrap_or_default();
        Told { coefficients: coefficients.map(RawValue::get), prior: prior.map(RawValue::get) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back_whether_they_are_compressed_or_not() {
        let noise: String = (0..9000_u32).map(|i| char::from_u32(0x4e00 + i * 7919 % 20_000).unwrap()).collect();
        for text in ["", "{}", &"x".repeat(LONG), &"x".repeat(LONG + 1), &"ä1.5,".repeat(1 << 18), &noise] {
            let encoded = EncodedText::from(text);
            assert_eq!(encoded.frame.is_some(), encoded.bytes().len() < text.len());
            assert_eq!(encoded.frame.is_some(), encoded.bytes().starts_with(&FRAME));
            assert_eq!((EncodedText::read(encoded.bytes()).unwrap().as_str(), &*encoded), (text, text));
        }
        assert!(EncodedText::from("x".repeat(LONG)).frame.is_none());
        assert!(EncodedText::from("x".repeat(LONG + 1)).frame.is_some());
        assert!(EncodedText::read(&[0xff]).is_err());
        assert!(EncodedText::read(&FRAME).is_err());
        // a head with a length that no text has, and nothing behind it
        let endless = [&FRAME[..], &[0xe0], &(1_u64 << 40).to_le_bytes()].concat();
        assert!(EncodedText::read(&endless).is_err_and(|error| error.to_string().contains("1099511627776 bytes")));
    }

    #[test]
    fn the_trace_shows_coefficients_and_prior_verbatim() {
        let told = |text| {
            let Told { coefficients, prior } = Told::of(text);
            (coefficients, prior)
        };
        let all = r#"{"a":[{"coefficients":1}],"coefficients":[ 1.50,"\u0000"],"prior":{"of": 2}}"#;
        assert_eq!(told(all), (Some(r#"[ 1.50,"\u0000"]"#), Some(r#"{"of": 2}"#)));
        let prior_in_a_text = r#"{"coefficients":[ 1.50,[2]] ,"note":"\"prior\": 1","b":[3]}"#;
        assert_eq!(told(prior_in_a_text), (Some("[ 1.50,[2]]"), None));
        assert_eq!(told(r#"{"coefficients":[1],"prior":[2]}"#), (Some("[1]"), Some("[2]")));
        assert_eq!(told(r#"{"coefficients":[],"prior":null}"#), (Some("[]"), None));
        for nothing in [r#"{"coefficients":[1"#, "{}", ""] {
            assert_eq!(told(nothing), (None, None));
        }
    }

    #[test]
    fn coefficients_and_prior_of_long_results_are_kept_with_them() {
        let result = |padding| format!(r#"{{"coefficients":[{}],"prior":{{"of":1}}}}"#, "1,".repeat(padding) + "2");
        let short = EncodedResult::from(result(10_000));
        assert!(short.len() > LONG && *short.kept_parts() == KeptBeside::default());
        let long = EncodedResult::from(result(READ_AT_ONCE / 2));
        let Told { coefficients, prior } = Told::of(&long);
        let kept = long.kept_parts();
        assert_eq!((kept.coefficients.as_deref(), kept.prior.as_deref()), (coefficients, prior));
        assert!(coefficients.is_some() && prior == Some(r#"{"of":1}"#));
    }
}
