//! The store: an open database with its writer and its readers.

use std::{pin::Pin, sync::Arc};

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};

use super::{
    audit_seals,
    auditor::SqliteAuditor,
    error::{OpenError, failure},
    holdings::SqliteHoldings,
    lock,
    open::StoreSettings,
    purges, tasks, time, upkeep,
    writer::Writer,
};
use crate::{
    jobs::{
        self, ANSWERS_KEPT, Caller, Clock, Credentials, Ids, Keys, Repository, RepositoryError, RepositoryFuture,
        Tasks, Turn, Upkeep,
        archive::{Holdings, Key},
        audit::{Auditor, Sealing, Unsealed, WholeSeal},
    },
    store::shared::{
        Backend, ForgetAnswers, ForgetTold, Handle, Probe, Queue, ReadTurns, Run, SealAudit, StoreError, Subject, queue,
    },
    telemetry,
};

/// Jobs of every tenant in one database file.
pub struct SqliteStore(Arc<Database>);

/// An open database: writes go to the writer, reads to the pool.
struct Database {
    /// For requests of callers, shared fairly and with a time limit.
    readers: SqlitePool,
    turns: ReadTurns,
    /// For archives, audits and maintenance, which may take long.
    aside: SqlitePool,
    queue: Queue<SqliteConnection>,
    read_seconds: metrics::Histogram,
    ids: Arc<dyn Ids>,
    clock: Arc<dyn Clock>,
}

impl SqliteStore {
    /// Opens the database (making it where there is none), brings it up to date and starts the
    /// writer.
    pub async fn open(settings: StoreSettings, ids: Arc<dyn Ids>, clock: Arc<dyn Clock>) -> Result<Self, OpenError> {
        // What is measured before there is a recorder is lost.
        telemetry::metrics();
        let path = settings.path();
        let lock = lock::take(&path).await?;
        let mut connection = settings.open_writer().await?;
        let old = ForgetAnswers { before: clock.now() - ANSWERS_KEPT, most: u32::MAX };
        old.run(&mut connection).await.map_err(|error| OpenError::from_store(path.clone(), error))?;
        tasks::free_all(&mut connection).await.map_err(|error| OpenError::from_store(path, error.into()))?;
        let (readers, turns) = (settings.open_readers().await?, ReadTurns::new(settings.readers));
        let aside = settings.open_aside().await?;
        let seconds = |operation| metrics::histogram!(telemetry::STORE_SECONDS, "operation" => operation);
        let (queue, waiting) = queue(settings.queue, seconds("write"));
        tokio::spawn(Writer::new(settings, connection, lock, waiting).run());
        Ok(SqliteStore(Arc::new(Database { readers, turns, aside, queue, read_seconds: seconds("read"), ids, clock })))
    }
}

impl Backend for Database {
    const SYSTEM: &'static str = "sqlite";

    type Readers = SqlitePool;
    type Connection = SqliteConnection;

    fn readers(&self) -> &SqlitePool {
        &self.readers
    }

    fn queue(&self, _subject: Subject) -> &Queue<SqliteConnection> {
        &self.queue
    }

    fn surroundings(&self) -> (&dyn Ids, &dyn Clock) {
        (&*self.ids, &*self.clock)
    }

    fn turns(&self) -> &ReadTurns {
        &self.turns
    }

    fn read_seconds(&self) -> &metrics::Histogram {
        &self.read_seconds
    }

    fn failure(error: &sqlx::Error) -> RepositoryError {
        failure(error)
    }
}

impl jobs::Store for SqliteStore {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn keys(&self, caller: &Caller) -> Arc<dyn Keys> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn auditor(&self) -> Arc<dyn Auditor> {
        Arc::new(SqliteAuditor(self.0.aside.clone()))
    }

    fn credentials(&self) -> Arc<dyn Credentials> {
        Arc::new(Handle::of_nobody(self.0.clone()))
    }

    fn tasks(&self) -> Arc<dyn Tasks> {
        Arc::new(Handle::of_nobody(self.0.clone()))
    }

    fn holdings(&self) -> Arc<dyn Holdings> {
        Arc::new(SqliteHoldings::of(self.0.aside.clone()))
    }
}

impl Upkeep for SqliteStore {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        Box::pin(self.0.queue.write(ForgetAnswers { before, most }))
    }

    fn forget_told(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        Box::pin(self.0.queue.write(ForgetTold { now, before, most }))
    }

    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Vec<WholeSeal>>> {
        Box::pin(self.0.queue.write(SealAudit(sealing)))
    }

    fn unsealed(&self) -> RepositoryFuture<'_, Unsealed> {
        Box::pin(async { audit_seals::unsealed(&self.0.aside).await.map_err(|error| failure(&error)) })
    }

    /// The process is the only one.
    fn turn(&self) -> RepositoryFuture<'_, Option<Turn>> {
        Box::pin(async { Ok(Some(Turn(None))) })
    }

    fn untouched(&self, since: Timestamp, most: u32) -> RepositoryFuture<'_, Vec<Key>> {
        Box::pin(async move {
            let untouched = purges::untouched(&self.0.aside, &time::to_text(since), most).await;
            untouched.map_err(|error| match error {
                StoreError::Refused(error) => error,
                StoreError::Broken(error) => failure(&error),
            })
        })
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        Box::pin(self.0.queue.write(Probe { now }))
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        Box::pin(async {
            let _turn = self.0.turns.take(&None).await?;
            upkeep::ping(&self.0.readers).await.map_err(|error| failure(&error))
        })
    }

    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>> {
        Box::pin(async {
            self.0.readers.close().await;
            self.0.aside.close().await;
            self.0.queue.close().await;
        })
    }
}
