//! Jobs as rows, to be taken elsewhere, and stored as they were.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use sqlx::{
    AssertSqlSafe, PgConnection, PgPool, Postgres, Row as _,
    postgres::{PgArguments, PgRow},
    query::Query,
};
use tokio::sync::mpsc;
use uuid::Uuid;

use super::{
    audit_reads, document,
    error::failure,
    open::{begin, snapshot},
    settings::PostgresSettings,
    time::stamp,
};
use crate::{
    jobs::{
        EncodedResult, EncodedText, KeptBeside, RepositoryError, RepositoryFuture, Tenant,
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
               WHERE id = $1 AND tenant = $2",
        write: "INSERT INTO jobs (id, name, part_number, serial_number, machine, gear, tags, version, created_at,
                                  updated_at, requirements, tenant)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)",
    },
    Statements {
        table: "iteration",
        read: "SELECT i.number, i.id, i.measured_at, i.instrument, i.operator, i.note, i.flank, i.tooth, i.axes,
                      i.created_at
               FROM jobs j JOIN iterations i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY i.number",
        write: "INSERT INTO iterations (job, number, id, measured_at, instrument, operator, note, flank, tooth, axes,
                                        created_at)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
    },
    Statements {
        table: "nodes",
        read: "SELECT n.number, n.count, n.data FROM jobs j JOIN nodes n ON n.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY n.number",
        write: "INSERT INTO nodes (job, number, count, data) VALUES ($1, $2, $3, $4)",
    },
    Statements {
        table: "fit",
        read:
            "SELECT f.number, f.position, f.id, f.reason, f.created_at, f.lambda_star, f.criterion, f.scheme, f.count,
                      f.condition, f.regularized_condition, f.bias_norm, f.bias_sharp_bound, f.rms, f.max_abs, f.actor,
                      f.flank_figures, f.spec, f.result
               FROM jobs j JOIN fits f ON f.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY f.number, f.position",
        write: "INSERT INTO fits (job, number, position, id, reason, created_at, lambda_star, criterion, scheme, count,
                                  condition, regularized_condition, bias_norm, bias_sharp_bound, rms, max_abs, actor,
                                  flank_figures, spec, result, coefficients, prior)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20, $21,
                        $22)",
    },
    Statements {
        table: "choice",
        read: "SELECT c.number, c.position, c.fit, c.reason, c.created_at, c.actor
               FROM jobs j JOIN fit_choices c ON c.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY c.number, c.position",
        write: "INSERT INTO fit_choices (job, number, position, fit, reason, created_at, actor)
                VALUES ($1, $2, $3, $4, $5, $6, $7)",
    },
    Statements {
        table: "decision",
        read: "SELECT d.number, d.position, d.decision, d.reason, d.created_at, d.actor, d.concession
               FROM jobs j JOIN decisions d ON d.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY d.number, d.position",
        write: "INSERT INTO decisions (job, number, position, decision, reason, created_at, actor, concession)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    },
    Statements {
        table: "record",
        read: "SELECT r.number, r.position, r.id, r.kind, r.method, r.created_at, r.request, r.result, r.gear, r.actor,
                      r.class, r.measurand
               FROM jobs j JOIN records r ON r.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY r.number, r.position",
        write: "INSERT INTO records (job, number, position, id, kind, method, created_at, request, result, gear, actor,
                                     class, measurand)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
    },
    Statements {
        table: "stream",
        read: "SELECT s.id, s.spec, s.forgetting_factor, s.sequence, s.node_count, s.input_sha256, s.flank, s.tooth,
                      s.axes, s.iteration, s.version, s.created_at, s.updated_at
               FROM jobs j JOIN streams s ON s.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY s.id",
        write:
            "INSERT INTO streams (job, id, spec, forgetting_factor, sequence, node_count, input_sha256, flank, tooth,
                                     axes, iteration, version, created_at, updated_at)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)",
    },
    Statements {
        table: "block",
        read: "SELECT b.stream, b.sequence, b.sha256, b.count, b.data, b.created_at
               FROM jobs j JOIN streams s ON s.job = j.id JOIN stream_blocks b ON b.stream = s.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY b.stream, b.sequence",
        write: "INSERT INTO stream_blocks (stream, sequence, sha256, count, data, created_at)
                SELECT id, $3, $4, $5, $6, $7 FROM streams WHERE job = $1 AND id = $2",
    },
    Statements {
        table: "state",
        read: "SELECT t.stream, t.sequence, t.data
               FROM jobs j JOIN streams s ON s.job = j.id JOIN stream_states t ON t.stream = s.id
               WHERE j.id = $1 AND j.tenant = $2 ORDER BY t.stream",
        write: "INSERT INTO stream_states (stream, sequence, data)
                SELECT id, $3, $4 FROM streams WHERE job = $1 AND id = $2",
    },
    Statements {
        table: "event",
        read: "SELECT e.number, e.kind, e.iteration, e.fit, e.position, e.stream, e.state, e.sequence, e.node_count,
                      e.operation, e.operation_state, e.created_at, e.record
               FROM jobs j JOIN events e ON e.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY e.number",
        write: "INSERT INTO events (job, number, kind, iteration, fit, position, stream, state, sequence, node_count,
                                    operation, operation_state, created_at, record)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)",
    },
    Statements {
        table: "audit",
        read: "SELECT number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256
               FROM audit WHERE chain = $1 AND tenant = $2 ORDER BY number",
        write: "INSERT INTO audit (chain, number, id, at, actor, action, target, request_id, peer, contents, outcome,
                                   previous, sha256, tenant)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)",
    },
    Statements {
        table: "purge",
        read: "SELECT p.at, p.reason, p.archive_sha256 FROM jobs j JOIN purges p ON p.job = j.id
               WHERE j.id = $1 AND j.tenant = $2",
        write: "INSERT INTO purges (job, at, reason, archive_sha256) VALUES ($1, $2, $3, $4)",
    },
];

/// The triggers that tell of events, and their tables.
const TELLING: [(&str, &str); 9] = [
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
pub struct PostgresHoldings(PgPool);

impl PostgresHoldings {
    /// Opens a database that servers may be using. Storing takes an owner of its tables.
    pub fn open(settings: &PostgresSettings) -> Self {
        let mut settings = settings.clone();
        // one state is read for as long as somebody takes it, and written for as long as it comes
        settings.options =
            settings.options.options([("statement_timeout", "0"), ("idle_in_transaction_session_timeout", "0")]);
        PostgresHoldings(super::open::aside(&settings))
    }

    /// Holdings of an open database.
    pub(super) fn of(readers: PgPool) -> Self {
        PostgresHoldings(readers)
    }

    async fn read_keys(&self) -> Outcome<Vec<Key>> {
        let keys: Vec<(Tenant, Uuid)> =
            sqlx::query_as("SELECT tenant, id FROM jobs UNION SELECT tenant, chain FROM audit")
                .fetch_all(&self.0)
                .await?;
        Ok(keys_of(keys))
    }

    async fn store(&self, key: &Key, mut from: mpsc::Receiver<Coming>) -> Outcome<()> {
        let mut db = begin(&self.0, "BEGIN").await?;
        // what tells of events would tell of them a second time
        tell(&mut db, "DISABLE").await?;
        let told = loop {
            match from.recv().await {
                Some(Coming::Row(row)) => insert(&mut db, key, &row).await?,
                Some(Coming::All(told)) => break told,
                // reading ended before its end: the transaction is given up
                None => return Err(given_up("not all of its rows came").into()),
            }
        };
        tell(&mut db, "ENABLE").await?;
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

    async fn send(&self, key: &Key, to: mpsc::Sender<Row>) -> Outcome<()> {
        let mut db = snapshot(&self.0).await?;
        // as long as a job takes that is long
        sqlx::raw_sql(UNHURRIED).execute(&mut *db).await?;
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

async fn tell(db: &mut PgConnection, how: &str) -> Result<(), sqlx::Error> {
    let each = TELLING.map(|(table, trigger)| format!("ALTER TABLE {table} {how} TRIGGER {trigger};"));
    sqlx::raw_sql(AssertSqlSafe(each.concat())).execute(db).await?;
    Ok(())
}

fn read_row(table: usize, row: &PgRow) -> Result<Row, sqlx::Error> {
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

/// A statement takes each variable by its type, also where it is NULL.
fn bound<'q>(
    query: Query<'q, Postgres, PgArguments>,
    (kind, value): (Kind, &'q Value),
) -> Query<'q, Postgres, PgArguments> {
    match (kind, value) {
        (Kind::Integer, Value::Integer(number)) => query.bind(Some(*number)),
        (Kind::Integer, _) => query.bind(None::<i64>),
        (Kind::Real, Value::Real(number)) => query.bind(Some(*number)),
        (Kind::Real, _) => query.bind(None::<f64>),
        (Kind::Text, Value::Text(text)) => query.bind(Some(text.as_str())),
        (Kind::Text, _) => query.bind(None::<&str>),
        (Kind::Document, Value::Text(text)) => query.bind(Some(document::encode(text))),
        (Kind::Bytes, Value::Bytes(bytes)) => query.bind(Some(bytes.as_slice())),
        (Kind::Bytes | Kind::Document, _) => query.bind(None::<&[u8]>),
        (Kind::Id, Value::Id(id)) => query.bind(Some(*id)),
        (Kind::Id, _) => query.bind(None::<Uuid>),
        (Kind::Time, Value::Time(at)) => query.bind(Some(stamp(*at))),
        (Kind::Time, _) => query.bind(None::<jiff_sqlx::Timestamp>),
    }
}

async fn insert(db: &mut PgConnection, key: &Key, row: &Row) -> Outcome<()> {
    let statements = &STATEMENTS[row.table];
    let columns = row.table().columns.iter().map(|column| column.kind).zip(&row.values);
    let query = columns.fold(sqlx::query(statements.write).bind(key.job), bound);
    let query = match (statements.table, row.values.last()) {
        ("job" | "audit", _) => query.bind(key.tenant.as_str()),
        ("fit", Some(Value::Text(result))) => {
            let encoded = EncodedResult::from(result.as_str());
            let KeptBeside { coefficients, prior } = encoded.kept_beside();
            let bytes = |text: &Option<EncodedText>| text.as_ref().map(|text| text.bytes().to_vec());
            query.bind(bytes(coefficients)).bind(bytes(prior))
        }
        _ => query,
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

impl Holdings for PostgresHoldings {
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
        Box::pin(async { Ok(true) })
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
