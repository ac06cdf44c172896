//! A store as one caller sees it: reads go to the readers, writes into the queue, each with its
//! caller.

use std::{any::type_name, sync::Arc, time::Instant};

use jiff::{SignedDuration, Timestamp};
use tracing::Instrument as _;
use uuid::Uuid;

use super::{
    access::{Read, Write},
    error::StoreError,
    maintenance::{
        ClaimTask, EndTask, FindCertificate, FindKey, ForgetTasks, GiveTaskBack, HasKeys, NoteUses, RenewTasks,
    },
    operation::{
        Amend, Asked, CancelTask, Choose, Decide, DeleteJob, DeleteStream, FinishStream, GetAllEvents, GetAnswer,
        GetAudit, GetBlockSha256, GetBlocks, GetEvents, GetFit, GetIteration, GetJob, GetJobCounts, GetKey,
        GetLastEvent, GetLastPlace, GetLatestRecord, GetMapping, GetMeasurand, GetNodes, GetNodesUpTo, GetPlant,
        GetPredecessors, GetRecord, GetRounds, GetSeals, GetStream, GetStreamState, GetSuccessors, GetTask,
        GetTaskOfKey, GetTaskResult, GetTrace, InsertBlock, InsertFit, InsertIteration, InsertJob, InsertKey,
        InsertPlant, InsertRecord, InsertRuns, InsertStream, InsertTask, KeepMapping, ListFits, ListIterations,
        ListJobs, ListKeys, ListPlants, ListRecords, ListStreams, ListTasks, Operation as _, PatchJob, PatchKey,
        PatchPlant, PurgeJob, RevokeKey, RotateKey, TellsAllAfter, VerifyAudit,
    },
    queue::{Queue, Run},
    read_turns::{EndsRead, READ_TIME, READING, ReadTurns, Watch},
    subject::Subject,
};
use crate::{
    jobs::{
        Amendment, Answer, ApiKey, Block, Caller, Choice, ClaimedTask, Clock, Credentials, DecisionEvent, EndedTask,
        EventPlace, FinishedStream, FitRecord, FitSummary, Ids, Iteration, Job, JobCounts, JobEvent, JobPage, JobPatch,
        JobQuery, KeptMapping, KeyId, KeyPatch, Keys, KnownKey, Lease, ListedIteration, Measurand, NewBlock, NewFit,
        NewIteration, NewKey, NewPlant, NewPurge, NewRun, NewStream, NewTask, Page, PageRequest, Plant, PlantPatch,
        Precondition, Predecessor, Predecessors, Receipt, Record, RecordKind, RecordSummary, Repository,
        RepositoryError, RepositoryFuture, Rotation, Rounds, San, Stored, Stream, StreamState, Successors, Task,
        TaskQuery, TaskResult, Tasks, Tenant, ToldEvent, Trace,
        audit::{Chain, Entry, Prepared, Seal, Verdict},
    },
    key_operations, repository_operations, telemetry,
};
use flankfit_engine::estimation::Nodes;

/// An open database.
pub trait Backend: Send + Sync + 'static {
    /// What spans call this kind of database (`db.system.name` of OpenTelemetry).
    const SYSTEM: &'static str;
    /// Where reads take a connection from.
    type Readers: Sync;
    /// What writes are done on.
    type Connection: Send + 'static;

    fn readers(&self) -> &Self::Readers;
    /// Where writes wait that change this.
    fn queue(&self, subject: Subject) -> &Queue<Self::Connection>;
    /// Where ids and times of entries come from.
    fn surroundings(&self) -> (&dyn Ids, &dyn Clock);
    /// Returns the scheduler of reads.
    fn turns(&self) -> &ReadTurns;
    /// Hears how long each read took.
    fn read_seconds(&self) -> &metrics::Histogram;
    /// An error of the database as the callers see it.
    fn failure(error: &sqlx::Error) -> RepositoryError;

    /// Whether a read that failed so, and that began then, is tried again.
    fn reads_again(&self, _error: &sqlx::Error, _begun: Instant) -> bool {
        false
    }
}

/// See the module's documentation.
pub struct Handle<B> {
    backend: Arc<B>,
    caller: Caller,
    /// The party whose share its reads use; `None` for the server's own.
    party: Option<Tenant>,
}

impl<B: Backend> Handle<B> {
    /// For what is asked before it is known who asks.
    pub fn of_nobody(backend: Arc<B>) -> Self {
        let caller = Caller { tenant: Tenant::root(), actor: "nobody".into(), origin: Default::default() };
        Handle { backend, caller, party: None }
    }

    pub fn new(backend: Arc<B>, caller: Caller) -> Self {
        let party = Some(caller.tenant.clone());
        Handle { backend, caller, party }
    }

    /// Runs a read in its own task, so that it holds its turn until its connection is free even if
    /// nobody waits for it any more.
    fn read<O: Read<B::Readers>>(&self, operation: O) -> RepositoryFuture<'_, O::Reply> {
        let (backend, caller) = (self.backend.clone(), self.caller.clone());
        let reading = async move {
            let begun = Instant::now();
            let turn = match backend.turns().take(&self.party).await {
                Ok(turn) => turn,
                Err(error) => return told(Err(error)),
            };
            let watch = Watch::lasting(READ_TIME);
            let _ends_when_left = EndsRead(watch.clone());
            let read = async move {
                let _turn = turn;
                let found = loop {
                    match operation.read(&caller, backend.readers()).await {
                        Ok(found) => break Ok(found),
                        Err(StoreError::Refused(error)) => break Err(error),
                        Err(StoreError::Broken(error)) if backend.reads_again(&error, begun) => {}
                        Err(StoreError::Broken(error)) => break Err(B::failure(&error)),
                    }
                };
                backend.read_seconds().record(begun.elapsed());
                found
            };
            match tokio::spawn(READING.scope(watch, read).in_current_span()).await {
                Ok(found) => told(found),
                Err(error) => match error.try_into_panic() {
                    Ok(panic) => std::panic::resume_unwind(panic),
                    Err(error) => told(Err(RepositoryError::Failed(error.to_string()))),
                },
            }
        };
        Box::pin(reading.instrument(telemetry::store_span(B::SYSTEM, type_name::<O>())))
    }

    /// The operation is in the queue before this returns its future: dropping the future changes
    /// nothing.
    fn write<O: Write<B::Connection>>(&self, write: O) -> RepositoryFuture<'_, O::Reply> {
        let subject = write.subject();
        let (ids, clock) = self.backend.surroundings();
        let at = clock.now();
        let prepared = write.contents().into_iter().map(|contents| Prepared { id: ids.fresh(at), contents }).collect();
        self.enqueue(subject, Asked { caller: self.caller.clone(), at, prepared, write })
    }

    /// As [`Self::write`], what is not audited.
    fn enqueue<O: Run<B::Connection>>(&self, subject: Subject, operation: O) -> RepositoryFuture<'_, O::Reply> {
        let span = telemetry::store_span(B::SYSTEM, type_name::<O>());
        let writing = self.backend.queue(subject).write(operation);
        Box::pin(async move { told(writing.await) }.instrument(span))
    }
}

/// Tells the operation's span what the store could not do. What it refuses is an answer.
fn told<T>(outcome: Result<T, RepositoryError>) -> Result<T, RepositoryError> {
    let kind = match &outcome {
        Err(RepositoryError::Overloaded) => "overloaded",
        Err(RepositoryError::Unavailable(_)) => "store_unavailable",
        Err(RepositoryError::OutcomeUnknown(_)) => "outcome_unknown",
        Err(RepositoryError::Failed(_)) => "internal",
        _ => return outcome,
    };
    telemetry::failed(&telemetry::here(), kind);
    outcome
}

/// Makes a repository of every store that knows how to do each operation.
macro_rules! declare {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        impl<B: Backend> $Trait for Handle<B>
        where
            $($Read: Read<B::Readers>,)*
            $($Write: Write<B::Connection>,)*
        {
            $(fn $read(&self, $($of: $what),*) -> RepositoryFuture<'_, $found> {
                self.read($Read { $($of),* })
            })*

            $(fn $write(&self, $($with: $given),*) -> RepositoryFuture<'_, $reply> {
                self.write($Write { $($with),* })
            })*
        }
    };
}

repository_operations!(declare);
key_operations!(declare);

impl<B: Backend> Credentials for Handle<B>
where
    FindKey: Read<B::Readers>,
    FindCertificate: Read<B::Readers>,
    GetPlant: Read<B::Readers>,
    HasKeys: Read<B::Readers>,
    NoteUses: Run<B::Connection>,
{
    fn find_key(&self, id: KeyId) -> RepositoryFuture<'_, Option<KnownKey>> {
        self.read(FindKey { id })
    }

    fn find_certificate(&self, san: San) -> RepositoryFuture<'_, Option<KnownKey>> {
        self.read(FindCertificate { san })
    }

    fn find_tenant(&self, name: Tenant) -> RepositoryFuture<'_, Option<Plant>> {
        let reading = self.read(GetPlant { name });
        Box::pin(async move {
            match reading.await {
                Ok(plant) => Ok(Some(plant)),
                Err(RepositoryError::NotFound(_)) => Ok(None),
                Err(error) => Err(error),
            }
        })
    }

    fn has_keys(&self) -> RepositoryFuture<'_, bool> {
        self.read(HasKeys)
    }

    fn note_uses(&self, uses: Vec<(KeyId, Timestamp)>) -> RepositoryFuture<'_, ()> {
        self.enqueue(Subject::Nothing, NoteUses { uses })
    }
}

impl<B: Backend> Tasks for Handle<B>
where
    ClaimTask: Run<B::Connection>,
    RenewTasks: Run<B::Connection>,
    EndTask: Run<B::Connection>,
    GiveTaskBack: Run<B::Connection>,
    ForgetTasks: Run<B::Connection>,
{
    fn claim(&self, lease: Uuid, now: Timestamp, lasting: SignedDuration) -> RepositoryFuture<'_, Option<ClaimedTask>> {
        self.enqueue(Subject::Nothing, ClaimTask { lease, now, lasting })
    }

    fn renew(
        &self,
        leases: Vec<(Lease, f64)>,
        now: Timestamp,
        lasting: SignedDuration,
    ) -> RepositoryFuture<'_, Vec<Lease>> {
        self.enqueue(Subject::Nothing, RenewTasks { leases, now, lasting })
    }

    fn end(&self, ended: Arc<EndedTask>) -> RepositoryFuture<'_, bool> {
        let write = EndTask { ended };
        self.enqueue(write.subject(), write)
    }

    fn give_back(&self, lease: Lease, until: Timestamp, counts: bool) -> RepositoryFuture<'_, ()> {
        self.enqueue(Subject::Nothing, GiveTaskBack { lease, until, counts })
    }

    fn forget_tasks(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.enqueue(Subject::Nothing, ForgetTasks { before, most })
    }
}
