//! Jobs as rows, to be taken elsewhere, and stored as they were.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use sqlx::{
    AssertSqlSafe, Connection as _, Row as _, Sqlite, SqliteConnection, SqlitePool,
    query::Query,
    sqlite::{SqliteArguments, SqliteRow},
};
use tokio::sync::{Mutex, mpsc};
use uuid::Uuid;

use super::{
    audit_reads,
    error::{OpenError, failure},
    fits, lock,
    open::StoreSettings,
    time,
};
use crate::{
    jobs::{
        RepositoryError, RepositoryFuture, Tenant,
        archive::{Coming, Holdings, Key, Kind, Row, Section, TABLES, Value, given_up, keys_of},
        audit::{Chain, Verdict},
    },
    store::shared::{Document, Moment, Outcome, StoreError},
};

/// How the rows of a job are read and stored.
struct Statements {
    table: &'static str,
    /// Reads the job whose id and tenant are the variables.
    read: &'static str,
    /// The variables are the job's id, then the columns; a job's and an entry's tenant comes last.
    write: &'static str,
}

/// In the order of [`TABLES`].
const STATEMENTS: &[Statements] = &[
    Statements {
        table: "job",
        read: "SELECT name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at,
                      requirements FROM jobs
               WHERE id = ? AND tenant = ?",
        write: "INSERT INTO jobs (id, name, part_number, serial_number, machine, gear, tags, version, created_at,
                                  updated_at, requirements, tenant)
                VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)",
    },
    Statements {
        table: "iteration",
        read: "SELECT i.number, i.id, i.measured_at, i.instrument, i.operator, i.note, i.flank, i.tooth, i.axes,
                      i.created_at
               FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? ORDER BY i.number",
        write: "INSERT INTO iterations (job, number, id, measured_at, instrument, operator, note, flank, tooth, axes,
                                        created_at)
                VALUES ((SELECT seq FROM jobs WHERE id = ?1), ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
    },
    Statements {
        table: "nodes",
        read: "SELECT i.number, n.count, n.data
               FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY i.number",
        write: "INSERT INTO nodes (iteration, count, data)
                VALUES ((SELECT i.seq FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ?1 AND i.number = ?2),
                        ?3, ?4)",
    },
    Statements {
        table: "fit",
        read: "SELECT i.number, row_number() OVER (PARTITION BY f.iteration ORDER BY f.seq), f.id, f.reason,
                      f.created_at, f.lambda_star, f.criterion, f.scheme, f.count, f.condition,
                       f.regularized_condition, f.bias_norm, f.bias_sharp_bound, f.rms, f.max_abs, f.actor,
                      f.flank_figures, f.spec, coalesce(f.frame, f.result)
               FROM jobs j JOIN iterations i ON i.job = j.seq JOIN fits f ON f.iteration = i.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY i.number, f.seq",
        write: "INSERT INTO fits (iteration, id, reason, created_at, lambda_star, criterion, scheme, count, condition,
                                   regularized_condition, bias_norm, bias_sharp_bound, rms, max_abs, actor,
                                   flank_figures, spec, result, frame, coefficients, prior)
                SELECT i.seq, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22,
                       ?23
                FROM jobs j JOIN iterations i ON i.job = j.seq
                WHERE j.id = ?1 AND i.number = ?2 AND ?3 = (SELECT count(*) + 1 FROM fits WHERE iteration = i.seq)",
    },
    Statements {
        table: "choice",
        read: "SELECT i.number, c.position, (SELECT count(*) FROM fits WHERE iteration = i.seq AND seq <= c.fit),
                      c.reason, c.created_at, c.actor
               FROM jobs j JOIN iterations i ON i.job = j.seq JOIN fit_choices c ON c.iteration = i.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY i.number, c.position",
        write: "INSERT INTO fit_choices (iteration, position, fit, reason, created_at, actor)
                SELECT i.seq, ?3, (SELECT seq FROM fits WHERE iteration = i.seq ORDER BY seq LIMIT 1 OFFSET ?4 - 1),
                       ?5, ?6, ?7
                FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ?1 AND i.number = ?2",
    },
    Statements {
        table: "decision",
        read: "SELECT i.number, d.position, d.decision, d.reason, d.created_at, d.actor, d.concession
               FROM jobs j JOIN iterations i ON i.job = j.seq JOIN decisions d ON d.iteration = i.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY i.number, d.position",
        write: "INSERT INTO decisions (iteration, position, decision, reason, created_at, actor, concession)
                SELECT i.seq, ?3, ?4, ?5, ?6, ?7, ?8
                FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ?1 AND i.number = ?2",
    },
    Statements {
        table: "record",
        read: "SELECT i.number, row_number() OVER (PARTITION BY r.iteration ORDER BY r.seq), r.id, r.kind, r.method,
                      r.created_at, r.request, r.result, r.gear, r.actor, r.class, r.measurand
               FROM jobs j JOIN iterations i ON i.job = j.seq JOIN records r ON r.iteration = i.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY i.number, r.seq",
        write: "INSERT INTO records (iteration, id, kind, method, created_at, request, result, gear, actor, class,
                                     measurand)
                SELECT i.seq, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13 FROM jobs j JOIN iterations i ON i.job = j.seq
                WHERE j.id = ?1 AND i.number = ?2 AND ?3 = (SELECT count(*) + 1 FROM records WHERE iteration = i.seq)",
    },
    Statements {
        table: "stream",
        read: "SELECT s.id, s.spec, s.forgetting_factor, s.sequence, s.node_count, s.input_sha256, s.flank, s.tooth,
                      s.axes, i.number, s.version, s.created_at, s.updated_at
               FROM jobs j JOIN streams s ON s.job = j.seq LEFT JOIN iterations i ON i.seq = s.iteration
               WHERE j.id = ? AND j.tenant = ? ORDER BY s.id",
        write:
            "INSERT INTO streams (job, id, spec, forgetting_factor, sequence, node_count, input_sha256, flank, tooth,
                                     axes, iteration, version, created_at, updated_at)
                SELECT j.seq, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10,
                       (SELECT seq FROM iterations WHERE job = j.seq AND number = ?11), ?12, ?13, ?14
                FROM jobs j WHERE j.id = ?1",
    },
    Statements {
        table: "block",
        read: "SELECT s.id, b.sequence, b.sha256, b.count, b.data, b.created_at
               FROM jobs j JOIN streams s ON s.job = j.seq JOIN stream_blocks b ON b.stream = s.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY s.id, b.sequence",
        write: "INSERT INTO stream_blocks (stream, sequence, sha256, count, data, created_at)
                SELECT s.seq, ?3, ?4, ?5, ?6, ?7
                FROM jobs j JOIN streams s ON s.job = j.seq WHERE j.id = ?1 AND s.id = ?2",
    },
    Statements {
        table: "state",
        read: "SELECT s.id, t.sequence, t.data
               FROM jobs j JOIN streams s ON s.job = j.seq JOIN stream_states t ON t.stream = s.seq
               WHERE j.id = ? AND j.tenant = ? ORDER BY s.id",
        write: "INSERT INTO stream_states (stream, sequence, data)
                SELECT s.seq, ?3, ?4 FROM jobs j JOIN streams s ON s.job = j.seq WHERE j.id = ?1 AND s.id = ?2",
    },
    Statements {
        table: "event",
        read: "SELECT e.number, e.kind, i.number,
                      CASE WHEN e.fit NOTNULL
                           THEN (SELECT count(*) FROM fits WHERE iteration = e.iteration AND seq <= e.fit) END,
                      e.position, e.stream, e.state, e.sequence, e.node_count, e.operation, e.operation_state,
                      e.created_at, e.record
               FROM jobs j JOIN events e ON e.job = j.seq LEFT JOIN iterations i ON i.seq = e.iteration
               WHERE j.id = ? AND j.tenant = ? ORDER BY e.number",
        write: "INSERT INTO events (job, number, kind, iteration, fit, position, stream, state, sequence, node_count,
                                    operation, operation_state, created_at, record)
                SELECT j.seq, ?2, ?3, i.seq, (SELECT seq FROM fits WHERE iteration = i.seq AND ?5 NOTNULL
                                              ORDER BY seq LIMIT 1 OFFSET coalesce(?5, 1) - 1),
                       ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14
                FROM jobs j LEFT JOIN iterations i ON i.job = j.seq AND i.number = ?4 WHERE j.id = ?1",
    },
    Statements {
        table: "audit",
        read: "SELECT number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256
               FROM audit WHERE chain = ? AND tenant = ? ORDER BY number",
        write: "INSERT INTO audit (chain, number, id, at, actor, action, target, request_id, peer, contents, outcome,
                                   previous, sha256, tenant)
                VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)",
    },
    Statements {
        table: "purge",
        read: "SELECT p.at, p.reason, p.archive_sha256 FROM jobs j JOIN purges p ON p.job = j.seq
               WHERE j.id = ? AND j.tenant = ?",
        write: "INSERT INTO purges (job, at, reason, archive_sha256)
                VALUES ((SELECT seq FROM jobs WHERE id = ?1), ?2, ?3, ?4)",
    },
];

/// The jobs of a database.
pub struct SqliteHoldings {
    readers: SqlitePool,
    /// None where the database is read only, and once it is closed.
    writer: Mutex<Option<SqliteConnection>>,
    /// No server writes meanwhile.
    _lock: Option<std::fs::File>,
}

impl SqliteHoldings {
    /// To read a database, which a server may have open.
    pub async fn open(settings: &StoreSettings) -> Result<Self, OpenError> {
        settings.must_exist()?;
        Ok(SqliteHoldings { readers: settings.open_aside().await?, writer: Mutex::default(), _lock: None })
    }

    /// Holdings of an open database.
    pub(super) fn of(readers: SqlitePool) -> Self {
        SqliteHoldings { readers, writer: Mutex::default(), _lock: None }
    }

    /// To store jobs in a database, which is made where there is none and which no server may have
    /// open.
    pub async fn open_to_write(settings: &StoreSettings) -> Result<Self, OpenError> {
        let lock = lock::take(&settings.path()).await?;
        let writer = Mutex::new(Some(settings.open_writer().await?));
        Ok(SqliteHoldings { readers: settings.open_aside().await?, writer, _lock: lock })
    }

    async fn read_keys(&self) -> Outcome<Vec<Key>> {
        let keys: Vec<(Tenant, Uuid)> =
            sqlx::query_as("SELECT tenant, id FROM jobs UNION SELECT tenant, chain FROM audit")
                .fetch_all(&self.readers)
                .await?;
        Ok(keys_of(keys))
    }

    async fn store(&self, key: &Key, mut from: mpsc::Receiver<Coming>) -> Outcome<()> {
        let mut writer = self.writer.lock().await;
        let Some(writer) = writer.as_mut() else { return Err(given_up("it was opened to be read").into()) };
        let mut db = writer.begin_with("BEGIN IMMEDIATE").await?;
        // what tells of events would tell of them a second time; the transaction brings it back
        let telling: Vec<(String, String)> = sqlx::query_as(
            "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' AND name LIKE 'events_of_%' ORDER BY name",
        )
        .fetch_all(&mut *db)
        .await?;
        for (name, _) in &telling {
            sqlx::raw_sql(AssertSqlSafe(format!("DROP TRIGGER \"{name}\""))).execute(&mut *db).await?;
        }
        let told = loop {
            match from.recv().await {
                Some(Coming::Row(row)) => insert(&mut db, key, &row).await?,
                Some(Coming::All(told)) => break told,
                // reading ended before its end: the transaction is given up
                None => return Err(given_up("not all of its rows came").into()),
            }
        };
        for (_, sql) in telling {
            sqlx::raw_sql(AssertSqlSafe(sql)).execute(&mut *db).await?;
        }
        let (mut section, _) = Section::begin(key);
        for table in 0..TABLES.len() {
            let mut rows = sqlx::query(STATEMENTS[table].read).bind(key.job).bind(key.tenant.as_str()).fetch(&mut *db);
            while let Some(row) = rows.try_next().await? {
                section.row(&read_row(table, &row)?);
            }
        }
        if section.end() != told {
            return Err(given_up("what would be stored is not what came").into());
        }
        let chain = Chain::Job(key.job);
        if let Verdict::Broken { number, what } =
            audit_reads::verify(&mut db, &key.tenant, chain, BTreeMap::new()).await?
        {
            return Err(given_up(&format!("its audit is broken at entry {number}: {}", what.name())).into());
        }
        Ok(db.commit().await?)
    }

    /// Copies the log into the database, which is whole without it then. Who reads the database
    /// meanwhile is waited for as for any write; the connection that closes last takes the log
    /// away.
    async fn end(&self) -> Outcome<bool> {
        self.readers.close().await;
        let Some(mut writer) = self.writer.lock().await.take() else { return Ok(true) };
        let (busy, _, _): (i64, i64, i64) =
            sqlx::query_as("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(&mut writer).await?;
        writer.close().await?;
        Ok(busy == 0)
    }

    async fn send(&self, key: &Key, to: mpsc::Sender<Row>) -> Outcome<()> {
        let mut db = self.readers.begin().await?;
        for table in 0..TABLES.len() {
            let mut rows = sqlx::query(STATEMENTS[table].read).bind(key.job).bind(key.tenant.as_str()).fetch(&mut *db);
            while let Some(row) = rows.try_next().await? {
                if to.send(read_row(table, &row)?).await.is_err() {
                    // the rest is not needed
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}

fn read_row(table: usize, row: &SqliteRow) -> Result<Row, sqlx::Error> {
    let column = |(k, column): (usize, &crate::jobs::archive::Column)| {
        Ok(match column.kind {
            Kind::Integer => row.try_get::<Option<i64>, _>(k)?.map(Value::Integer),
            Kind::Real => row.try_get::<Option<f64>, _>(k)?.map(Value::Real),
            Kind::Text => row.try_get::<Option<String>, _>(k)?.map(Value::Text),
            Kind::Document => row.try_get::<Option<Document>, _>(k)?.map(|Document(text)| Value::Text(text)),
            Kind::Bytes => row.try_get::<Option<Vec<u8>>, _>(k)?.map(Value::Bytes),
            Kind::Id => row.try_get::<Option<Uuid>, _>(k)?.map(Value::Id),
            Kind::Time => row.try_get::<Option<Moment>, _>(k)?.map(|Moment(time)| Value::Time(time)),
        }
        .unwrap_or(Value::Null))
    };
    let values = TABLES[table].columns.iter().enumerate().map(column).collect::<Result<_, sqlx::Error>>()?;
    Ok(Row { table, values })
}

fn bound<'q>(query: Query<'q, Sqlite, SqliteArguments>, value: &'q Value) -> Query<'q, Sqlite, SqliteArguments> {
    match value {
        Value::Null => query.bind(None::<i64>),
        Value::Integer(number) => query.bind(number),
        Value::Real(number) => query.bind(number),
        Value::Text(text) => query.bind(text.as_str()),
        Value::Bytes(bytes) => query.bind(bytes.as_slice()),
        Value::Id(id) => query.bind(id),
        Value::Time(at) => query.bind(time::to_text(*at)),
    }
}

async fn insert(db: &mut SqliteConnection, key: &Key, row: &Row) -> Outcome<()> {
    let statements = &STATEMENTS[row.table];
    let query = sqlx::query(statements.write).bind(key.job);
    let query = match (statements.table, row.values.as_slice()) {
        ("fit", [before @ .., Value::Text(result)]) => {
            fits::bind_result(before.iter().fold(query, bound), &result.as_str().into())
        }
        ("job" | "audit", values) => values.iter().fold(query, bound).bind(key.tenant.as_str()),
        (_, values) => values.iter().fold(query, bound),
    };
    match query.execute(db).await?.rows_affected() {
        1 => Ok(()),
        _ => Err(given_up(&format!("a row ({}) belongs to none before it", statements.table)).into()),
    }
}

fn told(error: StoreError) -> RepositoryError {
    match error {
        StoreError::Refused(error) => error,
        StoreError::Broken(error) => failure(&error),
    }
}

impl Holdings for SqliteHoldings {
    fn keys(&self) -> RepositoryFuture<'_, Vec<Key>> {
        Box::pin(async move { self.read_keys().await.map_err(told) })
    }

    fn read(&self, key: Key, to: mpsc::Sender<Row>) -> RepositoryFuture<'_, ()> {
        Box::pin(async move { self.send(&key, to).await.map_err(told) })
    }

    fn write(&self, key: Key, from: mpsc::Receiver<Coming>) -> RepositoryFuture<'_, ()> {
        Box::pin(async move { self.store(&key, from).await.map_err(told) })
    }

    fn close(&self) -> RepositoryFuture<'_, bool> {
        Box::pin(async { self.end().await.map_err(told) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_statements_of_every_table() {
        let names: Vec<_> = STATEMENTS.iter().map(|statements| statements.table).collect();
        assert_eq!(names, TABLES.iter().map(|table| table.name).collect::<Vec<_>>());
    }
}
