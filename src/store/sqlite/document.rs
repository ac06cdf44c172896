//! Documents as text, or as a frame of zstd where a column of its own has one.

use sqlx::{
    Decode, Sqlite, Type, TypeInfo as _, ValueRef as _,
    error::BoxDynError,
    sqlite::{SqliteTypeInfo, SqliteValueRef},
};

use crate::{
    jobs::EncodedText,
    store::shared::{Document, damaged},
};

/// The result of a fit, in the form in which it is stored.
macro_rules! result_column {
    () => {
        "coalesce(frame, result)"
    };
}
pub(super) use result_column;

impl Type<Sqlite> for Document {
    fn type_info() -> SqliteTypeInfo {
        <str as Type<Sqlite>>::type_info()
    }

    fn compatible(found: &SqliteTypeInfo) -> bool {
        <str as Type<Sqlite>>::compatible(found) || <[u8] as Type<Sqlite>>::compatible(found)
    }
}

impl<'r> Decode<'r, Sqlite> for Document {
    fn decode(value: SqliteValueRef<'r>) -> Result<Self, BoxDynError> {
        if value.type_info().name() != "BLOB" {
            return <String as Decode<'r, Sqlite>>::decode(value).map(Document);
        }
        let bytes = <&[u8] as Decode<'r, Sqlite>>::decode(value)?;
        EncodedText::read(bytes).map(Document).map_err(|error| damaged("a document", &error.to_string()).into())
    }
}
