//! Rows of the tables that the audit and the archive know, read by the columns of these.

use futures_util::{StreamExt as _, stream::BoxStream};
use sqlx::{AssertSqlSafe, ColumnIndex, Decode, Postgres, Sqlite, Type};

use super::{columns::Document, db::encoded, prelude::*};
use crate::jobs::rows::{Kind, Row, Table};

impl Db {
    /// Returns the rows of a table by a condition and what follows it. An error of one row, which
    /// cannot be read, does not end them.
    pub fn rows<'a>(
        &'a mut self,
        table: &'static Table,
        condition: &str,
        args: &[Value<'_>],
    ) -> Result<BoxStream<'a, Result<Row, sqlx::Error>>, sqlx::Error> {
        let sql = AssertSqlSafe(format!("SELECT {} FROM {} WHERE {condition}", table.list(), table.name));
        Ok(match self {
            Db::Sqlite(db) => {
                let rows = sqlx::query_with::<Sqlite, _>(sql, encoded::<Sqlite>(args)?).fetch(&mut **db);
                rows.map(move |row| read(table, &row?)).boxed()
            }
            Db::Postgres(db) => {
                let rows = sqlx::query_with::<Postgres, _>(sql, encoded::<Postgres>(args)?).fetch(&mut **db);
                rows.map(move |row| read(table, &row?)).boxed()
            }
        })
    }
}

fn read<'r, R: sqlx::Row>(table: &'static Table, row: &'r R) -> Result<Row, sqlx::Error>
where
    usize: ColumnIndex<R>,
    bool: Decode<'r, R::Database> + Type<R::Database>,
    Option<i64>: Decode<'r, R::Database> + Type<R::Database>,
    Option<f64>: Decode<'r, R::Database> + Type<R::Database>,
    Option<String>: Decode<'r, R::Database> + Type<R::Database>,
    Option<Vec<u8>>: Decode<'r, R::Database> + Type<R::Database>,
    Option<Uuid>: Decode<'r, R::Database> + Type<R::Database>,
    Option<Document>: Decode<'r, R::Database> + Type<R::Database>,
    Cell<Option<Timestamp>>: Decode<'r, R::Database> + Type<R::Database>,
{
    let value = |(k, kind)| {
        Ok(match kind {
            Kind::Flag => Value::Flag(row.try_get(k)?),
            Kind::Integer => Value::Integer(row.try_get(k)?),
            Kind::Real => Value::Real(row.try_get(k)?),
            Kind::Text => Value::Text(row.try_get::<Option<String>, _>(k)?.map(Into::into)),
            Kind::Bytes => Value::Bytes(row.try_get::<Option<Vec<u8>>, _>(k)?.map(Into::into)),
            Kind::Id => Value::Id(row.try_get(k)?),
            Kind::Time => Value::Time(row.try_get::<Cell<Option<Timestamp>>, _>(k)?.0),
            Kind::Document => Value::Document(row.try_get::<Option<Document>, _>(k)?.map(|text| text.0.into())),
        })
    };
    let values = table.columns.iter().map(|column| column.kind).enumerate().map(value);
    Ok(Row { table, values: values.collect::<Result<_, sqlx::Error>>()? })
}
