//! The store as the jobs see it: writes go to the writer, reads to the pool.

use std::{sync::Arc, time::Instant};

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{
    answers, blocks,
    error::{OpenError, failure},
    events, fits, iterations, jobs, lock,
    open::StoreSettings,
    records, streams, trace, upkeep,
    writer::Writer,
};
use crate::{
    jobs::{
        ANSWERS_KEPT, Answer, Block, Choice, DecisionEvent, FinishedStream, FitRecord, FitSummary, Iteration, Job,
        JobEvent, JobPatch, Measurand, NewBlock, NewFit, NewIteration, NewRun, NewStream, Page, PageRequest,
        Precondition, Predecessor, Predecessors, Receipt, Record, RecordKind, RecordSummary, Repository,
        RepositoryFuture, Stored, Stream, StreamState, Successors, Trace,
    },
    store::shared::{
        Choose, Decide, DeleteJob, DeleteStream, FinishStream, ForgetAnswers, InsertBlock, InsertFit, InsertIteration,
        InsertJob, InsertRecord, InsertRuns, InsertStream, Outcome, PatchJob, Probe, Queue, Run, StoreError, queue,
    },
    telemetry,
};
use flankfit_engine::estimation::Nodes;

/// An open database.
pub struct Store {
    readers: SqlitePool,
    queue: Queue<SqliteConnection>,
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
        let old = ForgetAnswers { before: now - ANSWERS_KEPT, most: u32::MAX };
        old.run(&mut connection).await.map_err(|error| OpenError::from_store(path, error))?;
        let readers = settings.open_readers().await?;
        let seconds = |operation| metrics::histogram!(telemetry::STORE_SECONDS, "operation" => operation);
        let (queue, waiting) = queue(settings.queue, seconds("write"));
        tokio::spawn(Writer::new(settings, connection, lock, waiting).run());
        Ok(Store { readers, queue, read_seconds: seconds("read") })
    }

    /// Finishes the writes that wait and closes the database. Later writes are refused.
    pub async fn close(&self) {
        self.readers.close().await;
        self.queue.close().await;
    }

    /// The operation is in the writer's hands before this returns its future: dropping the future
    /// changes nothing.
    fn write<O: Run<SqliteConnection>>(&self, operation: O) -> RepositoryFuture<'_, O::Reply> {
        Box::pin(self.queue.write(operation))
    }

    fn read<'a, T: 'a>(&'a self, read: impl Future<Output = Outcome<T>> + Send + 'a) -> RepositoryFuture<'a, T> {
        Box::pin(async move {
            let begun = Instant::now();
            let result = read.await.map_err(|error| match error {
                StoreError::Refused(error) => error,
                StoreError::Broken(error) => failure(&error),
            });
            self.read_seconds.record(begun.elapsed());
            result
        })
    }
}

impl Repository for Store {
    fn insert_job(&self, job: Job, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        self.write(InsertJob { job, receipt })
    }

    fn job(&self, id: Uuid) -> RepositoryFuture<'_, Job> {
        self.read(jobs::job(&self.readers, id))
    }

    fn jobs(&self, page: PageRequest) -> RepositoryFuture<'_, Page<Job>> {
        self.read(jobs::jobs(&self.readers, page))
    }

    fn patch_job(
        &self,
        id: Uuid,
        patch: JobPatch,
        precondition: Precondition,
        now: Timestamp,
    ) -> RepositoryFuture<'_, Job> {
        self.write(PatchJob { id, patch, precondition, now })
    }

    fn delete_job(&self, id: Uuid, precondition: Precondition) -> RepositoryFuture<'_, ()> {
        self.write(DeleteJob { id, precondition })
    }

    fn insert_iteration(&self, iteration: Arc<NewIteration>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        Box::pin(self.queue.write_iteration(InsertIteration::new(iteration, receipt)))
    }

    fn iteration(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Iteration> {
        self.read(iterations::iteration(&self.readers, job, number))
    }

    fn nodes(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Nodes> {
        self.read(iterations::nodes(&self.readers, job, number))
    }

    fn nodes_up_to(&self, job: Uuid, number: u32, most: usize) -> RepositoryFuture<'_, Result<Nodes, usize>> {
        self.read(iterations::nodes_up_to(&self.readers, job, number, most))
    }

    fn measurand(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Measurand> {
        self.read(iterations::measurand(&self.readers, job, number))
    }

    fn successors(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Successors> {
        self.read(iterations::successors(&self.readers, job, number))
    }

    fn predecessors(&self, job: Uuid, wanted: Predecessors) -> RepositoryFuture<'_, Vec<Predecessor>> {
        self.read(iterations::predecessors(&self.readers, job, wanted))
    }

    fn trace(&self, job: Uuid, page: PageRequest) -> RepositoryFuture<'_, Trace> {
        self.read(trace::trace(&self.readers, job, page))
    }

    fn fits(&self, job: Uuid, number: u32, page: PageRequest) -> RepositoryFuture<'_, Page<FitSummary>> {
        self.read(fits::fits(&self.readers, job, number, page))
    }

    fn insert_fit(
        &self,
        job: Uuid,
        number: u32,
        fit: Arc<NewFit>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored> {
        self.write(InsertFit { job, number, fit, receipt })
    }

    fn fit(&self, job: Uuid, number: u32, fit: Uuid) -> RepositoryFuture<'_, FitRecord> {
        self.read(fits::fit(&self.readers, job, number, fit))
    }

    fn choose(
        &self,
        job: Uuid,
        number: u32,
        choice: Choice,
        precondition: Precondition,
    ) -> RepositoryFuture<'_, Stored> {
        self.write(Choose { job, number, choice, precondition })
    }

    fn decide(
        &self,
        job: Uuid,
        number: u32,
        decision: DecisionEvent,
        precondition: Precondition,
    ) -> RepositoryFuture<'_, Stored> {
        self.write(Decide { job, number, decision, precondition })
    }

    fn insert_record(
        &self,
        job: Uuid,
        number: u32,
        record: Arc<Record>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored> {
        self.write(InsertRecord { job, number, record, receipt })
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
        self.write(InsertStream { stream, receipt })
    }

    fn stream(&self, id: Uuid) -> RepositoryFuture<'_, Stream> {
        self.read(streams::stream(&self.readers, id))
    }

    fn stream_state(&self, id: Uuid) -> RepositoryFuture<'_, (Stream, Option<StreamState>, Option<[u8; 32]>)> {
        self.read(blocks::stream_state(&self.readers, id))
    }

    fn blocks(&self, id: Uuid, after: u64) -> RepositoryFuture<'_, Vec<Block>> {
        self.read(blocks::blocks(&self.readers, id, after))
    }

    fn block_sha256(&self, id: Uuid, sequence: u64) -> RepositoryFuture<'_, Option<[u8; 32]>> {
        self.read(blocks::block_sha256(&self.readers, id, sequence))
    }

    fn insert_block(&self, block: Arc<NewBlock>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        self.write(InsertBlock::new(block, receipt))
    }

    fn finish_stream(&self, finished: FinishedStream, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored> {
        self.write(FinishStream::new(finished, receipt))
    }

    fn delete_stream(&self, id: Uuid, precondition: Precondition, now: Timestamp) -> RepositoryFuture<'_, ()> {
        self.write(DeleteStream { id, precondition, now })
    }

    fn events(&self, job: Uuid, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<JobEvent>> {
        self.read(events::events(&self.readers, job, after, limit))
    }

    fn last_event(&self, job: Uuid) -> RepositoryFuture<'_, u64> {
        self.read(events::last_event(&self.readers, job))
    }

    fn answer(&self, key: String, scope: String) -> RepositoryFuture<'_, Option<([u8; 32], Answer)>> {
        self.read(async move { answers::answer(&self.readers, &key, &scope).await })
    }

    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.write(ForgetAnswers { before, most })
    }

    fn insert_runs(&self, runs: Vec<NewRun>, receipt: Option<Receipt>, now: Timestamp) -> RepositoryFuture<'_, Stored> {
        self.write(InsertRuns::new(runs, receipt, now))
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        self.write(Probe { now })
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        self.read(upkeep::ping(&self.readers))
    }
}
