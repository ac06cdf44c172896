//! A task that owns a writing connection.
//!
//! It runs each group of its queue inside one transaction. Should the database refuse a group as a
//! whole, each of its writes is tried again alone, so that only the guilty one fails. Where another
//! transaction was in the way the group is tried again, and where the connection was lost, on
//! another one, as long as there is patience.

use std::{
    io, slice,
    sync::Arc,
    time::{Duration, Instant},
};

use sqlx::AssertSqlSafe;
use uuid::Uuid;

use super::{
    error::{Class, class, failure, said},
    open,
    settings::PostgresSettings,
};
use crate::{
    jobs::{Clock, Ids, RepositoryError},
    store::sql::{Group, Proof, Queued, Session, Waiting, run_group, seconds},
    telemetry,
};

/// How often a transaction is tried again that was in another's way.
const MOST_CONFLICTS: u32 = 3;
/// Between two attempts to reach a server.
const PAUSE: Duration = Duration::from_millis(100);
/// A transaction that has heard nothing for so long is lost with its connection.
const SILENCE: Duration = Duration::from_secs(45);

pub struct Writer {
    pub settings: Arc<PostgresSettings>,
    /// The source of the ids of transactions.
    pub ids: Arc<dyn Ids>,
    pub clock: Arc<dyn Clock>,
    pub waiting: Waiting,
    /// None before the first transaction and after the connection was lost.
    pub session: Option<Session>,
}

/// The results of the earlier attempts at a transaction.
#[derive(Default)]
struct Earlier {
    /// True if one may have been committed.
    undecided: bool,
    /// The entry that proves it. (Without one nothing was changed that could be changed twice.)
    proof: Option<Proof>,
}

/// The failure of a transaction.
enum Failure {
    /// Nothing was stored.
    Nothing(sqlx::Error),
    /// Nobody knows whether everything was stored or nothing.
    Unknown(sqlx::Error),
}

impl Failure {
    fn is_refusal(&self) -> bool {
        matches!(self, Failure::Nothing(error) if class(error) == Class::Refused)
    }

    fn to_error(&self) -> RepositoryError {
        match self {
            Failure::Nothing(error) => failure(error),
            Failure::Unknown(error) => RepositoryError::OutcomeUnknown(said(error)),
        }
    }
}

impl Writer {
    /// Writes until everybody who could ask is gone or somebody closes the store.
    pub async fn run(mut self) {
        let commit_seconds = seconds("commit");
        while let Some(group) = self.waiting.next_group().await {
            let begun = Instant::now();
            self.serve(group).await;
            commit_seconds.record(begun.elapsed());
        }
        if let Some(session) = self.session
            && let Err(error) = session.db.close().await
        {
            tracing::warn!(error = said(&error), "a connection to the database did not close cleanly");
        }
        self.waiting.closed();
    }

    async fn serve(&mut self, mut group: Group) {
        match self.store(&mut group).await {
            Ok(()) => group.into_iter().for_each(|write| write.end(None)),
            Err(failure) if group.len() > 1 && failure.is_refusal() => {
                let requests = group.len();
                tracing::error!(error = %failure.to_error(), requests, "a group of writes failed; trying each alone");
                for mut write in group {
                    let failed = self.store(slice::from_mut(&mut write)).await.err();
                    write.end(failed.map(|failure| failure.to_error()));
                }
            }
            Err(failure) => {
                tracing::error!(error = %failure.to_error(), requests = group.len(), "a transaction failed");
                group.into_iter().for_each(|write| write.end(Some(failure.to_error())));
            }
        }
    }

    /// Stores a group, in as many attempts as it takes.
    async fn store(&mut self, group: &mut [Box<dyn Queued>]) -> Result<(), Failure> {
        let (change, begun) = (self.ids.fresh(self.clock.now()), Instant::now());
        let (mut conflicts, mut earlier) = (0, Earlier::default());
        loop {
            let Err(error) = self.attempt(change, group, &mut earlier).await else { return Ok(()) };
            match class(&error) {
                Class::Again if conflicts < MOST_CONFLICTS => conflicts += 1,
                Class::Lost if begun.elapsed() < self.settings.patience => tokio::time::sleep(PAUSE).await,
                _ if earlier.undecided => return Err(Failure::Unknown(error)),
                _ => return Err(Failure::Nothing(error)),
            }
            metrics::counter!(telemetry::STORE_RETRIES).increment(1);
            tracing::debug!(error = said(&error), "a transaction is tried again");
        }
    }

    /// One transaction. Afterwards it is committed, or undone, or its connection is given up.
    async fn attempt(
        &mut self,
        change: Uuid,
        group: &mut [Box<dyn Queued>],
        earlier: &mut Earlier,
    ) -> Result<(), sqlx::Error> {
        let mut session = match self.session.take() {
            Some(session) => session,
            None => Session::of(open::connect(&self.settings).await?.into()),
        };
        let silent = || Err(sqlx::Error::Io(io::ErrorKind::TimedOut.into()));
        let running = transact(&mut session, change, group, earlier);
        let outcome = tokio::time::timeout(SILENCE, running).await.unwrap_or_else(|_| silent());
        let Err(error) = outcome else {
            self.session = Some(session);
            return Ok(());
        };
        if class(&error) == Class::Lost {
            return Err(error);
        }
        match session.db.run("ROLLBACK", &[]).await {
            Ok(_) => {
                self.session = Some(session);
                Err(error)
            }
            // the last answer of the server is lost with the connection
            Err(_) => Err(sqlx::Error::Io(io::Error::new(io::ErrorKind::ConnectionAborted, said(&error)))),
        }
    }
}

async fn transact(
    session: &mut Session,
    change: Uuid,
    group: &mut [Box<dyn Queued>],
    earlier: &mut Earlier,
) -> Result<(), sqlx::Error> {
    // one with the same lock that is still running is waited for
    let lock = change.as_u64_pair().1.cast_signed();
    session.db.script(AssertSqlSafe(format!("BEGIN; SELECT pg_advisory_xact_lock({lock})"))).await?;
    // an earlier attempt has ended by now
    let committed = session.was_committed(earlier.proof).await?;
    earlier.undecided = false;
    if committed {
        // its outcome was noted then; should the connection be lost now, it is still no failure
        // that stored nothing
        earlier.undecided = true;
        return session.db.run("ROLLBACK", &[]).await.map(|_| ());
    }
    session.lock(group.iter().map(|write| write.request()).collect()).await?;
    run_group(session, group).await?;
    earlier.proof = session.finish().await?;
    earlier.undecided = true;
    let committed = session.db.run("COMMIT", &[]).await.map(|_| ());
    earlier.undecided = committed.as_ref().is_err_and(|error| !matches!(class(error), Class::Again | Class::Refused));
    committed
}
