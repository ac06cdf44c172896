//! Opening the database: options, migrations, the writing connection, the readers and the store.

use std::{
    path::PathBuf,
    str::FromStr,
    sync::{Arc, LazyLock},
    time::Duration,
};

use sqlx::{
    ConnectOptions, SqliteConnection, SqlitePool,
    migrate::Migrator,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};

use super::{error::OpenError, lock, writer::Writer};
use crate::{
    jobs::{ANSWERS_KEPT, Clock},
    store::{
        migrations::{embedded, is_earlier},
        sql::{Database, Db, Pool, READING, ReadTurns, SqlAuditor, SqlHoldings, SqlStore, Value, queue, seconds},
    },
    telemetry,
};

static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| embedded("sqlite/"));

/// Returns every migration that this version knows, oldest first.
pub fn migrations() -> &'static Migrator {
    &MIGRATIONS
}

/// How the store is opened.
#[derive(Clone, Debug)]
pub struct StoreSettings {
    options: SqliteConnectOptions,
    /// Read-only connections.
    pub readers: u32,
    /// Writes that may wait; more are refused.
    pub queue: usize,
    /// Write even if a server has the database open, which then must be there.
    pub beside: bool,
}

/// Connections for requests of callers.
const READERS: u32 = 8;
/// Connections for long-running reads.
const ASIDE: u32 = 4;
/// Instructions of SQLite's virtual machine between two checks of the clock: about a millisecond.
const STEPS: i32 = 20_000;

/// Rows that are read before they are taken. Rows of nodes are large, and the library's 50 of them
/// would be in memory for every archive.
const ROWS_AHEAD: usize = 4;
/// How long a connection waits while another program (a backup tool, a shell) holds the database.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);
/// A stored fit is some 5 kB: of bigger pages each would hold one, and be half empty.
const PAGE_SIZE: u32 = 4096;
/// Pages of write-ahead log after which it is copied into the database (32 MiB;
/// 64 MiB of an older one, whose pages stay twice as large).
const CHECKPOINT_PAGES: &str = "8192";
/// The log is cut back to this after a checkpoint (64 MiB).
const LOG_LIMIT: &str = "67108864";
/// One prepared statement for each group size is kept, so no group waits for the compiler.
const WRITER_STATEMENTS: usize = 512;

impl StoreSettings {
    /// Settings for a database URL such as `sqlite://flankfit.db`.
    pub fn of_url(url: &str) -> Result<Self, OpenError> {
        if url.contains(":memory:") || url.contains("mode=memory") {
            return Err(OpenError::InMemory);
        }
        let refused = |reason: String| OpenError::Url { reason };
        if !url.starts_with("sqlite:") {
            return Err(refused("another is of the form postgres://USER@HOST/NAME, in small letters".into()));
        }
        if names_a_user(url) {
            return Err(refused("SQLite knows no users and passwords".into()));
        }
        let options = SqliteConnectOptions::from_str(url).map_err(|error| refused(error.to_string()))?;
        if options.get_filename().as_os_str().is_empty() {
            return Err(refused("no file is named".into()));
        }
        Ok(StoreSettings { options, readers: READERS, queue: 4096, beside: false })
    }

    /// Settings for a database file.
    pub fn of_file(path: impl Into<PathBuf>) -> Self {
        StoreSettings {
            options: SqliteConnectOptions::new().filename(path.into()),
            readers: READERS,
            queue: 4096,
            beside: false,
        }
    }

    /// Uses a registered SQLite VFS (tests watch the file system through one).
    pub fn vfs(mut self, name: &'static str) -> Self {
        self.options = self.options.vfs(name);
        self
    }

    /// The database file.
    pub fn path(&self) -> PathBuf {
        self.options.get_filename().to_path_buf()
    }

    /// Refuses a file that is not there, for those who only read it.
    fn must_exist(&self) -> Result<(), OpenError> {
        match self.path().try_exists() {
            Ok(false) => Err(OpenError::Missing { path: self.path() }),
            // opening it reports any other error
            _ => Ok(()),
        }
    }

    /// Opens the writing connection, on a database brought up to date.
    pub(in crate::store) async fn open_writer(&self) -> Result<Db, OpenError> {
        let failed = |source| OpenError::from_sqlx(self.path(), source);
        let mut db = Db::from(self.writer_options().connect().await.map_err(failed)?);
        if is_earlier(&mut db, &MIGRATIONS).await.map_err(failed)? {
            return Err(OpenError::Earlier { path: self.path() });
        }
        let Db::Sqlite(connection) = &mut db else { unreachable!("it was made of such a connection") };
        MIGRATIONS.run(&mut **connection).await.map_err(|source| OpenError::from_migration(self.path(), source))?;
        Ok(db)
    }

    /// The writing connection again, after the first was lost.
    pub(super) async fn reopen_writer(&self) -> Result<Db, sqlx::Error> {
        Ok(self.writer_options().create_if_missing(false).connect().await?.into())
    }

    /// A connection of its own to a database that must be there already, for a backup. It writes
    /// nothing.
    pub(super) async fn open_existing(&self) -> Result<SqliteConnection, OpenError> {
        self.options
            .clone()
            .create_if_missing(false)
            .read_only(true)
            .busy_timeout(BUSY_TIMEOUT)
            .disable_statement_logging()
            .connect()
            .await
            .map_err(|source| OpenError::from_sqlx(self.path(), source))
    }

    /// Opens the readers for requests of callers: a read is ended when its time is over. The writer
    /// must have been opened before: it creates the database and its log.
    async fn open_readers(&self) -> Result<SqlitePool, OpenError> {
        let watched = self
            .reader_pool(self.readers)
            .after_connect(|db, _| Box::pin(watch(db)))
            .before_acquire(|db, _| Box::pin(async { watch(db).await.map(|()| true) }));
        watched
            .connect_with(self.reader_options("read"))
            .await
            .map_err(|error| OpenError::from_sqlx(self.path(), error))
    }

    /// Opens the connections for long-running reads, without a time limit.
    async fn open_aside(&self) -> Result<Pool, OpenError> {
        let aside = self.reader_pool(ASIDE).connect_with(self.reader_options("aside")).await;
        aside.map(Pool::Sqlite).map_err(|error| OpenError::from_sqlx(self.path(), error))
    }

    fn reader_pool(&self, most: u32) -> SqlitePoolOptions {
        SqlitePoolOptions::new().max_connections(most).test_before_acquire(false).acquire_timeout(BUSY_TIMEOUT)
    }

    fn reader_options(&self, name: &'static str) -> SqliteConnectOptions {
        self.options
            .clone()
            .read_only(true)
            .foreign_keys(true)
            .busy_timeout(BUSY_TIMEOUT)
            .disable_statement_logging()
            .row_buffer_size(ROWS_AHEAD)
            .thread_name(move |i| format!("store-{name}-{i}"))
    }

    fn writer_options(&self) -> SqliteConnectOptions {
        self.options
            .clone()
            .create_if_missing(true)
            .page_size(PAGE_SIZE)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            .busy_timeout(BUSY_TIMEOUT)
            .pragma("wal_autocheckpoint", CHECKPOINT_PAGES)
            .pragma("journal_size_limit", LOG_LIMIT)
            // what is purged is nowhere in the file
            .pragma("secure_delete", "ON")
            .statement_cache_capacity(WRITER_STATEMENTS)
            .disable_statement_logging()
            .thread_name(|_| "store-write".to_owned())
    }
}

/// Opens the database (making it where there is none), brings it up to date and starts the writer.
pub async fn open_sqlite(settings: StoreSettings, clock: Arc<dyn Clock>) -> Result<SqlStore, OpenError> {
    // a measurement from before there is a recorder is lost
    telemetry::metrics();
    let lock = match settings.beside {
        true => settings.must_exist().map(|()| None)?,
        false => lock::take(&settings.path()).await?,
    };
    let mut db = settings.open_writer().await?;
    if !settings.beside {
        let failed = |source| OpenError::from_sqlx(settings.path(), source);
        let answers = "DELETE FROM idempotency_keys WHERE created_at < $1";
        db.run(answers, &[Value::from(clock.now() - ANSWERS_KEPT)]).await.map_err(failed)?;
    }
    let (readers, aside) = (Pool::Sqlite(settings.open_readers().await?), settings.open_aside().await?);
    let turns = ReadTurns::new(settings.readers);
    let (queue, waiting) = queue(settings.queue, seconds("write"));
    tokio::spawn(Writer::new(settings, db, lock, waiting).run());
    let queues = vec![queue];
    let read_seconds = seconds("read");
    let database = Database { readers, turns, aside, queues, read_seconds, clock, shared: None };
    Ok(SqlStore(Arc::new(database)))
}

/// Opens the audit of an existing database that a server may have open; nothing is written.
pub async fn sqlite_auditor(settings: &StoreSettings) -> Result<SqlAuditor, OpenError> {
    settings.must_exist()?;
    Ok(SqlAuditor(settings.open_aside().await?))
}

/// Opens the jobs of a database: to read them, where a server may have it open, or to store jobs,
/// in a database that is made where there is none and that no server may have open.
pub async fn sqlite_holdings(settings: &StoreSettings, to_write: bool) -> Result<SqlHoldings, OpenError> {
    if !to_write {
        settings.must_exist()?;
        return Ok(SqlHoldings::read_only(settings.open_aside().await?));
    }
    let lock = lock::take(&settings.path()).await?;
    let writer = settings.open_writer().await?;
    Ok(SqlHoldings::of_file(settings.open_aside().await?, writer, lock))
}

/// Makes a connection interrupt its statement when the time of the current read is over.
async fn watch(db: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    let reading = READING.try_with(Arc::clone);
    let mut db = db.lock_handle().await?;
    match reading {
        Ok(reading) => db.set_progress_handler(STEPS, move || !reading.is_over()),
        Err(_) => db.remove_progress_handler(),
    }
    Ok(())
}

/// Returns whether a URL has a user with a password where the other store has them: an error about
/// such a file would show the password.
fn names_a_user(url: &str) -> bool {
    let rest = url.trim_start_matches("sqlite:").trim_start_matches('/');
    let user = rest.split(['/', '?']).next().and_then(|place| place.rsplit_once('@'));
    user.is_some_and(|(user, _)| user.contains(':'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::sql::{EndsRead, Watch};

    /// A query that never ends by itself.
    const ENDLESS: &str =
        "WITH RECURSIVE c (x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT count(*) FROM c WHERE x < 0";

    #[tokio::test]
    async fn a_read_ends_at_its_timeout_or_when_abandoned() {
        let folder = tempfile::tempdir().unwrap();
        let mut settings = StoreSettings::of_file(folder.path().join("jobs.db"));
        settings.readers = 1;
        drop(settings.open_writer().await.unwrap());
        let readers = settings.open_readers().await.unwrap();
        let read = |sql: &'static str, watch: &Arc<Watch>| {
            let readers = readers.clone();
            READING.scope(watch.clone(), async move { sqlx::query(sql).fetch_all(&readers).await.map(drop) })
        };
        let short = Watch::lasting(Duration::from_millis(20));
        let error = read(ENDLESS, &short).await.unwrap_err();
        assert_eq!(crate::store::sqlite::error::code(&error), Some(9), "interrupted: {error}");
        // an abandoned read frees the only reader
        let left = Watch::lasting(Duration::from_secs(3600));
        let mut reading = Box::pin(read(ENDLESS, &left));
        tokio::select! {
            _ = &mut reading => unreachable!("it does not end"),
            () = async { while readers.num_idle() > 0 { tokio::task::yield_now().await } } => {}
        }
        drop(reading);
        drop(EndsRead(left));
        let next = Watch::lasting(Duration::from_secs(3600));
        read("SELECT 1", &next).await.unwrap();
    }
}
