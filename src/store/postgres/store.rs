//! The store: an open database with its writers and its readers.

use std::{pin::Pin, sync::Arc, time::Instant};

use futures_util::future::join_all;
use jiff::Timestamp;
use sqlx::PgPool;

use super::{
    audit_seals,
    auditor::PostgresAuditor,
    error::{Class, PostgresError, class, failure},
    holdings::PostgresHoldings,
    migrate::migrate,
    open, purges,
    session::Session,
    settings::{Migrate, PostgresSettings},
    upkeep,
    wakes::Notifications,
    writer::Writer,
};
use crate::{
    jobs::{
        self, Caller, Clock, Credentials, Ids, Keys, Repository, RepositoryError, RepositoryFuture, Tasks, Turn,
        Upkeep, Wakes,
        archive::{Holdings, Key},
        audit::{Auditor, Sealing, Unsealed, WholeSeal},
    },
    store::shared::{Backend, ForgetAnswers, ForgetTold, Handle, Probe, Queue, ReadTurns, SealAudit, Subject, queue},
    telemetry,
};

/// Jobs of every tenant in one database, which other processes use too.
pub struct PostgresStore(Arc<Database>);

/// An open database: writes go to the writers, reads to the pool.
struct Database {
    settings: Arc<PostgresSettings>,
    /// For requests of callers, shared fairly and with a time limit.
    readers: PgPool,
    turns: ReadTurns,
    /// For archives, audits and maintenance, which may take long.
    aside: PgPool,
    queues: Vec<Queue<Session>>,
    read_seconds: metrics::Histogram,
    ids: Arc<dyn Ids>,
    clock: Arc<dyn Clock>,
    wakes: Arc<Notifications>,
}

impl PostgresStore {
    /// Opens the database, brings it up to date if that is wanted, and starts the writers.
    pub async fn open(
        settings: PostgresSettings,
        ids: Arc<dyn Ids>,
        clock: Arc<dyn Clock>,
    ) -> Result<Self, PostgresError> {
        // What is measured before there is a recorder is lost.
        telemetry::metrics();
        open::check(&settings).await?;
        if settings.migrate == Migrate::Auto {
            migrate(&settings).await?;
        }
        let settings = Arc::new(settings);
        let seconds = |operation| metrics::histogram!(telemetry::STORE_SECONDS, "operation" => operation);
        let mut queues = Vec::new();
        for _ in 0..settings.writers.max(1) {
            let (queue, waiting) = queue(settings.queue, seconds("write"));
            let (settings, ids, clock) = (settings.clone(), ids.clone(), clock.clone());
            tokio::spawn(Writer { settings, ids, clock, waiting, session: None }.run());
            queues.push(queue);
        }
        let (readers, aside) = (open::readers(&settings), open::aside(&settings));
        let turns = ReadTurns::new(settings.readers);
        let wakes = Arc::new(Notifications::new(settings.clone(), aside.clone(), ids.fresh(clock.now())));
        let read_seconds = seconds("read");
        Ok(PostgresStore(Arc::new(Database {
            settings,
            readers,
            turns,
            aside,
            queues,
            read_seconds,
            ids,
            clock,
            wakes,
        })))
    }
}

impl Backend for Database {
    const SYSTEM: &'static str = "postgresql";

    type Readers = PgPool;
    type Connection = Session;

    fn readers(&self) -> &PgPool {
        &self.readers
    }

    /// Writes of one job wait in one queue, in their order. (Blocks of a stream wait in one too;
    /// against its job's other writes they are held by the lock of the job.)
    fn queue(&self, subject: Subject) -> &Queue<Session> {
        let of = match subject {
            Subject::Job(id) | Subject::Stream(id) => id.as_u64_pair().1,
            Subject::Nothing => 0,
        };
        &self.queues[(of % self.queues.len() as u64) as usize]
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

    /// After a restart of the server every connection of the pool is a lost one.
    fn reads_again(&self, error: &sqlx::Error, begun: Instant) -> bool {
        class(error) == Class::Lost
            && !matches!(error, sqlx::Error::PoolTimedOut)
            && begun.elapsed() < self.settings.patience
    }
}

impl jobs::Store for PostgresStore {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn keys(&self, caller: &Caller) -> Arc<dyn Keys> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn auditor(&self) -> Arc<dyn Auditor> {
        Arc::new(PostgresAuditor(self.0.aside.clone()))
    }

    fn credentials(&self) -> Arc<dyn Credentials> {
        Arc::new(Handle::of_nobody(self.0.clone()))
    }

    fn tasks(&self) -> Arc<dyn Tasks> {
        Arc::new(Handle::of_nobody(self.0.clone()))
    }

    fn holdings(&self) -> Arc<dyn Holdings> {
        Arc::new(PostgresHoldings::of(self.0.aside.clone()))
    }

    fn wakes(&self) -> Option<Arc<dyn Wakes>> {
        Some(self.0.wakes.clone())
    }
}

impl Upkeep for PostgresStore {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        Box::pin(self.0.queue(Subject::Nothing).write(ForgetAnswers { before, most }))
    }

    fn forget_told(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        Box::pin(self.0.queue(Subject::Nothing).write(ForgetTold { now, before, most }))
    }

    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Vec<WholeSeal>>> {
        Box::pin(self.0.queue(Subject::Nothing).write(SealAudit(sealing)))
    }

    fn unsealed(&self) -> RepositoryFuture<'_, Unsealed> {
        Box::pin(async { audit_seals::unsealed(&self.0.aside).await.map_err(|error| failure(&error)) })
    }

    fn turn(&self) -> RepositoryFuture<'_, Option<Turn>> {
        Box::pin(async { purges::turn(&self.0.settings).await.map_err(|error| failure(&error)) })
    }

    fn untouched(&self, since: Timestamp, most: u32) -> RepositoryFuture<'_, Vec<Key>> {
        Box::pin(async move { purges::untouched(&self.0.aside, since, most).await.map_err(|error| failure(&error)) })
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        Box::pin(self.0.queue(Subject::Nothing).write(Probe { now }))
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        Box::pin(async {
            let _turn = self.0.turns.take(&None).await?;
            upkeep::ping(&self.0.readers, &*self.0.clock).await
        })
    }

    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>> {
        Box::pin(async {
            self.0.readers.close().await;
            self.0.aside.close().await;
            join_all(self.0.queues.iter().map(Queue::close)).await;
        })
    }
}
