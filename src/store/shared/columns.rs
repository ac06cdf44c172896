//! Columns that hold more than a number or a text, of any database that has integers, texts and
//! byte strings. A value that does not read is an error, never a guess.

use std::{collections::BTreeMap, sync::Arc};

use jiff::Timestamp;
use sqlx::{Database, Decode, Type, error::BoxDynError};

use super::error::damaged;
use crate::jobs::{
    Decision, Figures, JobChange, JobStatus, KeyId, RecordKind, Role, San, Scope, Scopes, StreamEvent, TaskState,
    Tenant, nodes_codec, side_named,
};
use flankfit_engine::{estimation::Nodes, gear::Side};

/// A time. How it is written is each database's own.
#[derive(Clone, Copy, Debug)]
pub struct Moment(pub Timestamp);

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

/// A JSON document as it was written. How it is stored is each database's own.
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
column!(NodesColumn, [u8], &'r [u8]; |bytes| {
    nodes_codec::decode(bytes).map(NodesColumn).map_err(|error| damaged("nodes", &error.to_string()).into())
});

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
