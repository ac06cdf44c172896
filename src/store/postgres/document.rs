//! Documents as their text, or as a frame of zstd where that is long.

use serde::Deserialize;
use serde_json::value::RawValue;
use sqlx::{Decode, Postgres, Type, error::BoxDynError, postgres::PgTypeInfo};

use crate::store::shared::{Document, damaged};

/// Longer texts are compressed.
const LONG: usize = 8 << 10;
/// What frames of zstd begin with; its second byte begins no letter of UTF-8.
const FRAME: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// The bytes that are stored of a text.
pub fn encode(text: &str) -> Vec<u8> {
    let compressed =
        (text.len() > LONG).then(|| zstd::bulk::compress(text.as_bytes(), zstd::DEFAULT_COMPRESSION_LEVEL));
    match compressed {
        Some(Ok(frame)) if frame.len() < text.len() => frame,
        _ => text.as_bytes().to_vec(),
    }
}

/// The text of [`encode`].
fn decode(bytes: &[u8]) -> Result<String, BoxDynError> {
    let text = match bytes.starts_with(&FRAME) {
        true => zstd::stream::decode_all(bytes)?,
        false => bytes.to_vec(),
    };
    String::from_utf8(text).map_err(|_| damaged("a document", "not in UTF-8").into())
}

impl Type<Postgres> for Document {
    fn type_info() -> PgTypeInfo {
        <[u8] as Type<Postgres>>::type_info()
    }
}

impl<'r> Decode<'r, Postgres> for Document {
    fn decode(value: <Postgres as sqlx::Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
        decode(<&[u8] as Decode<'r, Postgres>>::decode(value)?).map(Document)
    }
}

/// What the trace tells of a result, as it stands there.
#[derive(Default, Deserialize)]
pub struct Told<'a> {
    #[serde(borrow)]
    coefficients: Option<&'a RawValue>,
    #[serde(borrow)]
    prior: Option<&'a RawValue>,
}

impl<'a> Told<'a> {
    pub fn of(result: &'a str) -> Self {
        serde_json::from_str(result).unwrap_or_default()
    }

    /// Whether it tells this.
    pub fn is(&self, coefficients: Option<&Document>, prior: Option<&Document>) -> bool {
        let same = |told: Option<&RawValue>, stored: Option<&Document>| {
            told.map(RawValue::get) == stored.map(|Document(text)| text.as_str())
        };
        same(self.coefficients, coefficients) && same(self.prior, prior)
    }

    pub fn coefficients(&self) -> Option<Vec<u8>> {
        self.coefficients.map(|value| encode(value.get()))
    }

    pub fn prior(&self) -> Option<Vec<u8>> {
        self.prior.map(|value| encode(value.get()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back_whether_they_are_compressed_or_not() {
        let noise: String = (0..9000_u32).map(|i| char::from_u32(0x4e00 + i * 7919 % 20_000).unwrap()).collect();
        for text in ["", "{}", &"x".repeat(LONG), &"x".repeat(LONG + 1), &noise] {
            let bytes = encode(text);
            assert_eq!(bytes.starts_with(&FRAME), bytes.len() < text.len());
            assert_eq!(decode(&bytes).unwrap(), text);
        }
        assert!(encode(&"x".repeat(LONG + 1)).starts_with(&FRAME));
        assert!(decode(&[0xff]).is_err());
        assert!(decode(&FRAME).is_err());
    }

    #[test]
    fn what_the_trace_tells_is_as_it_was_answered() {
        let told = Told::of(r#"{"a":[{"coefficients":1}],"coefficients":[ 1.50,"\u0000"],"prior":{"of": 2}}"#);
        assert_eq!(told.coefficients().unwrap(), br#"[ 1.50,"\u0000"]"#);
        assert_eq!(told.prior().unwrap(), br#"{"of": 2}"#);
        assert!(Told::of("{}").coefficients().is_none());
        assert!(Told::of(r#"{"coefficients":[],"prior":null}"#).prior().is_none());
    }
}
