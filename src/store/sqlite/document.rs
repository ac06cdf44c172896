//! Documents as text.

use sqlx::{Decode, Sqlite, Type, error::BoxDynError, sqlite::SqliteTypeInfo};

use crate::store::shared::Document;

impl Type<Sqlite> for Document {
    fn type_info() -> SqliteTypeInfo {
        <str as Type<Sqlite>>::type_info()
    }

    fn compatible(found: &SqliteTypeInfo) -> bool {
        <str as Type<Sqlite>>::compatible(found)
    }
}

impl<'r> Decode<'r, Sqlite> for Document {
    fn decode(value: <Sqlite as sqlx::Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
        <String as Decode<'r, Sqlite>>::decode(value).map(Document)
    }
}
