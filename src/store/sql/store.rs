//! The store: an open database with its writers and its readers.

use std::{pin::Pin, sync::Arc, time::Instant};

use futures_util::future::join_all;

use super::{
    answers::ForgetAnswers,
    auditor::{SealAudit, SqlAuditor},
    db::Pool,
    error::reading,
    events::ForgetTold,
    handle::Handle,
    holdings::SqlHoldings,
    prelude::*,
    purges,
    queue::Queue,
    read_turns::ReadTurns,
    upkeep::{self, Probe},
    write::{Request, Subject},
};
use crate::{
    jobs::{
        self,
        archive::{Holdings, Key},
        audit::{Auditor, Sealed, Sealing},
    },
    store::postgres::{self, Notifications, PostgresSettings},
    telemetry,
};

/// Jobs of every tenant in one database.
pub struct SqlStore(pub(in crate::store) Arc<Database>);

/// An open database: writes go to the writers, reads to the pool.
pub struct Database {
    /// For requests of callers, shared fairly and with a time limit.
    pub readers: Pool,
    pub turns: ReadTurns,
    /// For archives, audits and maintenance, which may take long.
    pub aside: Pool,
    /// One for each writer.
    pub queues: Vec<Queue>,
    pub read_seconds: metrics::Histogram,
    pub clock: Arc<dyn Clock>,
    /// None where one process uses the database.
    pub shared: Option<Shared>,
}

/// The parts of a database that several processes use.
pub struct Shared {
    pub settings: Arc<PostgresSettings>,
    pub wakes: Arc<Notifications>,
}

/// Returns the histogram of one kind of operation of the store.
pub fn seconds(operation: &'static str) -> metrics::Histogram {
    metrics::histogram!(telemetry::STORE_SECONDS, "operation" => operation)
}

impl Database {
    /// Returns the name of this kind of database in spans (`db.system.name` of OpenTelemetry).
    pub fn system(&self) -> &'static str {
        if self.shared.is_some() { "postgresql" } else { "sqlite" }
    }

    /// Returns the queue of a subject. Writes of one job wait in one queue, in their order. (Blocks
    /// of a stream wait in one too; the lock of the job separates them from its other writes.)
    pub fn queue(&self, subject: Subject) -> &Queue {
        let of = match subject {
            Subject::Job(id) | Subject::Stream(id) => id.as_u64_pair().1,
            Subject::Nothing => 0,
        };
        &self.queues[(of % self.queues.len() as u64) as usize]
    }

    /// Returns whether a read that failed, and that began then, is tried again: after a restart of
    /// the server every connection of the pool is a lost one.
    pub fn reads_again(&self, error: &sqlx::Error, begun: Instant) -> bool {
        let patience = self.shared.as_ref().map(|shared| shared.settings.patience);
        patience.is_some_and(|patience| postgres::is_lost(error) && begun.elapsed() < patience)
    }

    fn write<W: Write>(&self, write: W) -> RepositoryFuture<'_, W::Reply> {
        Box::pin(self.queue(Subject::Nothing).write(Request::of_nobody(Subject::Nothing, 0), write))
    }
}

impl jobs::Store for SqlStore {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn keys(&self, caller: &Caller) -> Arc<dyn Keys> {
        Arc::new(Handle::new(self.0.clone(), caller.clone()))
    }

    fn auditor(&self) -> Arc<dyn Auditor> {
        Arc::new(SqlAuditor(self.0.aside.clone()))
    }

    fn credentials(&self) -> Arc<dyn Credentials> {
        Arc::new(Handle::of_nobody(self.0.clone()))
    }

    fn holdings(&self) -> Arc<dyn Holdings> {
        Arc::new(SqlHoldings::read_only(self.0.aside.clone()))
    }

    fn wakes(&self) -> Option<Arc<dyn Wakes>> {
        Some(self.0.shared.as_ref()?.wakes.clone())
    }
}

impl Upkeep for SqlStore {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.0.write(ForgetAnswers { before, most })
    }

    fn forget_event_order(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.0.write(ForgetTold { now, before, most })
    }

    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Sealed>> {
        self.0.write(SealAudit(sealing))
    }

    fn untouched(&self, since: Timestamp, after: Option<Key>, most: u32) -> RepositoryFuture<'_, Vec<Key>> {
        reading(purges::untouched(&self.0.aside, since, after, most))
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        self.0.write(Probe { now })
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        Box::pin(async {
            let _turn = self.0.turns.take(&None).await?;
            upkeep::ping(&self.0.readers, &*self.0.clock).await
        })
    }

    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>> {
        Box::pin(async {
            // a reader that is still at work does not keep the writers from ending
            let queues = join_all(self.0.queues.iter().map(Queue::close));
            tokio::join!(queues, self.0.readers.close(), self.0.aside.close());
        })
    }
}
