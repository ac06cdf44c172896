//! Documents as their text, or as a frame of zstd where that is long.

use sqlx::{Decode, Postgres, Type, error::BoxDynError, postgres::PgTypeInfo};

use crate::{
    jobs::EncodedText,
    store::shared::{Document, damaged},
};

/// The bytes that are stored of a text.
pub fn encode(text: &str) -> Vec<u8> {
    EncodedText::from(text).bytes().to_vec()
}

impl Type<Postgres> for Document {
    fn type_info() -> PgTypeInfo {
        <[u8] as Type<Postgres>>::type_info()
    }
}

impl<'r> Decode<'r, Postgres> for Document {
    fn decode(value: <Postgres as sqlx::Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
        let bytes = <&[u8] as Decode<'r, Postgres>>::decode(value)?;
        EncodedText::read(bytes).map(Document).map_err(|error| damaged("a document", &error.to_string()).into())
    }
}
