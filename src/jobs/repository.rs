//! Where jobs are kept. SQLite is one answer; nothing here says so.

use std::{future::Future, pin::Pin, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    event::JobEvent,
    fit::{FitRecord, NewFit},
    idempotency::{Answer, Receipt},
    iteration::{Choice, DecisionEvent, FitSummary, Iteration, NewIteration, NewRun, Trace},
    job::{Job, JobPatch},
    measurand::{Measurand, Successors},
    outcome::{Precondition, RepositoryError, Stored},
    page::{Page, PageRequest},
    prior::{Predecessor, Predecessors},
    record::{Record, RecordKind, RecordSummary},
    streams::{Block, FinishedStream, NewBlock, NewStream, Stream, StreamState},
};
use flankfit_engine::estimation::Nodes;

/// What the store's methods answer with.
pub type RepositoryFuture<'a, T> = Pin<Box<dyn Future<Output = Result<T, RepositoryError>> + Send + 'a>>;

/// The store. Every write is all or nothing, and is durable when its future is ready; a write that
/// was begun is finished even if its future is dropped. Reads see one consistent state each.
pub trait Repository: Send + Sync + 'static {
    fn insert_job(&self, job: Job, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored>;
    fn job(&self, id: Uuid) -> RepositoryFuture<'_, Job>;
    /// Newest first.
    fn jobs(&self, page: PageRequest) -> RepositoryFuture<'_, Page<Job>>;
    fn patch_job(
        &self,
        id: Uuid,
        patch: JobPatch,
        precondition: Precondition,
        now: Timestamp,
    ) -> RepositoryFuture<'_, Job>;
    fn delete_job(&self, id: Uuid, precondition: Precondition) -> RepositoryFuture<'_, ()>;

    fn insert_iteration(&self, iteration: Arc<NewIteration>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored>;
    fn iteration(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Iteration>;
    fn nodes(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Nodes>;
    /// What the nodes of an iteration are of.
    fn measurand(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Measurand>;
    /// What was measured after an iteration.
    fn successors(&self, job: Uuid, number: u32) -> RepositoryFuture<'_, Successors>;
    /// Earlier iterations of the same flank and tooth, oldest first.
    fn predecessors(&self, job: Uuid, wanted: Predecessors) -> RepositoryFuture<'_, Vec<Predecessor>>;
    /// Iterations by number; a page may hold fewer than its limit where they are big.
    fn trace(&self, job: Uuid, page: PageRequest) -> RepositoryFuture<'_, Trace>;
    /// The nodes if they take at most so many bytes in the store, else how many they take.
    fn nodes_up_to(&self, job: Uuid, number: u32, most: usize) -> RepositoryFuture<'_, Result<Nodes, usize>>;

    fn insert_fit(
        &self,
        job: Uuid,
        number: u32,
        fit: Arc<NewFit>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored>;
    fn fit(&self, job: Uuid, number: u32, fit: Uuid) -> RepositoryFuture<'_, FitRecord>;
    /// Fits of an iteration in the order in which they were made.
    fn fits(&self, job: Uuid, number: u32, page: PageRequest) -> RepositoryFuture<'_, Page<FitSummary>>;
    /// Records the choice, unless the latest one says the same.
    fn choose(
        &self,
        job: Uuid,
        number: u32,
        choice: Choice,
        precondition: Precondition,
    ) -> RepositoryFuture<'_, Stored>;
    /// Records the decision, unless the latest one says the same.
    fn decide(
        &self,
        job: Uuid,
        number: u32,
        decision: DecisionEvent,
        precondition: Precondition,
    ) -> RepositoryFuture<'_, Stored>;

    fn insert_record(
        &self,
        job: Uuid,
        number: u32,
        record: Arc<Record>,
        receipt: Option<Receipt>,
    ) -> RepositoryFuture<'_, Stored>;
    fn record(&self, job: Uuid, number: u32, id: Uuid) -> RepositoryFuture<'_, Record>;
    /// Oldest first.
    fn records(&self, job: Uuid, number: u32, page: PageRequest) -> RepositoryFuture<'_, Page<RecordSummary>>;

    /// The one of a kind that was kept last.
    fn latest_record(&self, job: Uuid, number: u32, kind: RecordKind) -> RepositoryFuture<'_, Option<Record>>;

    fn insert_stream(&self, stream: Arc<NewStream>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored>;
    fn stream(&self, id: Uuid) -> RepositoryFuture<'_, Stream>;
    /// The stream, its estimate as it was written down last, and the digest of its last block, in
    /// one state.
    fn stream_state(&self, id: Uuid) -> RepositoryFuture<'_, (Stream, Option<StreamState>, Option<[u8; 32]>)>;
    /// Blocks after the one numbered `after`, in order: at least one where there is one, and no
    /// more than a few megabytes.
    fn blocks(&self, id: Uuid, after: u64) -> RepositoryFuture<'_, Vec<Block>>;
    /// Digest of one block.
    fn block_sha256(&self, id: Uuid, sequence: u64) -> RepositoryFuture<'_, Option<[u8; 32]>>;
    /// Adds the block that is expected next, behind the blocks whose chain it names, and no other.
    fn insert_block(&self, block: Arc<NewBlock>, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored>;
    /// Makes the stream an iteration, if its last block is the one named.
    fn finish_stream(&self, finished: FinishedStream, receipt: Option<Receipt>) -> RepositoryFuture<'_, Stored>;
    /// Deletes the stream with its blocks. An iteration that it has become stays.
    fn delete_stream(&self, id: Uuid, precondition: Precondition, now: Timestamp) -> RepositoryFuture<'_, ()>;

    /// What happened to a job after the event numbered `after`, at most `limit` events.
    fn events(&self, job: Uuid, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<JobEvent>>;
    /// The number of a job's last event, 0 before the first.
    fn last_event(&self, job: Uuid) -> RepositoryFuture<'_, u64>;

    /// The answer kept under an idempotency key, with the digest of its request.
    fn answer(&self, key: String, scope: String) -> RepositoryFuture<'_, Option<([u8; 32], Answer)>>;

    /// Forgets kept answers from before a time, the oldest first, at most so many; answers how
    /// many.
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64>;

    /// Stores jobs with their iterations and keeps the receipt, all or nothing.
    fn insert_runs(&self, runs: Vec<NewRun>, receipt: Option<Receipt>, now: Timestamp) -> RepositoryFuture<'_, Stored>;

    /// Whether anything can be written: writes something small, and answers once it is synced.
    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()>;

    /// Whether the store answers at all.
    fn ping(&self) -> RepositoryFuture<'_, ()>;
}
