//! The task that owns the writing connection.
//!
//! Requests arrive over a bounded channel. The task takes everything that waits, up to a limit of
//! count and of bytes, runs it inside one `BEGIN IMMEDIATE … COMMIT`, and answers each request
//! after the commit: while one group is being synced the next one gathers, so the more requests
//! come, the more share a sync. A request that is refused refuses before it changes anything and
//! spoils nothing. Should the database refuse a group as a whole (a constraint that the checks did
//! not foresee), each of its requests is tried again alone, so that only the guilty one fails.

use std::{fs::File, mem, sync::Arc, time::Instant};

use sqlx::SqliteConnection;
use tokio::sync::{mpsc, oneshot};
use uuid::Uuid;

use super::{
    bulk::{self, Incoming},
    error::{code, failure},
    open::StoreSettings,
    records,
    streams::{self, IncomingBlock, IncomingFinish},
    write::{self, WriteError},
};
use crate::{
    jobs::{Choice, Job, JobPatch, NewFit, NewStream, Precondition, Receipt, Record, RepositoryError, Ruling, Stored},
    telemetry,
};

/// What is to be written.
pub enum Work {
    InsertJob { job: Job, receipt: Option<Receipt> },
    PatchJob { id: Uuid, patch: JobPatch, precondition: Precondition, now: jiff::Timestamp },
    DeleteJob { id: Uuid, precondition: Precondition },
    InsertIteration(Incoming),
    InsertFit { job: Uuid, number: u32, fit: Arc<NewFit>, receipt: Option<Receipt> },
    Choose { job: Uuid, number: u32, choice: Choice, precondition: Precondition },
    Rule { job: Uuid, number: u32, ruling: Ruling, precondition: Precondition },
    InsertRecord { job: Uuid, number: u32, record: Arc<Record>, receipt: Option<Receipt> },
    InsertStream { stream: Arc<NewStream>, receipt: Option<Receipt> },
    InsertBlock(IncomingBlock),
    FinishStream(IncomingFinish),
    DeleteStream { id: Uuid, precondition: Precondition, now: jiff::Timestamp },
    InsertRuns { runs: Vec<(Job, Vec<Incoming>)>, receipt: Option<Receipt>, now: jiff::Timestamp },
    ForgetAnswers { before: jiff::Timestamp, most: u32 },
    Probe { now: jiff::Timestamp },
}

/// What came of it.
#[derive(Debug)]
pub enum Outcome {
    Stored(Stored),
    Job(Box<Job>),
    Deleted,
    /// So many answers.
    Forgotten(u64),
    Done,
}

/// Work and where its outcome goes.
pub struct Request {
    pub work: Work,
    pub reply: oneshot::Sender<Result<Outcome, RepositoryError>>,
}

impl Request {
    fn end(self, outcome: Result<Outcome, RepositoryError>) {
        // First of all the idempotency key is given back: whoever hears the outcome may ask again
        // at once.
        drop(self.work);
        // Whoever asked may be gone; what was asked is done.
        let _gone = self.reply.send(outcome);
    }
}

#[expect(clippy::large_enum_variant, reason = "nearly every message is the large one")]
pub enum Message {
    Write(Request),
    /// Finish what was sent before, close the database, answer.
    Close(oneshot::Sender<()>),
}

/// Requests in one transaction.
const MOST_REQUESTS: usize = 128;
/// Bytes of nodes and answers in one transaction, roughly: big node sets do not pile up in one.
const MOST_BYTES: usize = 32 << 20;

/// SQLite's primary codes for data it will not have: constraint, mismatch, too big.
const REFUSING_CODES: [i32; 3] = [19, 20, 18];

pub struct Writer {
    settings: StoreSettings,
    connection: SqliteConnection,
    /// Held as long as this writes.
    lock: Option<File>,
    incoming: mpsc::Receiver<Message>,
    commit_seconds: metrics::Histogram,
}

impl Writer {
    pub fn new(
        settings: StoreSettings,
        connection: SqliteConnection,
        lock: Option<File>,
        incoming: mpsc::Receiver<Message>,
    ) -> Self {
        Writer {
            settings,
            connection,
            lock,
            incoming,
            commit_seconds: metrics::histogram!(telemetry::STORE_SECONDS, "operation" => "commit"),
        }
    }

    /// Writes until everybody who could ask is gone or somebody closes the store.
    pub async fn run(mut self) {
        let mut closing = None;
        let mut group = Vec::new();
        while let Some(message) = self.incoming.recv().await {
            self.gather(message, &mut group, &mut closing);
            if !group.is_empty() {
                let begun = Instant::now();
                self.serve(mem::take(&mut group)).await;
                self.commit_seconds.record(begun.elapsed());
            }
        }
        if let Err(error) = sqlx::Connection::close(self.connection).await {
            tracing::warn!(%error, "the database did not close cleanly");
        }
        drop(self.lock);
        if let Some(closed) = closing {
            let _gone = closed.send(());
        }
    }

    /// Everything that waits, up to the limits.
    fn gather(&mut self, first: Message, group: &mut Vec<Request>, closing: &mut Option<oneshot::Sender<()>>) {
        let mut bytes = 0;
        let mut next = Some(first);
        while let Some(message) = next {
            match message {
                Message::Write(request) => {
                    bytes += request.work.bytes();
                    group.push(request);
                }
                Message::Close(closed) => {
                    // What is in the channel is still received; what comes later is refused.
                    self.incoming.close();
                    *closing = Some(closed);
                }
            }
            next = if group.len() < MOST_REQUESTS && bytes < MOST_BYTES { self.incoming.try_recv().ok() } else { None };
        }
    }

    async fn serve(&mut self, group: Vec<Request>) {
        match self.transact(&group).await {
            Ok(outcomes) => {
                for (request, outcome) in group.into_iter().zip(outcomes) {
                    request.end(outcome);
                }
            }
            Err(error) if group.len() > 1 && code(&error).is_some_and(|code| REFUSING_CODES.contains(&code)) => {
                tracing::error!(%error, requests = group.len(), "a group of writes was refused; each is tried alone");
                for request in group {
                    let outcome = match self.transact(std::slice::from_ref(&request)).await {
                        Ok(mut outcomes) => outcomes.pop().unwrap_or_else(|| Err(lost())),
                        Err(error) => Err(failure(&error)),
                    };
                    request.end(outcome);
                }
            }
            Err(error) => {
                tracing::error!(%error, requests = group.len(), "a transaction failed");
                for request in group {
                    request.end(Err(failure(&error)));
                }
            }
        }
    }

    /// One transaction. Afterwards it is committed or undone, whatever happened.
    async fn transact(&mut self, group: &[Request]) -> Result<Vec<Result<Outcome, RepositoryError>>, sqlx::Error> {
        let result = run_group(&mut self.connection, group).await;
        if let Err(error) = &result {
            // SQLite undoes some failed transactions itself and then says that there is none: both
            // are fine.
            let undone = sqlx::query("ROLLBACK").execute(&mut self.connection).await;
            let lost = |error: &sqlx::Error| matches!(error, sqlx::Error::WorkerCrashed | sqlx::Error::Io(_));
            if lost(error) || undone.is_err_and(|error| lost(&error)) {
                match self.settings.reopen_writer().await {
                    Ok(connection) => self.connection = connection,
                    Err(error) => tracing::error!(%error, "the writing connection was lost and cannot be opened again"),
                }
            }
        }
        result
    }
}

async fn run_group(
    db: &mut SqliteConnection,
    group: &[Request],
) -> Result<Vec<Result<Outcome, RepositoryError>>, sqlx::Error> {
    sqlx::query("BEGIN IMMEDIATE").execute(&mut *db).await?;
    let mut outcomes: Vec<Option<Result<Outcome, RepositoryError>>> = Vec::with_capacity(group.len());
    for request in group {
        outcomes.push(match run_single(db, &request.work).await {
            None => None,
            Some(Ok(outcome)) => Some(Ok(outcome)),
            Some(Err(WriteError::Refused(error))) => Some(Err(error)),
            Some(Err(WriteError::Broken(error))) => return Err(error),
        });
    }
    let iterations: Vec<&Incoming> = group
        .iter()
        .filter_map(|request| match &request.work {
            Work::InsertIteration(incoming) => Some(incoming),
            _ => None,
        })
        .collect();
    if !iterations.is_empty() {
        let stored = match bulk::insert_iterations(db, &iterations).await {
            Ok(stored) => stored,
            Err(WriteError::Broken(error)) => return Err(error),
            Err(WriteError::Refused(error)) => return Err(sqlx::Error::Protocol(error.to_string())),
        };
        let open = outcomes.iter_mut().filter(|outcome| outcome.is_none());
        for (outcome, stored) in open.zip(stored) {
            *outcome = Some(stored.map(Outcome::Stored));
        }
    }
    sqlx::query("COMMIT").execute(&mut *db).await?;
    Ok(outcomes.into_iter().map(|outcome| outcome.unwrap_or_else(|| Err(lost()))).collect())
}

/// Runs what is not a new iteration.
async fn run_single(db: &mut SqliteConnection, work: &Work) -> Option<Result<Outcome, WriteError>> {
    Some(match work {
        Work::InsertIteration(_) => return None,
        Work::InsertJob { job, receipt } => write::insert_job(db, job, receipt.as_ref()).await.map(Outcome::Stored),
        Work::PatchJob { id, patch, precondition, now } => {
            write::patch_job(db, *id, patch.clone(), precondition, *now).await.map(|job| Outcome::Job(Box::new(job)))
        }
        Work::DeleteJob { id, precondition } => {
            write::delete_job(db, *id, precondition).await.map(|()| Outcome::Deleted)
        }
        Work::InsertFit { job, number, fit, receipt } => {
            write::insert_fit(db, *job, *number, fit, receipt.as_ref()).await.map(Outcome::Stored)
        }
        Work::Choose { job, number, choice, precondition } => {
            write::choose(db, *job, *number, choice, precondition).await.map(Outcome::Stored)
        }
        Work::Rule { job, number, ruling, precondition } => {
            write::rule(db, *job, *number, ruling, precondition).await.map(Outcome::Stored)
        }
        Work::InsertRecord { job, number, record, receipt } => {
            records::insert(db, *job, *number, record, receipt.as_ref()).await.map(Outcome::Stored)
        }
        Work::InsertStream { stream, receipt } => {
            streams::insert_stream(db, stream, receipt.as_ref()).await.map(Outcome::Stored)
        }
        Work::InsertBlock(incoming) => streams::insert_block(db, incoming).await.map(Outcome::Stored),
        Work::FinishStream(finish) => streams::finish_stream(db, finish).await.map(Outcome::Stored),
        Work::DeleteStream { id, precondition, now } => {
            streams::delete_stream(db, *id, precondition, *now).await.map(|()| Outcome::Deleted)
        }
        Work::InsertRuns { runs, receipt, now } => {
            write::insert_runs(db, runs, receipt.as_ref(), *now).await.map(Outcome::Stored)
        }
        Work::ForgetAnswers { before, most } => {
            write::forget_answers(db, *before, i64::from(*most)).await.map(Outcome::Forgotten).map_err(WriteError::from)
        }
        Work::Probe { now } => write::probe(db, *now).await.map(|()| Outcome::Done),
    })
}

impl Work {
    /// Roughly what it adds to the log.
    fn bytes(&self) -> usize {
        match self {
            Work::InsertIteration(incoming) => incoming.nodes.len() + incoming.iteration.fit.computed.result.len(),
            Work::InsertFit { fit, .. } => fit.computed.result.len(),
            Work::InsertRecord { record, .. } => record.draft.request.len() + record.draft.result.len(),
            Work::InsertBlock(incoming) => incoming.nodes.len() + incoming.block.state.as_ref().map_or(0, Vec::len),
            Work::FinishStream(IncomingFinish { incoming, .. }) => {
                incoming.nodes.len() + incoming.iteration.fit.computed.result.len()
            }
            Work::InsertRuns { runs, .. } => {
                let size = |new: &Incoming| new.nodes.len() + new.iteration.fit.computed.result.len();
                runs.iter().flat_map(|(_, iterations)| iterations).map(size).sum()
            }
            _ => 0,
        }
    }
}

fn lost() -> RepositoryError {
    RepositoryError::Failed("a write ended without an outcome".into())
}
