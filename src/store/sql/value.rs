//! Values of statements, encoded as each database stores them.

use std::sync::Arc;

use jiff::Timestamp;
use jiff_sqlx::ToSqlx as _;
use sqlx::{Database, Encode, Postgres, Sqlite, Type, encode::IsNull, error::BoxDynError};
use uuid::Uuid;

pub use crate::jobs::rows::Value;
use crate::jobs::{EncodedText, KeyId, Tenant, audit::time_text};

impl Value<'_> {
    /// Returns the stored form of a document.
    pub fn document(text: &str) -> Self {
        Value::Document(Some(text.into()))
    }
}

/// Databases have signed integers; versions and counts are far below 2⁶³, and a greater cursor is
/// after every row.
pub fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// Makes values of types, and of these types where they may be missing.
macro_rules! values {
    ($($of:ty => $Variant:ident, |$value:ident| $into:expr;)*) => {
        $(impl<'a> From<$of> for Value<'a> {
            fn from($value: $of) -> Self {
                Value::$Variant(Some($into))
            }
        }

        impl<'a> From<Option<$of>> for Value<'a> {
            fn from(value: Option<$of>) -> Self {
                Value::$Variant(value.map(|$value| $into))
            }
        })*
    };
}

values! {
    i64 => Integer, |value| value;
    u8 => Integer, |value| value.into();
    u16 => Integer, |value| value.into();
    u32 => Integer, |value| value.into();
    u64 => Integer, |value| signed(value);
    usize => Integer, |value| signed(value as u64);
    f64 => Real, |value| value;
    &'a str => Text, |value| value.into();
    &'a String => Text, |value| value.as_str().into();
    &'a Arc<str> => Text, |value| (&**value).into();
    String => Text, |value| value.into();
    &'a Tenant => Text, |value| value.as_str().into();
    KeyId => Text, |value| value.to_string().into();
    &'a [u8] => Bytes, |value| value.into();
    &'a Vec<u8> => Bytes, |value| value.as_slice().into();
    &'a [u8; 32] => Bytes, |value| value.as_slice().into();
    &'a EncodedText => Document, |value| value.clone();
    Uuid => Id, |value| value;
    &'a Uuid => Id, |value| *value;
    Timestamp => Time, |value| value;
    bool => Flag, |value| value;
}

/// Returns the values of a statement, each of a type of its own.
macro_rules! args {
    ($($value:expr),* $(,)?) => {
        &[$($crate::store::sql::Value::from($value)),*]
    };
}

/// Encodes a value by the type of its variant.
macro_rules! encode {
    ($Db:ty, $Time:ty, |$at:ident| $time:expr) => {
        impl Type<$Db> for Value<'_> {
            fn type_info() -> <$Db as Database>::TypeInfo {
                <str as Type<$Db>>::type_info()
            }
        }

        impl<'q> Encode<'q, $Db> for Value<'_> {
            fn encode_by_ref(&self, to: &mut <$Db as Database>::ArgumentBuffer) -> Result<IsNull, BoxDynError> {
                match self {
                    Value::Flag(value) => Encode::<$Db>::encode(*value, to),
                    Value::Integer(value) => Encode::<$Db>::encode(*value, to),
                    Value::Real(value) => Encode::<$Db>::encode(*value, to),
                    Value::Text(value) => Encode::<$Db>::encode(value.as_deref(), to),
                    Value::Bytes(value) => Encode::<$Db>::encode(value.as_deref(), to),
                    Value::Document(value) => Encode::<$Db>::encode(value.as_ref().map(EncodedText::bytes), to),
                    Value::Id(value) => Encode::<$Db>::encode(*value, to),
                    Value::Time(value) => Encode::<$Db>::encode(value.map(|$at| $time), to),
                }
            }

            fn produces(&self) -> Option<<$Db as Database>::TypeInfo> {
                Some(match self {
                    Value::Flag(_) => <bool as Type<$Db>>::type_info(),
                    Value::Integer(_) => <i64 as Type<$Db>>::type_info(),
                    Value::Real(_) => <f64 as Type<$Db>>::type_info(),
                    Value::Text(_) => <str as Type<$Db>>::type_info(),
                    Value::Bytes(_) | Value::Document(_) => <[u8] as Type<$Db>>::type_info(),
                    Value::Id(_) => <Uuid as Type<$Db>>::type_info(),
                    Value::Time(_) => <$Time as Type<$Db>>::type_info(),
                })
            }
        }
    };
}

encode!(Sqlite, String, |at| time_text(at));
encode!(Postgres, jiff_sqlx::Timestamp, |at| at.to_sqlx());
