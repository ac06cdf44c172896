//! Columns that hold more than a number or a text. A value that does not read is an error, never a
//! guess.

use std::{collections::BTreeMap, sync::Arc};

use jiff::{Timestamp, fmt::temporal::DateTimePrinter};
use sqlx::{Database, Decode, Postgres, Sqlite, Type, error::BoxDynError};

use super::error::damaged;
use crate::jobs::{
    Decision, EncodedText, Figures, JobChange, JobStatus, KeyId, RecordKind, Role, San, Scope, Scopes, StreamEvent,
    TaskState, Tenant, nodes_codec, side_named,
};
use flankfit_engine::{estimation::Nodes, gear::Side};

/// A time: a timestamptz of PostgreSQL, which counts microseconds, or the text of [`time_text`].
#[derive(Clone, Copy, Debug)]
pub struct Moment(pub Timestamp);

static PRINTER: DateTimePrinter = DateTimePrinter::new().precision(Some(6));

/// Returns a time as RFC 3339 in UTC with six decimals. It has always 27 characters, so that the
/// order of texts is the order of times.
pub fn time_text(time: Timestamp) -> String {
    PRINTER.timestamp_to_string(&time)
}

/// A count, number or version.
#[derive(Clone, Copy, Debug)]
pub struct Integer<T>(pub T);

/// SHA-256.
#[derive(Clone, Copy, Debug)]
pub struct Digest(pub [u8; 32]);

/// Names and values of a job's tags, as a JSON document.
#[derive(Clone, Debug)]
pub struct Tags(pub BTreeMap<String, String>);

impl Tags {
    /// The document of [`Tags`].
    pub fn write(tags: &BTreeMap<String, String>) -> String {
        if tags.is_empty() { "{}".to_owned() } else { serde_json::json!(tags).to_string() }
    }
}

/// A JSON document, stored as its text or, where that is long, as a frame of zstd.
#[derive(Clone, Debug)]
pub struct Document(pub String);

impl From<Document> for String {
    fn from(Document(text): Document) -> Self {
        text
    }
}

impl From<Document> for Arc<str> {
    fn from(Document(text): Document) -> Self {
        text.into()
    }
}

/// Nodes in the binary form of [`nodes_codec`].
#[derive(Clone, Debug)]
pub struct NodesColumn(pub Nodes);

/// The criterion of a fit's figures, by its name.
#[derive(Clone, Copy, Debug)]
pub struct CriterionName(pub &'static str);

/// The scheme of a fit's figures, by its name.
#[derive(Clone, Copy, Debug)]
pub struct SchemeName(pub &'static str);

#[derive(Clone, Copy, Debug)]
pub struct Flank(pub Side);

/// Reads a column of one type from what the database reads as another.
macro_rules! column {
    ($of:ty, $kind:ty, $read_as:ty $(, $generic:ident: $bound:path)?; |$value:ident| $read:expr) => {
        impl<DB: Database $(, $generic: $bound)?> Type<DB> for $of
        where
            $kind: Type<DB>,
        {
            fn type_info() -> DB::TypeInfo {
                <$kind as Type<DB>>::type_info()
            }

            fn compatible(found: &DB::TypeInfo) -> bool {
                <$kind as Type<DB>>::compatible(found)
            }
        }

        impl<'r, DB: Database $(, $generic: $bound)?> Decode<'r, DB> for $of
        where
            $read_as: Decode<'r, DB>,
        {
            fn decode(value: DB::ValueRef<'r>) -> Result<Self, BoxDynError> {
                let $value = <$read_as as Decode<'r, DB>>::decode(value)?;
                $read
            }
        }
    };
}

column!(Integer<T>, i64, i64, T: TryFrom<i64>; |value| {
    T::try_from(value).map(Integer).map_err(|_| damaged("a count", &value.to_string()).into())
});
column!(Digest, [u8], &'r [u8]; |bytes| {
    bytes.try_into().map(Digest).map_err(|_| damaged("a digest", "of another length").into())
});
column!(Tags, str, &'r str; |text| {
    serde_json::from_str(text).map(Tags).map_err(|_| damaged("a job's tags", text).into())
});
column!(Document, [u8], &'r [u8]; |bytes| {
    EncodedText::read(bytes).map(Document).map_err(|error| damaged("a document", &error.to_string()).into())
});
column!(NodesColumn, [u8], &'r [u8]; |bytes| {
    nodes_codec::decode(bytes).map(NodesColumn).map_err(|error| damaged("nodes", &error.to_string()).into())
});

/// Reads a time from what the database reads as another type.
macro_rules! time_column {
    ($Db:ty, $read_as:ty, $kind:ty, |$value:ident| $read:expr) => {
        impl Type<$Db> for Moment {
            fn type_info() -> <$Db as Database>::TypeInfo {
                <$kind as Type<$Db>>::type_info()
            }

            fn compatible(found: &<$Db as Database>::TypeInfo) -> bool {
                <$kind as Type<$Db>>::compatible(found)
            }
        }

        impl<'r> Decode<'r, $Db> for Moment {
            fn decode(value: <$Db as Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
                let $value = <$read_as as Decode<'r, $Db>>::decode(value)?;
                $read
            }
        }
    };
}

time_column!(Sqlite, &'r str, str, |text| text.parse().map(Moment).map_err(|_| damaged("a time", text).into()));
time_column!(Postgres, jiff_sqlx::Timestamp, jiff_sqlx::Timestamp, |time| Ok(Moment(time.to_jiff())));

/// Reads a column that holds one of some names.
macro_rules! name_column {
    ($of:ty, $what:literal, $named:expr) => {
        column!($of, str, &'r str; |name| $named(name).ok_or_else(|| damaged($what, name).into()));
    };
}

name_column!(Decision, "a decision", Decision::named);
name_column!(JobStatus, "a status", JobStatus::named);
name_column!(RecordKind, "a kind of record", RecordKind::named);
name_column!(StreamEvent, "an event", StreamEvent::named);
name_column!(JobChange, "what became of a job", JobChange::named);
name_column!(KeyId, "a key's id", KeyId::named);
name_column!(Tenant, "a tenant", Tenant::kept);
name_column!(Role, "a role", Role::named);
name_column!(Scopes, "scopes", Scopes::named);
name_column!(Scope, "a scope", Scope::named);
name_column!(TaskState, "a state", TaskState::named);
name_column!(San, "a name of certificates", San::named);
name_column!(Flank, "a flank", |name| side_named(name).map(Flank));
name_column!(CriterionName, "a figure's name", |name| Figures::criterion_named(name).map(CriterionName));
name_column!(SchemeName, "a figure's name", |name| Figures::scheme_named(name).map(SchemeName));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_of_times_is_fixed_and_nothing_is_lost() {
        for text in ["1970-01-01T00:00:00.000000Z", "2026-11-21T09:21:33.120000Z", "9999-12-30T22:00:00.999999Z"] {
            assert_eq!((time_text(text.parse().unwrap()).as_str(), text.len()), (text, 27));
        }
    }
}
