//! Where jobs are kept. SQLite is one answer; nothing here says so.

use std::{future::Future, pin::Pin, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    event::JobEvent,
    fit::{FitRecord, NewFit},
    idempotency::{Answer, Receipt},
    iteration::{Choice, FitSummary, Iteration, NewIteration, NewRun, Ruling, Trace},
    job::{Job, JobPatch},
    measurand::{Measurand, Successors},
    page::{Page, PageRequest},
    record::{Record, RecordKind, RecordSummary},
    stream::{Block, FinishedStream, NewBlock, NewStream, Stream, StreamState},
};
use flankfit_engine::estimation::Nodes;

/// What a request named and the store did not find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    Job,
    Iteration,
    Fit,
    Stream,
    Record,
}

/// Why the store did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum RepositoryError {
    #[error("not found: {0:?}")]
    NotFound(What),
    /// A job with iterations is not deleted.
    #[error("the job has {0} iteration(s)")]
    HasIterations(u64),
    /// Nor is a job with streams.
    #[error("the job has {0} stream(s)")]
    HasStreams(u64),
    /// What is to be stored is of a tooth that the job's gear has not got.
    #[error("the job's gear has {teeth} teeth, not tooth {tooth}")]
    NoSuchTooth { tooth: String, teeth: u32 },
    /// The job's gear would lose a tooth that was measured: by an iteration, or by an open stream.
    #[error("a gear of {teeth} teeth has no tooth {tooth}")]
    ToothMeasured { tooth: String, teeth: u32, iteration: Option<u32> },
    /// What is to be stored was made by a gear that the job no longer has.
    #[error("the job's gear was changed meanwhile")]
    GearChanged,
    /// A finished stream takes nothing more.
    #[error("the stream has become iteration {iteration}")]
    StreamFinished { iteration: u32 },
    /// A block came before its turn, or after another one took its number.
    #[error("the stream expects block {expected}")]
    UnexpectedBlock { expected: u64 },
    /// The resource has moved on since the caller saw it.
    #[error("the resource is at version {current}")]
    VersionMismatch { current: u64 },
    /// A fit was named that belongs elsewhere or nowhere.
    #[error("fit {0} is not of this iteration")]
    ForeignFit(Uuid),
    /// An answer is already kept under this idempotency key.
    #[error("the idempotency key is taken")]
    KeyTaken,
    /// Too many writes wait; nothing was stored.
    #[error("the store's queue is full")]
    Overloaded,
    /// The store cannot be used now; nothing was stored.
    #[error("the store cannot be used now: {0}")]
    Unavailable(String),
    /// Anything else; nothing was stored.
    #[error("the store failed: {0}")]
    Failed(String),
}

/// What only the store could know of something it stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The number an iteration was given (0 for what has no number).
    pub number: u32,
    /// The version of the job or iteration after the change.
    pub version: u64,
}

/// What the caller says it has seen (`If-Match`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Precondition {
    #[default]
    None,
    /// One of these versions.
    AnyOf(Vec<u64>),
}

impl Precondition {
    /// Refuses a version that the caller has not seen.
    pub fn check(&self, current: u64) -> Result<(), RepositoryError> {
        match self {
            Precondition::AnyOf(seen) if !seen.contains(&current) => Err(RepositoryError::VersionMismatch { current }),
            _ => Ok(()),
        }
    }
}

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
    /// Records the ruling, unless the latest one says the same.
    fn rule(&self, job: Uuid, number: u32, ruling: Ruling, precondition: Precondition) -> RepositoryFuture<'_, Stored>;

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
    /// Adds the block that is expected next, and no other.
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
