//! The store as the jobs see it: writes go to the writer, reads to the pool.

use std::{sync::Arc, time::Instant};

use jiff::Timestamp;
use sqlx::SqlitePool;
use tokio::sync::{mpsc, oneshot};
use uuid::Uuid;

use super::{
    bulk::Incoming,
    error::OpenError,
    lock,
    open::StoreSettings,
    read, records,
    streams::{self, IncomingBlock, IncomingFinish},
    write,
    writer::{Message, Outcome, Request, Work, Writer},
};
use crate::{
    jobs::{
        ANSWERS_KEPT, Answer, Block, Choice, FinishedStream, FitRecord, FitSummary, Iteration, Job, JobEvent, JobPatch,
        Later, Measurand, NewBlock, NewFit, NewIteration, NewRun, NewStream, Page, PageRequest, Precondition, Receipt,
        Record, RecordKind, RecordSummary, Repository, RepositoryError, RepositoryFuture, Ruling, Stored, Stream,
        StreamState, Trace, nodes_codec,
    },
    telemetry,
};
use flankfit_engine::estimation::Nodes;

/// An open database.
pub struct Store {
    readers: SqlitePool,
    writer: mpsc::Sender<Message>,
    write_seconds: metrics::Histogram,
    read_seconds: metrics::Histogram,
}

impl Store {
    /// Opens the database (making it where there is none), brings it up to date and starts the
    /// writer.
    pub async fn open(settings: StoreSettings, now: Timestamp) -> Result<Self, OpenError> {
        // What is measured before there is a recorder is lost.
        telemetry::metrics();
        let path = settings.path();
        let lock = lock::take(&path).await?;
        let mut connection = settings.open_writer().await?;
        let forgotten = write::forget_answers(&mut connection, now - ANSWERS_KEPT, i64::MAX).await;
        forgotten.map_err(|source| OpenError::from_sqlx(path, source))?;
        let readers = settings.open_readers().await?;
        let (writer, incoming) = mpsc::channel(settings.queue.max(1));
        tokio::spawn(Writer::new(settings, connection, lock, incoming).run());
        Ok(Store {
            readers,
            writer,
            write_seconds: metrics::histogram!(telemetry::STORE_SECONDS, "operation" => "write"),
            read_seconds: metrics::histogram!(telemetry::STORE_SECONDS, "operation" => "read"),
        })
    }

    /// Finishes the writes that wait and closes the database. Later writes are refused.
    pub async fn close(&self) {
        let (closed, done) = oneshot::channel();
        self.readers.close().await;
        if self.writer.send(Message::Close(closed)).await.is_ok() {
            let _gone = done.await;
        }
    }

    /// The request is in the writer's hands before this returns its future: dropping the future
    /// changes nothing.
    fn write(&self, work: Work) -> impl Future<Output = Result<Outcome, RepositoryError>> + Send + use<> {
        let begun = Instant::now();
        let seconds = self.write_seconds.clone();
        let (reply, outcome) = oneshot::channel();
        let sent = self.writer.try_send(Message::Write(Request { work, reply }));
        async move {
            match sent {
                Ok(()) => {}
                Err(mpsc::error::TrySendError::Full(_)) => return Err(RepositoryError::Overloaded),
                Err(mpsc::error::TrySendError::Closed(_)) => return Err(closed()),
            }
            let outcome = outcome.await.unwrap_or_else(|_| Err(closed()));
            seconds.record(begun.elapsed());
            outcome
        }
    }

    fn write_stored(&self, work: Work) -> RepositoryFuture<'_, Stored> {
        let outcome = self.write(work);
        Box::pin(async move {
            match outcome.await? {
                Outcome::Stored(stored) => Ok(stored),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn read<'a, T: 'a>(
        &'a self,
        read: impl Future<Output = Result<T, RepositoryError>> + Send + 'a,
    ) -> RepositoryFuture<'a, T> {
        Box::pin(async move {
            let begun = Instant::now();
            let result = read.await;
            self.read_seconds.record(begun.elapsed());
            result
        })
    }
}

impl Repository for Store {
    fn insert_job(&self, job: Job, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::InsertJob { job, receipt })
    }

    fn job(&self, id: Uuid) -> RepositoryFuture<'_, Job> {
        self.read(read::job(&self.readers, id))
    }

    fn jobs(&self, page: PageRequest) -> RepositoryFuture<'_, Page<Job>> {
        self.read(read::jobs(&self.readers, page))
    }

    fn patch_job(
        &self,
        id: Uuid,
        patch: JobPatch,
        precondition: Precondition,
        now: Timestamp,
    ) -> RepositoryFuture<'_, Job> {
        let outcome = self.write(Work::PatchJob { id, patch, precondition, now });
        Box::pin(async move {
            match outcome.await? {
                Outcome::Job(job) => Ok(*job),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn delete_job(&self, id: Uuid, precondition: Precondition) -> RepositoryFuture<'_, ()> {
        let outcome = self.write(Work::DeleteJob { id, precondition });
        Box::pin(async move {
            match outcome.await? {
                Outcome::Deleted => Ok(()),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn insert_iteration(&self, iteration: Arc<NewIteration>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        let nodes = nodes_codec::encode(&iteration.nodes);
        self.write_stored(Work::InsertIteration(Incoming { iteration, nodes, receipt }))
    }

    fn iteration(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Iteration> {
        self.read(read::iteration(&self.readers, job, number))
    }

    fn nodes(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Nodes> {
        self.read(read::nodes(&self.readers, job, number))
    }

    fn nodes_up_to(&self, job: Uuid, number: u32, most: usize) -> RepositoryFuture<'_, Result<Nodes, usize>> {
        self.read(read::nodes_up_to(&self.readers, job, number, most))
    }

    fn measurand(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Measurand> {
        self.read(read::measurand(&self.readers, job, number))
    }

    fn later(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Later> {
        self.read(read::later(&self.readers, job, number))
    }

    fn trace(&self, job: Uuid, page: PageRequest) -> RepositoryFuture<'_, Trace> {
        self.read(read::trace(&self.readers, job, page))
    }

    fn fits(&self, job: Uuid, number: u32, page: PageRequest) -> RepositoryFuture<'_, Page<FitSummary>> {
        self.read(read::fits(&self.readers, job, number, page))
    }

    fn insert_fit(
        &self,
        job: Uuid,
        number: u32,
        fit: Arc<NewFit>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::InsertFit { job, number, fit, receipt })
    }

    fn fit(&self, job: Uuid, number: u32, fit: Uuid) -> RepositoryFuture<'_, FitRecord> {
        self.read(read::fit(&self.readers, job, number, fit))
    }

    fn choose(
        &self,
        job: Uuid,
        number: u32,
        choice: Choice,
        precondition: Precondition,
    ) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::Choose { job, number, choice, precondition })
    }

    fn rule(&self, job: Uuid, number: u32, ruling: Ruling, precondition: Precondition) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::Rule { job, number, ruling, precondition })
    }

    fn insert_record(
        &self,
        job: Uuid,
        number: u32,
        record: Arc<Record>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::InsertRecord { job, number, record, receipt })
    }

    fn record(&self, job: Uuid, number: u32, id: Uuid) -> RepositoryFuture<'_, Record> {
        self.read(records::record(&self.readers, job, number, id))
    }

    fn records(&self, job: Uuid, number: u32, page: PageRequest) -> RepositoryFuture<'_, Page<RecordSummary>> {
        self.read(records::list(&self.readers, job, number, page))
    }

    fn latest_record(&self, job: Uuid, number: u32, kind: RecordKind) -> RepositoryFuture<'_, Option<Record>> {
        self.read(records::latest(&self.readers, job, number, kind))
    }

    fn insert_stream(&self, stream: Arc<NewStream>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        self.write_stored(Work::InsertStream { stream, receipt })
    }

    fn stream(&self, id: Uuid) -> RepositoryFuture<'_, Stream> {
        self.read(streams::stream(&self.readers, id))
    }

    fn stream_state(&self, id: Uuid) -> RepositoryFuture<'_, (Stream, Option<StreamState>, Option<[u8; 32]>)> {
        self.read(streams::stream_state(&self.readers, id))
    }

    fn blocks(&self, id: Uuid, after: u64) -> RepositoryFuture<'_, Vec<Block>> {
        self.read(streams::blocks(&self.readers, id, after))
    }

    fn block_sha256(&self, id: Uuid, sequence: u64) -> RepositoryFuture<'_, Option<[u8; 32]>> {
        self.read(streams::block_sha256(&self.readers, id, sequence))
    }

    fn insert_block(&self, block: Arc<NewBlock>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        let nodes = nodes_codec::encode(&block.nodes);
        self.write_stored(Work::InsertBlock(IncomingBlock { block, nodes, receipt }))
    }

    fn finish_stream(&self, finished: FinishedStream, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        let FinishedStream { stream, sequence, iteration } = finished;
        let nodes = nodes_codec::encode(&iteration.nodes);
        let incoming = Incoming { iteration, nodes, receipt };
        self.write_stored(Work::FinishStream(IncomingFinish { stream, sequence, incoming }))
    }

    fn delete_stream(&self, id: Uuid, precondition: Precondition, now: Timestamp) -> RepositoryFuture<'_, ()> {
        let outcome = self.write(Work::DeleteStream { id, precondition, now });
        Box::pin(async move {
            match outcome.await? {
                Outcome::Deleted => Ok(()),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn events(&self, job: Uuid, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<JobEvent>> {
        self.read(streams::events(&self.readers, job, after, limit))
    }

    fn last_event(&self, job: Uuid) -> RepositoryFuture<'_, u64> {
        self.read(streams::last_event(&self.readers, job))
    }

    fn answer(&self, key: String, scope: String) -> RepositoryFuture<'_, Option<([u8; 32], Answer)>> {
        self.read(async move { read::answer(&self.readers, &key, &scope).await })
    }

    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        let outcome = self.write(Work::ForgetAnswers { before, most });
        Box::pin(async move {
            match outcome.await? {
                Outcome::Forgotten(count) => Ok(count),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn insert_runs(&self, runs: Vec<NewRun>, receipt: Option<Receipt>, now: Timestamp) -> RepositoryFuture<'_, Stored> {
        let incoming = |iteration: Arc<NewIteration>| {
            let nodes = nodes_codec::encode(&iteration.nodes);
            Incoming { iteration, nodes, receipt: None }
        };
        let runs = runs
            .into_iter()
            .map(|NewRun { job, iterations }| (job, iterations.into_iter().map(incoming).collect()))
            .collect();
        self.write_stored(Work::InsertRuns { runs, receipt, now })
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        let outcome = self.write(Work::Probe { now });
        Box::pin(async move {
            match outcome.await? {
                Outcome::Done => Ok(()),
                other => Err(unexpected(&other)),
            }
        })
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        self.read(read::ping(&self.readers))
    }
}

fn closed() -> RepositoryError {
    RepositoryError::Unavailable("the store is closed".into())
}

fn unexpected(outcome: &Outcome) -> RepositoryError {
    RepositoryError::Failed(format!("the writer answered something else: {outcome:?}"))
}
