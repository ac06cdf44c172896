//! Opening the database: the requirements on the server, its connections, and the store.

use std::{io, sync::Arc, time::Duration};

use sqlx::{
    Connection as _, PgConnection, PgPool, Postgres, SqlSafeStr as _, Transaction,
    postgres::{PgConnectOptions, PgPoolOptions},
};
use tracing::Instrument as _;

use super::{
    error::PostgresError,
    migrate::{migrate, refuse_earlier},
    settings::{Migrate, PostgresSettings},
    wakes::Notifications,
    writer::Writer,
};
use crate::{
    jobs::{Clock, Ids},
    store::sql::{Database, Db, Pool, READ_TIME, ReadTurns, Shared, SqlAuditor, SqlHoldings, SqlStore, queue, seconds},
    telemetry,
};

/// A server that does not answer at all is given up after this.
const CONNECT_TIME: Duration = Duration::from_secs(5);

/// PostgreSQL 15.
const OLDEST: i64 = 15_00_00;

row! {
    struct Server {
        version: i64,
        in_recovery: bool,
        encoding: String,
        fsync: String,
        full_page_writes: String,
        synchronous_commit: String,
    }
}

/// A connection to a server that may be written to.
pub async fn connect(settings: &PostgresSettings) -> Result<PgConnection, sqlx::Error> {
    let connecting = PgConnection::connect_with(&settings.options);
    let late = || sqlx::Error::Io(io::ErrorKind::TimedOut.into());
    let mut db = tokio::time::timeout(CONNECT_TIME, connecting).await.unwrap_or_else(|_| Err(late()))?;
    refuse_standby(&mut db).await?;
    Ok(db)
}

/// After a failover the old server may answer as a standby: it is as good as none.
async fn refuse_standby(db: &mut PgConnection) -> Result<(), sqlx::Error> {
    match sqlx::query_scalar("SELECT pg_is_in_recovery()").fetch_one(db).await? {
        true => Err(sqlx::Error::Io(io::Error::other("the server is a standby"))),
        false => Ok(()),
    }
}

/// Refuses a server that is too old, that is a standby, or that does not keep what it says it
/// keeps.
pub async fn check(settings: &PostgresSettings) -> Result<(), PostgresError> {
    let address = settings.address();
    let failed = |source| PostgresError::Connect { address: settings.address(), source };
    let mut db = PgConnection::connect_with(&settings.options).await.map_err(failed)?;
    let server: Server = sqlx::query_as(
        "SELECT current_setting('server_version_num')::bigint AS version, pg_is_in_recovery() AS in_recovery,
                current_setting('server_encoding') AS encoding, current_setting('fsync') AS fsync,
                current_setting('full_page_writes') AS full_page_writes,
                current_setting('synchronous_commit') AS synchronous_commit",
    )
    .fetch_one(&mut db)
    .await
    .map_err(failed)?;
    let mut db = Db::from(db);
    refuse_earlier(settings, &mut db).await?;
    // nothing more is asked
    let _closed = db.close().await;
    if server.version < OLDEST {
        return Err(PostgresError::TooOld { address, version: server.version / 10_000 });
    }
    if server.in_recovery {
        return Err(PostgresError::InRecovery { address });
    }
    if server.encoding != "UTF8" {
        return Err(PostgresError::Encoding { address, encoding: server.encoding });
    }
    let settings_of_server = [
        ("fsync", &server.fsync),
        ("full_page_writes", &server.full_page_writes),
        ("synchronous_commit", &server.synchronous_commit),
    ];
    match settings_of_server.into_iter().find(|(_, value)| *value == "off") {
        Some((setting, _)) if !settings.unsafe_store => Err(PostgresError::Unsafe { address, setting }),
        Some((setting, _)) => {
            tracing::warn!(setting, "the server may lose what it says is stored");
            Ok(())
        }
        None => Ok(()),
    }
}

/// Connections for long-running reads.
const ASIDE: u32 = 4;

/// Returns the readers for requests of callers: the server ends a read when its time is over.
pub fn readers(settings: &PostgresSettings) -> PgPool {
    let limit = format!("{}ms", READ_TIME.as_millis());
    let options = settings.options.clone().options([("statement_timeout", limit.as_str())]);
    pool(settings, settings.readers.max(1), options)
}

/// Returns the connections for long-running reads, with the session's own limits.
pub fn aside(settings: &PostgresSettings) -> PgPool {
    pool(settings, ASIDE, settings.options.clone())
}

/// Returns a pool. A connection closed by the server is detected when it is used; the read is then
/// repeated.
fn pool(settings: &PostgresSettings, most: u32, options: PgConnectOptions) -> PgPool {
    PgPoolOptions::new()
        .max_connections(most)
        .acquire_timeout(settings.patience)
        .test_before_acquire(false)
        .after_connect(|db, _| Box::pin(refuse_standby(db)))
        .connect_lazy_with(options)
}

/// Begins a transaction that sees one consistent state and changes nothing.
pub async fn snapshot(from: &PgPool) -> Result<Transaction<'static, Postgres>, sqlx::Error> {
    begin(from, "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY").await
}

/// Begins a transaction that ends when its caller has gone, also while it begins.
///
/// It begins in a task of its own, which nobody can give up: sqlx 0.9 sends no ROLLBACK where BEGIN
/// is given up, and the connection would go back to the pool inside the transaction. (So a pool's
/// own `begin` is not to be used.)
pub async fn begin(from: &PgPool, statement: &'static str) -> Result<Transaction<'static, Postgres>, sqlx::Error> {
    let db = from.acquire().await?;
    let begun = Transaction::begin(db, Some(statement.into_sql_str()));
    tokio::spawn(begun.in_current_span()).await.unwrap_or(Err(sqlx::Error::WorkerCrashed))
}

/// Opens the database, brings it up to date if that is wanted, and starts the writers.
pub async fn open_postgres(
    settings: PostgresSettings,
    ids: Arc<dyn Ids>,
    clock: Arc<dyn Clock>,
) -> Result<SqlStore, PostgresError> {
    // a measurement from before there is a recorder is lost
    telemetry::metrics();
    check(&settings).await?;
    if settings.migrate == Migrate::Auto {
        migrate(&settings).await?;
    }
    let settings = Arc::new(settings);
    let mut queues = Vec::new();
    for _ in 0..settings.writers.max(1) {
        let (queue, waiting) = queue(settings.queue, seconds("write"));
        let (settings, ids, clock) = (settings.clone(), ids.clone(), clock.clone());
        tokio::spawn(Writer { settings, ids, clock, waiting, session: None }.run());
        queues.push(queue);
    }
    let (readers, aside) = (Pool::Postgres(readers(&settings)), aside(&settings));
    let turns = ReadTurns::new(settings.readers);
    let wakes = Arc::new(Notifications::new(settings.clone(), aside.clone(), ids.fresh(clock.now())));
    let shared = Some(Shared { settings, wakes });
    let (aside, read_seconds) = (Pool::Postgres(aside), seconds("read"));
    Ok(SqlStore(Arc::new(Database { readers, turns, aside, queues, read_seconds, clock, shared })))
}

/// Opens the audit of a database that a server may be using.
pub fn postgres_auditor(settings: &PostgresSettings) -> SqlAuditor {
    SqlAuditor(Pool::Postgres(aside(settings)))
}

/// Opens the jobs of a database that servers may be using. Storing takes an owner of its tables.
pub fn postgres_holdings(settings: &PostgresSettings) -> SqlHoldings {
    let mut settings = settings.clone();
    // one state is read for as long as somebody takes it, and written for as long as it comes
    settings.options =
        settings.options.options([("statement_timeout", "0"), ("idle_in_transaction_session_timeout", "0")]);
    SqlHoldings::read_only(Pool::Postgres(aside(&settings)))
}
