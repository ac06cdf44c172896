//! A connection to either database, with the same calls for both.
//!
//! Statements name their values `$1`, `$2` … Where the databases need different statements,
//! [`Db::pick`] chooses.

use std::{
    fmt::Write as _,
    iter,
    ops::{Deref, DerefMut},
};

use futures_util::stream::BoxStream;
use sqlx::{
    Arguments as _, AssertSqlSafe, Connection as _, Database, FromRow, PgConnection, PgPool, Postgres, SqlSafeStr,
    Sqlite, SqliteConnection, SqlitePool, Transaction, pool::PoolConnection, postgres::PgRow, sqlite::SqliteRow,
};
use uuid::Uuid;

use super::{columns::Cell, value::Value};
use crate::store::postgres;

/// A row type that both databases can be read into.
pub trait Record: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin + 'static {}

impl<T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin + 'static> Record for T {}

/// A connection of its own, one of a pool, or a transaction.
pub enum Lent<D: Database> {
    Own(D::Connection),
    Pooled(PoolConnection<D>),
    Transaction(Transaction<'static, D>),
}

impl<D: Database> Deref for Lent<D> {
    type Target = D::Connection;

    fn deref(&self) -> &D::Connection {
        match self {
            Lent::Own(db) => db,
            Lent::Pooled(db) => db,
            Lent::Transaction(db) => db,
        }
    }
}

impl<D: Database> DerefMut for Lent<D> {
    fn deref_mut(&mut self) -> &mut D::Connection {
        match self {
            Lent::Own(db) => db,
            Lent::Pooled(db) => db,
            Lent::Transaction(db) => db,
        }
    }
}

/// A connection to a database.
pub enum Db {
    Sqlite(Lent<Sqlite>),
    Postgres(Lent<Postgres>),
}

impl From<SqliteConnection> for Db {
    fn from(db: SqliteConnection) -> Self {
        Db::Sqlite(Lent::Own(db))
    }
}

impl From<PgConnection> for Db {
    fn from(db: PgConnection) -> Self {
        Db::Postgres(Lent::Own(db))
    }
}

/// Connections to a database, for reads.
#[derive(Clone)]
pub enum Pool {
    Sqlite(SqlitePool),
    Postgres(PgPool),
}

impl Pool {
    /// Returns a connection for one statement.
    pub async fn connection(&self) -> Result<Db, sqlx::Error> {
        Ok(match self {
            Pool::Sqlite(pool) => Db::Sqlite(Lent::Pooled(pool.acquire().await?)),
            Pool::Postgres(pool) => Db::Postgres(Lent::Pooled(pool.acquire().await?)),
        })
    }

    /// Begins a transaction that sees one state of the database.
    pub async fn snapshot(&self) -> Result<Db, sqlx::Error> {
        Ok(match self {
            Pool::Sqlite(pool) => Db::Sqlite(Lent::Transaction(pool.begin().await?)),
            Pool::Postgres(pool) => Db::Postgres(Lent::Transaction(postgres::snapshot(pool).await?)),
        })
    }

    pub async fn close(&self) {
        match self {
            Pool::Sqlite(pool) => pool.close().await,
            Pool::Postgres(pool) => pool.close().await,
        }
    }
}

/// A statement with its values.
pub type Ready<'a> = (String, Vec<Value<'a>>);

/// Values of statements that are executed together: those of one iteration with its fit.
const FEW_VALUES: usize = 64;

/// Rows of one statement: their values are far fewer than either database takes.
const MOST_ROWS: usize = 64;

/// Does the same on either connection; `$D` is the type of its database.
macro_rules! on {
    ($db:expr, |$connection:ident: $D:ident| $then:expr) => {
        match $db {
            Db::Sqlite(lent) => {
                type $D = Sqlite;
                let $connection: &mut SqliteConnection = &mut *lent;
                $then
            }
            Db::Postgres(lent) => {
                type $D = Postgres;
                let $connection: &mut PgConnection = &mut *lent;
                $then
            }
        }
    };
}

/// Encodes the values of a statement.
pub fn encoded<D: Database>(args: &[Value<'_>]) -> Result<D::Arguments, sqlx::Error>
where
    for<'a> Value<'a>: sqlx::Encode<'a, D> + sqlx::Type<D>,
{
    let mut arguments = D::Arguments::default();
    args.iter().try_for_each(|value| arguments.add(value).map_err(sqlx::Error::Encode))?;
    Ok(arguments)
}

impl Db {
    /// Returns the statement for this database.
    pub fn pick<T>(&self, sqlite: T, postgres: T) -> T {
        match self {
            Db::Sqlite(_) => sqlite,
            Db::Postgres(_) => postgres,
        }
    }

    pub fn is_postgres(&self) -> bool {
        matches!(self, Db::Postgres(_))
    }

    /// Returns all rows.
    pub async fn all<T: Record>(&mut self, sql: impl SqlSafeStr, args: &[Value<'_>]) -> Result<Vec<T>, sqlx::Error> {
        on!(self, |db: D| sqlx::query_as_with::<D, _, _>(sql, encoded::<D>(args)?).fetch_all(db).await)
    }

    /// Returns the first row, if there is one.
    pub async fn maybe<T: Record>(
        &mut self,
        sql: impl SqlSafeStr,
        args: &[Value<'_>],
    ) -> Result<Option<T>, sqlx::Error> {
        on!(self, |db: D| sqlx::query_as_with::<D, _, _>(sql, encoded::<D>(args)?).fetch_optional(db).await)
    }

    /// Returns the only value of the only row.
    pub async fn one<T>(&mut self, sql: impl SqlSafeStr, args: &[Value<'_>]) -> Result<T, sqlx::Error>
    where
        (Cell<T>,): Record,
    {
        let (Cell(value),) =
            on!(self, |db: D| sqlx::query_as_with::<D, _, _>(sql, encoded::<D>(args)?).fetch_one(db).await)?;
        Ok(value)
    }

    /// Returns the only value of the first row, if there is one.
    pub async fn first<T>(&mut self, sql: impl SqlSafeStr, args: &[Value<'_>]) -> Result<Option<T>, sqlx::Error>
    where
        (Cell<T>,): Record,
    {
        Ok(self.maybe::<(Cell<T>,)>(sql, args).await?.map(|(Cell(value),)| value))
    }

    /// Returns whether there is a row.
    pub async fn is_there(&mut self, sql: impl SqlSafeStr, args: &[Value<'_>]) -> Result<bool, sqlx::Error> {
        on!(self, |db: D| Ok(sqlx::query_with::<D, _>(sql, encoded::<D>(args)?).fetch_optional(db).await?.is_some()))
    }

    /// Reads rows one by one.
    pub fn each<'a, T: Record>(
        &'a mut self,
        sql: impl SqlSafeStr,
        args: &[Value<'_>],
    ) -> Result<BoxStream<'a, Result<T, sqlx::Error>>, sqlx::Error> {
        on!(self, |db: D| Ok(sqlx::query_as_with::<D, _, _>(sql, encoded::<D>(args)?).fetch(db)))
    }

    /// Executes a statement and returns how many rows it changed.
    pub async fn run(&mut self, sql: impl SqlSafeStr, args: &[Value<'_>]) -> Result<u64, sqlx::Error> {
        on!(self, |db: D| Ok(sqlx::query_with::<D, _>(sql, encoded::<D>(args)?).execute(db).await?.rows_affected()))
    }

    /// Executes statements without values.
    pub async fn script(&mut self, sql: impl SqlSafeStr) -> Result<(), sqlx::Error> {
        match self {
            Db::Sqlite(db) => sqlx::raw_sql(sql).execute(&mut **db).await.map(|_| ()),
            Db::Postgres(db) => sqlx::raw_sql(sql).execute(&mut **db).await.map(|_| ()),
        }
    }

    /// Copies the write-ahead log of SQLite into the database and empties it; returns whether no
    /// reader kept it from that.
    pub async fn checkpoint(&mut self) -> Result<bool, sqlx::Error> {
        let rows: Vec<(i64, i64, i64)> = self.all("PRAGMA wal_checkpoint(TRUNCATE)", args![]).await?;
        Ok(rows.iter().all(|(busy, _, _)| *busy == 0))
    }

    /// Closes a connection of its own.
    pub async fn close(self) -> Result<(), sqlx::Error> {
        match self {
            Db::Sqlite(Lent::Own(db)) => db.close().await,
            Db::Postgres(Lent::Own(db)) => db.close().await,
            _ => Ok(()),
        }
    }

    /// Commits the transaction.
    pub async fn commit(self) -> Result<(), sqlx::Error> {
        match self {
            Db::Sqlite(Lent::Transaction(transaction)) => transaction.commit().await,
            Db::Postgres(Lent::Transaction(transaction)) => transaction.commit().await,
            mut own => own.run("COMMIT", args![]).await.map(|_| ()),
        }
    }

    /// Executes statements of which none needs the rows of another and none names its values.
    /// SQLite takes a few short ones in one text, which saves the way to its thread and back; of
    /// longer ones there would be too many different texts to keep prepared.
    pub async fn run_together(&mut self, statements: Vec<Ready<'_>>) -> Result<(), sqlx::Error> {
        let values: usize = statements.iter().map(|(_, args)| args.len()).sum();
        let statements = match self {
            Db::Sqlite(_) if !statements.is_empty() && values <= FEW_VALUES => {
                let (texts, args): (Vec<_>, Vec<_>) = statements.into_iter().unzip();
                vec![(texts.join(";"), args.into_iter().flatten().collect())]
            }
            _ => statements,
        };
        for (sql, args) in statements {
            self.run(AssertSqlSafe(sql), &args).await?;
        }
        Ok(())
    }

    /// Returns a statement with many rows: `before`, the rows as a table with the columns
    /// `column1`, `column2` …, then `after`; several for very many. The table has further rows
    /// whose values are missing, so that few different statements are prepared.
    pub fn of_rows<'a>(&self, before: &str, rows: Vec<Vec<Value<'a>>>, after: &str) -> Vec<Ready<'a>> {
        let mut rows = rows.into_iter();
        let chunks =
            iter::from_fn(|| Some(rows.by_ref().take(MOST_ROWS).collect()).filter(|rows: &Vec<_>| !rows.is_empty()));
        chunks.map(|rows| self.with_rows(before, rows, after)).collect()
    }

    /// Returns what a statement with many rows returns.
    pub async fn all_rows<T: Record>(
        &mut self,
        before: &str,
        rows: Vec<Vec<Value<'_>>>,
        after: &str,
    ) -> Result<Vec<T>, sqlx::Error> {
        let mut found = Vec::new();
        for (sql, args) in self.of_rows(before, rows, after) {
            found.extend(self.all(AssertSqlSafe(sql), &args).await?);
        }
        Ok(found)
    }

    /// Returns the statements that insert rows.
    pub fn insertion<'a>(&self, table: &str, columns: &str, rows: Vec<Vec<Value<'a>>>) -> Vec<Ready<'a>> {
        let before = format!("INSERT INTO {table} ({columns}) SELECT * FROM");
        self.of_rows(&before, rows, "WHERE column1 IS NOT NULL")
    }

    /// Inserts rows.
    pub async fn insert(&mut self, table: &str, columns: &str, rows: Vec<Vec<Value<'_>>>) -> Result<(), sqlx::Error> {
        self.run_together(self.insertion(table, columns, rows)).await
    }

    fn with_rows<'a>(&self, before: &str, rows: Vec<Vec<Value<'a>>>, after: &str) -> Ready<'a> {
        let (count, width) = (rows.len(), rows[0].len());
        let size = count.next_power_of_two();
        let kinds: Vec<_> = rows[0].iter().map(Value::kind).collect();
        let missing = kinds.iter().map(|kind| kind.none()).cycle().take((size - count) * width);
        let args = rows.into_iter().flatten().chain(missing).collect();
        let mut sql = format!("{before} (VALUES ");
        for k in 0..size * width {
            sql.push_str(if k % width > 0 {
                ", "
            } else if k > 0 {
                "), ("
            } else {
                "("
            });
            // SQLite looks each named value up among all of them, and several statements in one
            // text take the values in their order
            match self.is_postgres() {
                true => write!(sql, "${}", k + 1).unwrap_or_default(),
                false => sql.push('?'),
            }
        }
        (sql + ")) AS new " + after, args)
    }

    /// Returns all rows of a statement about ids, whose list is written `{ids}`. Each is there
    /// once.
    pub async fn of_ids<T: Record>(
        &mut self,
        sql: &str,
        ids: impl IntoIterator<Item = Uuid>,
    ) -> Result<Vec<T>, sqlx::Error> {
        let mut ids: Vec<Uuid> = ids.into_iter().collect();
        ids.sort_unstable();
        ids.dedup();
        let mut found = Vec::new();
        for ids in ids.chunks(2 * MOST_ROWS) {
            let args: Vec<Value<'_>> =
                (0..ids.len().next_power_of_two()).map(|k| ids[k.min(ids.len() - 1)].into()).collect();
            let list: Vec<String> = (1..=args.len()).map(|k| format!("${k}")).collect();
            found.extend(self.all(AssertSqlSafe(sql.replace("{ids}", &list.join(", "))), &args).await?);
        }
        Ok(found)
    }
}

/// A statement that is put together.
pub struct Statement<'a> {
    text: String,
    args: Vec<Value<'a>>,
}

impl<'a> Statement<'a> {
    pub fn new(text: &str) -> Self {
        Statement { text: text.to_owned(), args: Vec::new() }
    }

    pub fn push(&mut self, text: &str) -> &mut Self {
        self.text.push_str(text);
        self
    }

    /// Adds a value.
    pub fn bind(&mut self, value: impl Into<Value<'a>>) -> &mut Self {
        self.args.push(value.into());
        let place = self.args.len();
        write!(self.text, "${place}").unwrap_or_default();
        self
    }

    pub async fn all<T: Record>(self, db: &mut Db) -> Result<Vec<T>, sqlx::Error> {
        db.all(AssertSqlSafe(self.text), &self.args).await
    }
}
