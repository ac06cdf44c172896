//! Jobs as rows, to be taken elsewhere, and stored as they were.

use std::{collections::BTreeMap, fs::File, sync::Arc};

use futures_util::{StreamExt as _, TryStreamExt as _, stream::BoxStream};
use jiff::Timestamp;
use sqlx::{AssertSqlSafe, ColumnIndex, Decode, Type};
use tokio::sync::{Mutex, mpsc};
use uuid::Uuid;

use super::{
    audit_reads,
    columns::Cell,
    db::{Db, Lent, Pool},
    error::{Outcome, reported},
    value::Value as Bound,
};
use crate::{
    jobs::{
        EncodedResult, EncodedText, RepositoryFuture, Tenant,
        archive::{Column, Coming, Holdings, Key, Kind, Row, Section, TABLES, Value, given_up, keys_of},
        audit::{Chain, Verdict},
        searched_text,
    },
    store::postgres,
};

/// How the rows of each of [`TABLES`] are stored: their table, the columns of their key that the
/// rows do not have, other names of columns, and the order in which they are read.
struct Stored {
    table: &'static str,
    of: &'static str,
    order: &'static str,
}

/// In the order of [`TABLES`].
const STORED: [Stored; 13] = [
    Stored { table: "jobs", of: "id", order: "id" },
    Stored { table: "iterations", of: "job", order: "number" },
    Stored { table: "nodes", of: "job", order: "number" },
    Stored { table: "fits", of: "job", order: "number, position" },
    Stored { table: "fit_choices", of: "job", order: "number, position" },
    Stored { table: "decisions", of: "job", order: "number, position" },
    Stored { table: "records", of: "job", order: "number, position" },
    Stored { table: "streams", of: "job", order: "id" },
    Stored { table: "stream_blocks", of: "", order: "stream, sequence" },
    Stored { table: "stream_states", of: "", order: "stream" },
    Stored { table: "events", of: "job", order: "number" },
    Stored { table: "audit", of: "chain", order: "number" },
    Stored { table: "purges", of: "job", order: "at" },
];

/// Returns the statement that reads the rows of a table of the job whose id and tenant are its
/// values.
fn read_statement(table: usize) -> String {
    let (Stored { table: name, of, order }, columns) = (&STORED[table], names(table));
    match *name {
        "jobs" | "audit" => format!("SELECT {columns} FROM {name} WHERE {of} = $1 AND tenant = $2 ORDER BY {order}"),
        _ => {
            let job = "(SELECT id FROM jobs WHERE id = $1 AND tenant = $2)";
            let of = match *of {
                "" => format!("stream IN (SELECT id FROM streams WHERE job = {job})"),
                of => format!("{of} = {job}"),
            };
            format!("SELECT {columns} FROM {name} WHERE {of} ORDER BY {order}")
        }
    }
}

fn names(table: usize) -> String {
    TABLES[table].columns.iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
}

/// The triggers of PostgreSQL that write events, and their tables.
const EVENTS: [(&str, &str); 9] = [
    ("iterations", "events_of_iterations"),
    ("fits", "events_of_fits"),
    ("fit_choices", "events_of_choices"),
    ("decisions", "events_of_decisions"),
    ("streams", "events_of_new_streams"),
    ("purges", "events_of_purges"),
    ("records", "events_of_records"),
    ("jobs", "events_of_new_jobs"),
    ("events", "events_of_all"),
];

/// For a transaction, whatever the session's limits are.
const UNHURRIED: &str = "SET LOCAL statement_timeout = 0; SET LOCAL idle_in_transaction_session_timeout = 0";

/// The jobs of a database.
pub struct SqlHoldings {
    readers: Pool,
    /// The connection to a file, while it is written. (PostgreSQL is written by those of the pool.)
    writer: Mutex<Option<Db>>,
    /// No server writes the file meanwhile.
    _lock: Option<File>,
}

impl SqlHoldings {
    /// Makes holdings that can be read; those of PostgreSQL can be written too, by an owner of the
    /// tables.
    pub fn read_only(readers: Pool) -> Self {
        SqlHoldings { readers, writer: Mutex::default(), _lock: None }
    }

    /// Makes holdings of a file that can be written.
    pub fn of_file(readers: Pool, writer: Db, lock: Option<File>) -> Self {
        SqlHoldings { readers, writer: Mutex::new(Some(writer)), _lock: lock }
    }

    async fn read_keys(&self) -> Outcome<Vec<Key>> {
        let sql = "SELECT tenant, id FROM jobs UNION SELECT tenant, chain FROM audit";
        let keys: Vec<(Cell<Tenant>, Uuid)> = self.readers.connection().await?.all(sql, args![]).await?;
        Ok(keys_of(keys.into_iter().map(|(Cell(tenant), job)| (tenant, job)).collect()))
    }

    async fn store(&self, key: &Key, from: mpsc::Receiver<Coming>) -> Outcome<()> {
        if let Pool::Postgres(pool) = &self.readers {
            let mut db = Db::Postgres(Lent::Transaction(postgres::begin(pool, "BEGIN").await?));
            store_in(&mut db, key, from).await?;
            return Ok(db.commit().await?);
        }
        let mut writer = self.writer.lock().await;
        let Some(db) = writer.as_mut() else { return Err(given_up("it was opened to be read").into()) };
        db.run("BEGIN IMMEDIATE", args![]).await?;
        let stored = store_in(db, key, from).await;
        db.run(if stored.is_ok() { "COMMIT" } else { "ROLLBACK" }, args![]).await?;
        stored
    }

    /// Copies the log into the database, which is whole without it then. Readers of the database
    /// are waited for as for any write; the connection that closes last takes the log away.
    async fn end(&self) -> Outcome<bool> {
        if let Pool::Sqlite(readers) = &self.readers {
            readers.close().await;
        }
        let Some(mut writer) = self.writer.lock().await.take() else { return Ok(true) };
        let emptied = writer.checkpoint().await?;
        writer.close().await?;
        Ok(emptied)
    }

    async fn send(&self, key: &Key, to: mpsc::Sender<Row>) -> Outcome<()> {
        let mut db = self.readers.snapshot().await?;
        if db.is_postgres() {
            // as long as a job takes that is long
            db.script(UNHURRIED).await?;
        }
        for table in 0..TABLES.len() {
            let mut rows = rows(&mut db, table, key)?;
            while let Some(row) = rows.try_next().await? {
                if to.send(row).await.is_err() {
                    // the rest is not needed
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}

/// Stores the rows of a job in a transaction.
async fn store_in(db: &mut Db, key: &Key, mut from: mpsc::Receiver<Coming>) -> Outcome<()> {
    // triggers would write the events a second time
    let triggers = drop_triggers(db).await?;
    let told = loop {
        match from.recv().await {
            Some(Coming::Row(row)) => insert(db, key, row).await?,
            Some(Coming::All(told)) => break told,
            // reading ended before its end: the transaction is given up
            None => return Err(given_up("not all of its rows came").into()),
        }
    };
    db.script(AssertSqlSafe(triggers)).await?;
    let (mut section, _) = Section::begin(key);
    for table in 0..TABLES.len() {
        let mut rows = rows(db, table, key)?;
        while let Some(row) = rows.try_next().await? {
            section.row(&row);
        }
    }
    if section.end() != told {
        return Err(given_up("what would be stored is not what came").into());
    }
    let chain = Chain::Job(key.job);
    if let Verdict::Broken { number, what } = audit_reads::verify(db, &key.tenant, chain, BTreeMap::new()).await? {
        return Err(given_up(&format!("its audit is broken at entry {number}: {}", what.name())).into());
    }
    Ok(())
}

/// Keeps triggers from writing events; returns the statements that bring them back.
async fn drop_triggers(db: &mut Db) -> Outcome<String> {
    let (off, on) = if db.is_postgres() {
        let each = |how: &str| EVENTS.map(|(table, trigger)| format!("ALTER TABLE {table} {how} TRIGGER {trigger};"));
        (each("DISABLE").concat(), each("ENABLE").concat())
    } else {
        let sql =
            "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' AND name LIKE 'events_of_%' ORDER BY name";
        let triggers: Vec<(String, String)> = db.all(sql, args![]).await?;
        let off = triggers.iter().map(|(name, _)| format!("DROP TRIGGER \"{name}\";")).collect();
        (off, triggers.into_iter().map(|(_, sql)| sql + ";").collect())
    };
    db.script(AssertSqlSafe(off)).await?;
    Ok(on)
}

/// Reads the rows of a table of a job.
fn rows<'a>(db: &'a mut Db, table: usize, key: &Key) -> Outcome<BoxStream<'a, Result<Row, sqlx::Error>>> {
    let sql = AssertSqlSafe(read_statement(table));
    let (job, tenant) = (key.job, key.tenant.as_str().to_owned());
    Ok(match db {
        Db::Sqlite(db) => {
            let rows = sqlx::query(sql).bind(job).bind(tenant).fetch(&mut **db);
            rows.map(move |row| read_row(table, &row?)).boxed()
        }
        Db::Postgres(db) => {
            let rows = sqlx::query(sql).bind(job).bind(tenant).fetch(&mut **db);
            rows.map(move |row| read_row(table, &row?)).boxed()
        }
    })
}

fn read_row<'r, R: sqlx::Row>(table: usize, row: &'r R) -> Result<Row, sqlx::Error>
where
    usize: ColumnIndex<R>,
    Option<i64>: Decode<'r, R::Database> + Type<R::Database>,
    Option<f64>: Decode<'r, R::Database> + Type<R::Database>,
    Option<String>: Decode<'r, R::Database> + Type<R::Database>,
    Cell<Option<Arc<str>>>: Decode<'r, R::Database> + Type<R::Database>,
    Option<Vec<u8>>: Decode<'r, R::Database> + Type<R::Database>,
    Option<Uuid>: Decode<'r, R::Database> + Type<R::Database>,
    Cell<Option<Timestamp>>: Decode<'r, R::Database> + Type<R::Database>,
{
    let column = |(k, column): (usize, &Column)| {
        Ok(match column.kind {
            Kind::Integer => row.try_get::<Option<i64>, _>(k)?.map(Value::Integer),
            Kind::Real => row.try_get::<Option<f64>, _>(k)?.map(Value::Real),
            Kind::Text => row.try_get::<Option<String>, _>(k)?.map(Value::Text),
            Kind::Document => row.try_get::<Cell<Option<Arc<str>>>, _>(k)?.0.map(|text| Value::Text(text.to_string())),
            Kind::Bytes => row.try_get::<Option<Vec<u8>>, _>(k)?.map(Value::Bytes),
            Kind::Id => row.try_get::<Option<Uuid>, _>(k)?.map(Value::Id),
            Kind::Time => row.try_get::<Cell<Option<Timestamp>>, _>(k)?.0.map(Value::Time),
        }
        .unwrap_or(Value::Null))
    };
    let values = TABLES[table].columns.iter().enumerate().map(column).collect::<Result<_, sqlx::Error>>()?;
    Ok(Row { table, values })
}

/// Returns a value of a column. A statement takes each by its type, also where it is missing.
fn bound(kind: Kind, value: &Value) -> Bound<'_> {
    match (kind, value) {
        (_, Value::Integer(number)) => (*number).into(),
        (_, Value::Real(number)) => (*number).into(),
        (Kind::Document, Value::Text(text)) => Bound::document(text),
        (_, Value::Text(text)) => text.into(),
        (_, Value::Bytes(bytes)) => bytes.into(),
        (_, Value::Id(id)) => id.into(),
        (_, Value::Time(at)) => (*at).into(),
        (Kind::Integer, Value::Null) => Bound::Integer(None),
        (Kind::Real, Value::Null) => Bound::Real(None),
        (Kind::Text, Value::Null) => Bound::Text(None),
        (Kind::Bytes | Kind::Document, Value::Null) => Bound::Bytes(None),
        (Kind::Id, Value::Null) => Bound::Id(None),
        (Kind::Time, Value::Null) => Bound::Time(None),
    }
}

/// Returns the text by which a job is searched.
fn searched(row: &Row) -> String {
    let text = |name: &str| match row.value(name) {
        Some(Value::Text(text)) => Some(text.as_str()),
        _ => None,
    };
    let fields = ["name", "part_number", "serial_number", "machine"].map(text);
    let tags = text("tags").and_then(|tags| serde_json::from_str(tags).ok()).unwrap_or_default();
    searched_text(fields, &tags)
}

async fn insert(db: &mut Db, key: &Key, row: Row) -> Outcome<()> {
    let Stored { table, of, .. } = &STORED[row.table];
    let mut columns = names(row.table);
    let mut values: Vec<Bound<'_>> =
        row.table().columns.iter().zip(&row.values).map(|(column, value)| bound(column.kind, value)).collect();
    let mut add = |name: &str, value| {
        columns = format!("{columns}, {name}");
        values.push(value);
    };
    if !of.is_empty() {
        add(of, key.job.into());
    }
    match (*table, row.values.last()) {
        ("jobs", _) => {
            add("tenant", (&key.tenant).into());
            add("folded", searched(&row).into());
        }
        ("audit", _) => add("tenant", (&key.tenant).into()),
        ("fits", Some(Value::Text(result))) => {
            let encoded = EncodedResult::from(result.as_str());
            let beside = encoded.kept_beside();
            let bytes =
                |text: &Option<EncodedText>| Bound::Bytes(text.as_ref().map(|text| text.bytes().to_vec().into()));
            add("coefficients", bytes(&beside.coefficients));
            add("prior", bytes(&beside.prior));
        }
        ("stream_blocks" | "stream_states", _) => {
            let sql = "SELECT 1 FROM streams WHERE id = $1 AND job = $2";
            if !db.is_there(sql, &[values[0].clone(), key.job.into()]).await? {
                return Err(given_up(&format!("a row ({}) belongs to none before it", row.table().name)).into());
            }
        }
        _ => {}
    }
    Ok(db.insert(table, &columns, &[values]).await?)
}

impl Holdings for SqlHoldings {
    fn keys(&self) -> RepositoryFuture<'_, Vec<Key>> {
        Box::pin(async move { self.read_keys().await.map_err(reported) })
    }

    fn read(&self, key: Key, to: mpsc::Sender<Row>) -> RepositoryFuture<'_, ()> {
        Box::pin(async move { self.send(&key, to).await.map_err(reported) })
    }

    fn write(&self, key: Key, from: mpsc::Receiver<Coming>) -> RepositoryFuture<'_, ()> {
        Box::pin(async move { self.store(&key, from).await.map_err(reported) })
    }

    fn close(&self) -> RepositoryFuture<'_, bool> {
        Box::pin(async { self.end().await.map_err(reported) })
    }
}
