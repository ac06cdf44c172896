//! Jobs as rows, to be taken elsewhere, and stored as they were.

use std::fs::File;

use futures_util::TryStreamExt as _;
use sqlx::AssertSqlSafe;
use tokio::sync::{Mutex, mpsc};

use super::{
    audit,
    auditor::verify_rows,
    db::{Lent, Pool},
    error::{reading, reported},
    prelude::*,
    subject,
};
use crate::{
    jobs::{
        Clock as _,
        archive::{Holdings, Key, Rows},
        audit::By,
        rows::{ENTRIES, OF_JOBS, Row},
    },
    store::postgres,
};

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

/// Gives a job the class of the evaluation that was made last.
const CLASS: &str = "UPDATE jobs SET class = (
    SELECT r.class FROM events e JOIN records r ON r.job = e.job AND r.number = e.iteration AND r.id = e.record
    WHERE e.job = jobs.id AND r.kind = 'evaluation' ORDER BY e.number DESC LIMIT 1) WHERE id = $1";

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

    async fn store(&self, key: &Key, rows: &mut Rows<'_>) -> Outcome<()> {
        if let Pool::Postgres(pool) = &self.readers {
            let mut db = Db::Postgres(Lent::Transaction(postgres::begin(pool, "BEGIN").await?));
            store_in(&mut db, key, rows).await?;
            return Ok(db.commit().await?);
        }
        let mut writer = self.writer.lock().await;
        let Some(db) = writer.as_mut() else { return Err(given_up("the database was opened to be read").into()) };
        db.run("BEGIN IMMEDIATE", args![]).await?;
        let stored = store_in(db, key, rows).await;
        db.run(if stored.is_ok() { "COMMIT" } else { "ROLLBACK" }, args![]).await?;
        stored
    }
}

fn given_up(why: &str) -> RepositoryError {
    RepositoryError::Failed(why.to_owned())
}

/// Stores the rows of a job in a transaction.
async fn store_in(db: &mut Db, key: &Key, rows: &mut Rows<'_>) -> Outcome<()> {
    // triggers would write the events a second time
    let triggers = drop_triggers(db).await?;
    for row in rows {
        let (line, row) = row.ok_or_else(|| given_up("a row of it cannot be read"))?;
        insert(db, key, row).await.map_err(|error| given_up(&format!("line {line}: {}", reported(error))))?;
    }
    db.script(AssertSqlSafe(triggers)).await?;
    db.run(CLASS, args![key.job]).await?;
    let verdict = verify_rows(db, &key.tenant, Some(key.job)).await?;
    if let Some(difference) = verdict.differences.first() {
        let why = format!("its audit does not agree with its rows: {} is {}", difference.place, difference.kind.name());
        return Err(given_up(&why).into());
    }
    let caller = Caller { tenant: key.tenant.clone(), actor: actor::IMPORT.into(), origin: Default::default() };
    let by = By { caller: &caller, at: SystemClock.now() };
    let entry = Draft::new(by, &key.tenant, Some(key.job), Action::ImportJob, subject::job(key.job))?.end();
    let entries = [entry];
    let storing = audit::storing(db, &entries);
    Ok(db.run_together(storing).await?)
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

/// Returns the text by which a job is searched.
fn searched(row: &Row) -> String {
    let text = |name: &str| row.value(name).text();
    let fields = ["name", "part_number", "serial_number", "machine"].map(text);
    let tags = text("tags").and_then(|tags| serde_json::from_str(&tags).ok()).unwrap_or_default();
    searched_text(fields.each_ref().map(Option::as_deref), &tags)
}

async fn insert(db: &mut Db, key: &Key, row: Row) -> Outcome<()> {
    let folded = (row.table.name == "jobs").then(|| searched(&row));
    let (mut columns, mut values) = (row.table.list(), row.values);
    let mut add = |name: &str, value: Value<'static>| {
        columns = format!("{columns}, {name}");
        values.push(value);
    };
    let tenant = || Value::Text(Some(key.tenant.as_str().to_owned().into()));
    match row.table.name {
        "jobs" => {
            add("id", key.job.into());
            add("tenant", tenant());
            add("folded", folded.unwrap_or_default().into());
        }
        "audit" => {
            add("job", key.job.into());
            add("tenant", tenant());
        }
        "stream_blocks" | "stream_states" => {
            let sql = "SELECT 1 FROM streams WHERE id = $1 AND job = $2";
            if !db.is_there(sql, &[values[0].clone(), key.job.into()]).await? {
                return Err(given_up("`stream` is none of the job").into());
            }
        }
        _ => add("job", key.job.into()),
    }
    Ok(db.insert(row.table.name, &columns, vec![values]).await?)
}

impl Holdings for SqlHoldings {
    fn keys(&self) -> RepositoryFuture<'_, Vec<Key>> {
        let sql = "SELECT tenant, id FROM jobs UNION SELECT tenant, job FROM audit WHERE job IS NOT NULL";
        reading(async move {
            let keys: Vec<(Cell<Tenant>, Uuid)> = self.readers.connection().await?.all(sql, args![]).await?;
            let mut keys: Vec<Key> = keys.into_iter().map(|(Cell(tenant), job)| Key { tenant, job }).collect();
            keys.sort();
            Ok(keys)
        })
    }

    fn read(&self, key: Key, to: mpsc::Sender<Row>) -> RepositoryFuture<'_, ()> {
        reading(async move {
            let mut db = self.readers.snapshot().await?;
            if db.is_postgres() {
                // as long as a job takes that is long
                db.script(UNHURRIED).await?;
            }
            for table in OF_JOBS.iter().chain([ENTRIES]) {
                let condition = format!("{} ORDER BY {}", table.of, table.order());
                let mut rows = db.rows(table, &condition, args![key.job, &key.tenant])?;
                while let Some(row) = rows.try_next().await? {
                    if to.send(row).await.is_err() {
                        // the rest is not needed
                        return Ok(());
                    }
                }
            }
            Ok(())
        })
    }

    fn write<'a>(&'a self, key: Key, rows: &'a mut Rows<'_>) -> RepositoryFuture<'a, ()> {
        reading(async move { self.store(&key, rows).await })
    }

    /// Copies the log into the database, which is whole without it then. Readers of the database
    /// are waited for as for any write; the connection that closes last takes the log away.
    fn close(&self) -> RepositoryFuture<'_, bool> {
        reading(async {
            if let Pool::Sqlite(readers) = &self.readers {
                readers.close().await;
            }
            let Some(mut writer) = self.writer.lock().await.take() else { return Ok(true) };
            let emptied = writer.checkpoint().await?;
            writer.close().await?;
            Ok(emptied)
        })
    }
}
