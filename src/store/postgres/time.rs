//! Times as timestamptz, which counts microseconds.

use jiff::Timestamp;
use jiff_sqlx::ToSqlx as _;
use sqlx::{Decode, Postgres, Type, error::BoxDynError, postgres::PgTypeInfo};

use crate::store::shared::Moment;

/// A time as a value of a statement.
pub fn stamp(time: Timestamp) -> jiff_sqlx::Timestamp {
    time.to_sqlx()
}

impl Type<Postgres> for Moment {
    fn type_info() -> PgTypeInfo {
        <jiff_sqlx::Timestamp as Type<Postgres>>::type_info()
    }
}

impl<'r> Decode<'r, Postgres> for Moment {
    fn decode(value: <Postgres as sqlx::Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
        <jiff_sqlx::Timestamp as Decode<'r, Postgres>>::decode(value).map(|time| Moment(time.to_jiff()))
    }
}
