//! Interface of the store, independent of the database.
//!
//! A [`Store`] keeps the jobs of every tenant. What a caller may see and change of it is a
//! [`Repository`]: tenant and actor live in that handle, so no operation can forget them.

use std::{future::Future, pin::Pin, sync::Arc};

use flankfit_engine::estimation::Nodes;
use jiff::Timestamp;
use uuid::Uuid;

use super::{
    archive::{Holdings, Key},
    audit::{Auditor, ListedEntry, Seal, Sealed, Sealing},
};
use crate::jobs::*;

/// A store of jobs, of every tenant.
pub trait Store: Upkeep {
    /// The store as a caller sees it: other tenants' jobs, and what belongs to these, do not exist.
    fn of(&self, caller: &Caller) -> Arc<dyn Repository>;

    /// The keys of a caller's tenant, and the tenants.
    fn keys(&self, caller: &Caller) -> Arc<dyn Keys>;

    /// The keys of all tenants, for whoever must find out who asks.
    fn credentials(&self) -> Arc<dyn Credentials>;

    /// The audit of all tenants.
    fn auditor(&self) -> Arc<dyn Auditor>;

    /// The jobs of all tenants as rows, to be read.
    fn holdings(&self) -> Arc<dyn Holdings>;

    /// How the processes that use the store wake each other; `None` where it is one process's
    /// alone.
    fn wakes(&self) -> Option<Arc<dyn Wakes>> {
        None
    }
}

/// How processes that use one store wake each other.
pub trait Wakes: Send + Sync + 'static {
    /// Sends to the others, soon and without waiting.
    fn send(&self, wake: Wake);

    /// Sends messages to the others, and passes theirs to `ring`, until it is dropped.
    fn pass_on<'a>(&'a self, ring: &'a (dyn Fn(Wake) + Send + Sync)) -> Pin<Box<dyn Future<Output = ()> + Send + 'a>>;

    /// The numbers of the last events of jobs, whosever they are; 0 before the first.
    fn last_events(&self, jobs: Vec<Uuid>) -> RepositoryFuture<'_, Vec<(Uuid, u64)>>;
}

/// Upkeep of a store as a whole, for no caller.
pub trait Upkeep: Send + Sync + 'static {
    /// Forgets kept responses from before a time, the oldest first, at most so many; returns how
    /// many.
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64>;

    /// Forgets in which order the events of all jobs were stored before a time, the oldest first,
    /// at most so many; returns how many. Now and then it notes how far they have come at `now`,
    /// by which it is known later.
    fn forget_event_order(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64>;

    /// Links the entries of every tenant that are not sealed, and seals them; `None` if another
    /// process is doing so.
    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Sealed>>;

    /// Jobs without activity since a time that are not purged, after the last one of `after`, at
    /// most so many.
    fn untouched(&self, since: Timestamp, after: Option<Key>, most: u32) -> RepositoryFuture<'_, Vec<Key>>;

    /// Checks whether anything can be written: writes something small, and waits for the sync.
    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()>;

    /// Checks whether the store responds.
    fn ping(&self) -> RepositoryFuture<'_, ()>;

    /// Finishes the writes that wait and closes the store. Later writes are refused.
    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>>;
}

/// Every operation of a [`Repository`], said once. The macro `$then` is given its reads and its
/// writes, each with a name for it as data, the name of its method, what it takes and what it
/// returns. (Names are looked up where `$then` uses them.)
#[doc(hidden)]
#[macro_export]
macro_rules! repository_operations {
    ($then:ident) => {
        $then! {
            Repository
            reads {
                GetJob = job(id: Uuid) -> Job;
                ListJobs = jobs(query: JobQuery) -> JobPage;
                /// Counted by day from that time on.
                GetJobCounts = job_counts(from: Timestamp) -> JobCounts;

                /// By number, each with its chosen fit.
                ListIterations = iterations(job: Uuid, page: PageRequest) -> Page<ListedIteration>;
                GetIteration = iteration(job: Uuid, number: u32) -> Iteration;
                GetNodes = nodes(job: Uuid, number: u32) -> Nodes;
                /// The nodes if they take at most so many bytes in the store, else how many they
                /// take.
                GetNodesUpTo = nodes_up_to(job: Uuid, number: u32, most: usize) -> Result<Nodes, usize>;
                /// Measurand of the nodes of an iteration.
                GetMeasurand = measurand(job: Uuid, number: u32) -> Measurand;
                /// Iterations that were measured after one.
                GetSuccessors = successors(job: Uuid, number: u32) -> Successors;
                /// Earlier iterations of the same flank and tooth, oldest first.
                GetPredecessors = predecessors(job: Uuid, wanted: Predecessors) -> Vec<Predecessor>;
                /// Iterations and corrections of a job, without what they hold.
                GetRounds = rounds(job: Uuid) -> Rounds;
                /// Iterations by number; a page may hold fewer than its limit where they are big.
                GetTrace = trace(job: Uuid, page: PageRequest) -> Trace;

                GetFit = fit(job: Uuid, number: u32, fit: Uuid) -> FitRecord;
                /// Fits of an iteration in the order in which they were made.
                ListFits = fits(job: Uuid, number: u32, page: PageRequest) -> Page<FitSummary>;

                GetRecord = record(job: Uuid, number: u32, id: Uuid) -> Record;
                /// Oldest first.
                ListRecords = records(job: Uuid, number: u32, page: PageRequest) -> Page<RecordSummary>;
                /// The one of a kind that was kept last.
                GetLatestRecord = latest_record(job: Uuid, number: u32, kind: RecordKind) -> Option<Record>;

                /// Streams of a job, oldest first.
                ListStreams = streams(job: Uuid, page: PageRequest) -> Page<Stream>;
                GetStream = stream(id: Uuid) -> Stream;
                /// The stream, its estimate as it was written down last, and the digest of its last
                /// block, in one state.
                GetStreamState = stream_state(id: Uuid) -> (Stream, Option<StreamState>, Option<[u8; 32]>);
                /// Blocks after the one numbered `after`, in order: at least one where there is
                /// one, and no more than a few megabytes.
                GetBlocks = blocks(id: Uuid, after: u64) -> Vec<Block>;
                /// Digest of one block.
                GetBlockSha256 = block_sha256(id: Uuid, sequence: u64) -> Option<[u8; 32]>;

                /// Events of a job after the event numbered `after`, at most `limit` events.
                GetEvents = events(job: Uuid, after: u64, limit: u32) -> Vec<JobEvent>;
                /// The number of a job's last event, 0 before the first.
                GetLastEvent = last_event(job: Uuid) -> u64;
                /// Events of all jobs after a place, at most `limit` events.
                GetAllEvents = all_events(after: EventPlace, limit: u32) -> Vec<ToldEvent>;
                /// A place behind all that has happened, and before all that will.
                GetLastPlace = last_place() -> EventPlace;
                /// Whether nothing that happened after a place was forgotten.
                HasAllAfter = has_all_after(place: EventPlace) -> bool;

                /// Entries of a job, or of the tenant, in the order of their ids.
                GetAudit = audit(job: Option<Uuid>, page: PageRequest) -> Page<ListedEntry>;
                /// Seals of the tenant, oldest first.
                GetSeals = seals(page: PageRequest) -> Page<Seal>;

                /// The answer kept under an idempotency key, with the digest of its request.
                GetAnswer = answer(key: String, scope: String) -> Option<([u8; 32], Answer)>;

                /// The mapping of a table that was kept last under a key.
                GetMapping = mapping(key: [u8; 32]) -> Option<String>;
            }
            writes {
                InsertJob = insert_job(job: Job, receipt: Option<Receipt>) -> Stored;
                PatchJob = patch_job(id: Uuid, patch: JobPatch, precondition: Precondition, now: Timestamp) -> Job;
                DeleteJob = delete_job(id: Uuid, precondition: Precondition) -> ();
                /// Removes nodes, results, texts and names of a job.
                PurgeJob = purge_job(purge: Arc<Purge>, receipt: Option<Receipt>) -> Stored;
                /// Stores jobs with their iterations and keeps the receipt, all or nothing.
                InsertRuns = insert_runs(runs: Vec<NewRun>, receipt: Option<Receipt>, now: Timestamp) -> Stored;

                /// Stores do many of these at once.
                InsertIteration =
                    insert_iteration(iteration: Arc<NewIteration>, receipt: Option<Receipt>) -> Stored;
                InsertFit =
                    insert_fit(job: Uuid, number: u32, fit: Arc<NewFit>, receipt: Option<Receipt>) -> Stored;
                /// Records the choice, unless the latest one says the same.
                Choose = choose(job: Uuid, number: u32, choice: Choice, precondition: Precondition) -> Stored;
                /// Records the decision, unless the latest one says the same.
                Decide = decide(job: Uuid, number: u32, decision: DecisionEvent, precondition: Precondition) -> Stored;
                /// Stores a new measurand of the nodes, with a repeated fit that becomes the chosen
                /// one and a decision, if there are any.
                Amend = amend(
                    job: Uuid,
                    number: u32,
                    amendment: Arc<Amendment>,
                    precondition: Precondition
                ) -> Stored;
                InsertRecord =
                    insert_record(job: Uuid, number: u32, record: Arc<Record>, receipt: Option<Receipt>) -> Stored;

                InsertStream = insert_stream(stream: Arc<NewStream>, receipt: Option<Receipt>) -> Stored;
                /// Adds the block that is expected next, behind the blocks whose chain it names,
                /// and no other.
                InsertBlock = insert_block(block: Arc<NewBlock>, receipt: Option<Receipt>) -> Stored;
                /// Makes the stream an iteration, if its last block is the one named.
                FinishStream = finish_stream(finished: FinishedStream, receipt: Option<Receipt>) -> Stored;
                /// Deletes the stream with its blocks. An iteration that it has become stays.
                DeleteStream = delete_stream(id: Uuid, precondition: Precondition, now: Timestamp) -> ();

                /// Keeps the mapping of a table in place of the one under its key. Of more than
                /// [`MOST_MAPPINGS`](super::mapping::MOST_MAPPINGS) of the tenant the oldest are
                /// forgotten.
                KeepMapping = keep_mapping(kept: KeptMapping, now: Timestamp) -> ();
            }
        }
    };
}

/// Makes the trait of the operations, and its reads methods of `$Owner` too.
macro_rules! operations {
    (
        $Owner:ident.$field:ident: $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        /// A store as one caller sees it. Every write is all or nothing, and is durable when its
        /// future is ready; a write that was begun is finished even if its future is dropped. Reads
        /// see one consistent state each.
        pub trait $Trait: Send + Sync + 'static {
            $($(#[$about])* fn $read(&self, $($of: $what),*) -> RepositoryFuture<'static, $found>;)*
            $($(#[$on])* fn $write(&self, $($with: $given),*) -> RepositoryFuture<'static, $reply>;)*
        }

        impl $Owner {
            $($(#[$about])* pub fn $read(&self, $($of: $what),*) -> RepositoryFuture<'static, $found> {
                self.$field.$read($($of),*)
            })*
        }
    };
}
pub(super) use operations;

macro_rules! declare {
    ($($all:tt)*) => { operations! { Jobs.repository: $($all)* } };
}

crate::repository_operations!(declare);
