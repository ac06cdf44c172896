//! Types of the domain as columns. A value that does not read is an error, never a guess.

use std::{borrow::Cow, collections::BTreeMap, sync::Arc};

use jiff::{Timestamp, civil::Date};
use sqlx::{ColumnIndex, Database, Decode, Postgres, Row, Sqlite, Type, error::BoxDynError};
use uuid::Uuid;

use super::error::damaged;
use crate::jobs::{
    Decision, EncodedText, Figures, JobChange, JobGear, JobStatus, KeyId, RecordKind, Role, San, Scopes, StreamEvent,
    Tenant, audit::Contents, nodes_codec, side_named,
};
use flankfit_engine::{estimation::Nodes, gear::Side};

/// Returns the document of a job's tags.
pub fn tags_text(tags: &BTreeMap<String, String>) -> String {
    if tags.is_empty() { "{}".to_owned() } else { serde_json::json!(tags).to_string() }
}

/// A type that a column is read into.
pub trait Column: Sized {
    /// The type that the database reads it as.
    type Read;

    fn of(read: Self::Read) -> Result<Self, BoxDynError>;
}

/// A column.
pub struct Cell<T>(pub T);

/// Returns a column of a row by its name.
pub fn column<'r, R: Row, T: Column>(row: &'r R, name: &'static str) -> Result<T, sqlx::Error>
where
    &'static str: ColumnIndex<R>,
    Cell<T>: Decode<'r, R::Database> + Type<R::Database>,
{
    row.try_get::<Cell<T>, _>(name).map(|cell| cell.0)
}

impl<DB: Database, T: Column<Read: Type<DB>>> Type<DB> for Cell<T> {
    fn type_info() -> DB::TypeInfo {
        T::Read::type_info()
    }

    fn compatible(found: &DB::TypeInfo) -> bool {
        T::Read::compatible(found)
    }
}

impl<'r, DB: Database, T: Column<Read: Decode<'r, DB>>> Decode<'r, DB> for Cell<T> {
    fn decode(value: DB::ValueRef<'r>) -> Result<Self, BoxDynError> {
        T::of(T::Read::decode(value)?).map(Cell)
    }
}

impl<T: Column> Column for Option<T> {
    type Read = Option<T::Read>;

    fn of(read: Self::Read) -> Result<Self, BoxDynError> {
        read.map(T::of).transpose()
    }
}

/// A time: a timestamptz of PostgreSQL, which counts microseconds, or its text
/// (`audit::time_text`).
pub struct Moment(Timestamp);

/// A JSON document, stored as its text or, where that is long, as a frame of zstd.
pub struct Document(pub String);

/// Reads what the databases store in different forms.
macro_rules! forms {
    ($Db:ty, $Time:ty, $time_kind:ty, |$value:ident| $time:expr) => {
        impl Type<$Db> for Moment {
            fn type_info() -> <$Db as Database>::TypeInfo {
                <$time_kind as Type<$Db>>::type_info()
            }

            fn compatible(found: &<$Db as Database>::TypeInfo) -> bool {
                <$time_kind as Type<$Db>>::compatible(found)
            }
        }

        impl<'r> Decode<'r, $Db> for Moment {
            fn decode(value: <$Db as Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
                let $value = <$Time as Decode<'r, $Db>>::decode(value)?;
                $time
            }
        }

        impl Type<$Db> for Document {
            fn type_info() -> <$Db as Database>::TypeInfo {
                <[u8] as Type<$Db>>::type_info()
            }

            fn compatible(found: &<$Db as Database>::TypeInfo) -> bool {
                <[u8] as Type<$Db>>::compatible(found) || <str as Type<$Db>>::compatible(found)
            }
        }

        impl<'r> Decode<'r, $Db> for Document {
            fn decode(value: <$Db as Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
                let bytes = <&[u8] as Decode<'r, $Db>>::decode(value)?;
                EncodedText::read(bytes).map(Document).map_err(|error| damaged("a document", &error.to_string()).into())
            }
        }
    };
}

forms!(Sqlite, &'r str, str, |text| text.parse().map(Moment).map_err(|_| damaged("a time", text).into()));
forms!(Postgres, jiff_sqlx::Timestamp, jiff_sqlx::Timestamp, |time| Ok(Moment(time.to_jiff())));

/// Reads columns of types.
macro_rules! columns {
    ($($Of:ty: $Read:ty, |$value:ident| $of:expr;)*) => {
        $(impl Column for $Of {
            type Read = $Read;

            fn of($value: $Read) -> Result<Self, BoxDynError> {
                $of
            }
        })*
    };
}

/// Reads columns that the database reads as they are.
macro_rules! plain {
    ($($Of:ty),*) => {
        columns! { $($Of: $Of, |value| Ok(value);)* }
    };
}

/// Reads counts, numbers and versions.
macro_rules! integers {
    ($($Of:ty),*) => {
        columns! { $($Of: i64, |value| value.try_into().map_err(|_| damaged("a count", &value.to_string()).into());)* }
    };
}

/// Reads columns that hold one of some names.
macro_rules! names {
    ($($Of:ty, $what:literal, $named:expr;)*) => {
        columns! { $($Of: String, |name| $named(&name).ok_or_else(|| damaged($what, &name).into());)* }
    };
}

plain!(i64, f64, bool, String, Vec<u8>, Uuid);

integers!(u8, u16, u32, u64, usize);

columns! {
    Timestamp: Moment, |time| Ok(time.0);
    Arc<str>: Document, |text| Ok(text.0.into());
    Cow<'static, str>: String, |text| Ok(text.into());
    JobGear: String, |text| Ok(text.into());
    BTreeMap<String, String>: String, |text| {
        serde_json::from_str(&text).map_err(|_| damaged("a job's tags", &text).into())
    };
    Nodes: Vec<u8>, |bytes| {
        nodes_codec::decode(&bytes).map_err(|error| damaged("nodes", &error).into())
    };
    Date: String, |text| text.parse().map_err(|_| damaged("a day", &text).into());
    Contents: Vec<u8>, |bytes| Contents::read(&bytes).ok_or_else(|| damaged("an entry", "of the audit").into());
}

impl<const N: usize> Column for [u8; N] {
    type Read = Vec<u8>;

    fn of(bytes: Vec<u8>) -> Result<Self, BoxDynError> {
        bytes.try_into().map_err(|_| damaged("a digest", "of another length").into())
    }
}

names! {
    Decision, "a decision", Decision::named;
    JobStatus, "a status", JobStatus::named;
    RecordKind, "a kind of record", RecordKind::named;
    StreamEvent, "an event", StreamEvent::named;
    JobChange, "a change of a job", JobChange::named;
    KeyId, "a key's id", KeyId::named;
    Tenant, "a tenant", Tenant::kept;
    Role, "a role", Role::named;
    Scopes, "scopes", Scopes::named;
    San, "a name of certificates", San::named;
    Side, "a flank", side_named;
    // of a criterion or a scheme of figures
    &'static str, "a figure's name", |name| Figures::criterion_named(name).or_else(|| Figures::scheme_named(name));
}
