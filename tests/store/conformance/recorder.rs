//! Operations and refusals that the suite has exercised: it tests nothing of those that it never
//! meets.

use std::{
    collections::BTreeSet,
    pin::Pin,
    sync::{Arc, Mutex, atomic::AtomicUsize},
};

use flankfit::{
    jobs::{
        Amendment, Answer, ApiKey, Block, Caller, Choice, Credentials, DecisionEvent, EventPlace, FinishedStream,
        FitRecord, FitSummary, Iteration, Job, JobCounts, JobEvent, JobPage, JobPatch, JobQuery, KeptMapping, KeyId,
        KeyPatch, Keys, KnownKey, ListedIteration, Measurand, NewBlock, NewFit, NewIteration, NewKey, NewPlant, NewRun,
        NewStream, Page, PageRequest, Plant, PlantPatch, Precondition, Predecessor, Predecessors, Purge, Receipt,
        Record, RecordKind, RecordSummary, Repository, RepositoryError, RepositoryFuture, Resource, Rotation, Rounds,
        San, Store, Stored, Stream, StreamState, Successors, Tenant, ToldEvent, Trace, Upkeep, Wakes,
        archive::{Holdings, Key},
        audit::{Auditor, ListedEntry, Seal, Sealed, Sealing},
    },
    key_operations, repository_operations,
};
use flankfit_engine::estimation::Nodes;
use jiff::Timestamp;
use uuid::Uuid;

/// Operations and outcomes that were exercised.
#[derive(Default)]
pub struct Exercised {
    operations: Mutex<BTreeSet<&'static str>>,
    errors: Mutex<BTreeSet<&'static str>>,
}

impl Exercised {
    pub fn operation(&self, name: &'static str) {
        self.operations.lock().unwrap().insert(name);
    }

    pub fn error(&self, error: &RepositoryError) {
        self.errors.lock().unwrap().insert(name_of(error));
    }

    /// The operations and the refusals that there are and that were not met.
    pub fn missed(&self) -> Vec<&'static str> {
        let (operations, errors) = (self.operations.lock().unwrap(), self.errors.lock().unwrap());
        let names = <dyn Repository as Named>::NAMES.iter().chain(<dyn Keys as Named>::NAMES);
        let operations = names.chain(&UPKEEP).filter(|name| !operations.contains(*name));
        operations.chain(ERRORS.iter().filter(|name| !errors.contains(*name))).copied().collect()
    }
}

/// Every refusal.
const ERRORS: [&str; 27] = [
    "no job",
    "no iteration",
    "no fit",
    "no stream",
    "no record",
    "no key",
    "no tenant",
    "key revoked",
    "key ended",
    "key replaced",
    "no secret",
    "name taken",
    "tenant exists",
    "iterations",
    "streams",
    "no such tooth",
    "tooth measured",
    "gear changed",
    "stream finished",
    "unexpected block",
    "version",
    "foreign fit",
    "purged",
    "key taken",
    "overloaded",
    "unavailable",
    "failed",
];

fn name_of(error: &RepositoryError) -> &'static str {
    match error {
        RepositoryError::NotFound(Resource::Job) => "no job",
        RepositoryError::NotFound(Resource::Iteration) => "no iteration",
        RepositoryError::NotFound(Resource::Fit) => "no fit",
        RepositoryError::NotFound(Resource::Stream) => "no stream",
        RepositoryError::NotFound(Resource::Record) => "no record",
        RepositoryError::NotFound(Resource::Key) => "no key",
        RepositoryError::NotFound(Resource::Tenant) => "no tenant",
        RepositoryError::KeyRevoked => "key revoked",
        RepositoryError::KeyEnded { .. } => "key ended",
        RepositoryError::KeyReplaced { .. } => "key replaced",
        RepositoryError::NoSecret => "no secret",
        RepositoryError::SanTaken => "name taken",
        RepositoryError::TenantExists => "tenant exists",
        RepositoryError::HasIterations(_) => "iterations",
        RepositoryError::HasStreams(_) => "streams",
        RepositoryError::NoSuchTooth { .. } => "no such tooth",
        RepositoryError::ToothMeasured { .. } => "tooth measured",
        RepositoryError::GearChanged => "gear changed",
        RepositoryError::StreamFinished { .. } => "stream finished",
        RepositoryError::UnexpectedBlock { .. } => "unexpected block",
        RepositoryError::VersionMismatch { .. } => "version",
        RepositoryError::ForeignFit(_) => "foreign fit",
        RepositoryError::Purged { .. } => "purged",
        RepositoryError::KeyTaken => "key taken",
        RepositoryError::Unavailable(_) => "unavailable",
        RepositoryError::Overloaded => "overloaded",
        RepositoryError::Failed(_) => "failed",
        // no store says so unless its server is killed, which is tested elsewhere
        RepositoryError::OutcomeUnknown(_) => "outcome unknown",
        // nor unless its database is another one than that of the tests
        RepositoryError::Unfit(_) => "unfit",
    }
}

/// Operations that are done for no caller.
const UPKEEP: [&str; 12] = [
    "untouched",
    "seal_audit",
    "forget_answers",
    "forget_event_order",
    "check_writable",
    "ping",
    "close",
    "find_key",
    "find_tenant",
    "find_certificate",
    "has_keys",
    "note_uses",
];

/// A handle of which it is noted what is done for no caller.
pub struct Watched {
    pub store: Arc<dyn Store>,
    pub exercised: Arc<Exercised>,
}

impl Store for Watched {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        self.store.of(caller)
    }

    fn keys(&self, caller: &Caller) -> Arc<dyn Keys> {
        self.store.keys(caller)
    }

    fn credentials(&self) -> Arc<dyn Credentials> {
        Arc::new(WatchedCredentials { credentials: self.store.credentials(), exercised: self.exercised.clone() })
    }

    fn auditor(&self) -> Arc<dyn Auditor> {
        self.store.auditor()
    }

    fn wakes(&self) -> Option<Arc<dyn Wakes>> {
        self.store.wakes()
    }

    fn holdings(&self) -> Arc<dyn Holdings> {
        self.store.holdings()
    }
}

impl Upkeep for Watched {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.exercised.operation("forget_answers");
        self.store.forget_answers(before, most)
    }

    fn forget_event_order(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.exercised.operation("forget_event_order");
        self.store.forget_event_order(now, before, most)
    }

    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Sealed>> {
        self.exercised.operation("seal_audit");
        self.store.seal_audit(sealing)
    }

    fn untouched(&self, since: Timestamp, after: Option<Key>, most: u32) -> RepositoryFuture<'_, Vec<Key>> {
        self.exercised.operation("untouched");
        self.store.untouched(since, after, most)
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        self.exercised.operation("check_writable");
        self.store.check_writable(now)
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        self.exercised.operation("ping");
        self.store.ping()
    }

    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>> {
        self.exercised.operation("close");
        self.store.close()
    }
}

/// The names of a trait's operations, and of those of them that write.
trait Named {
    const NAMES: &'static [&'static str];
    const WRITES: &'static [&'static str];
}

/// The names of all that callers write.
pub fn writes() -> BTreeSet<&'static str> {
    <dyn Repository as Named>::WRITES.iter().chain(<dyn Keys as Named>::WRITES).copied().collect()
}

/// A trait's operations of which each call goes to the other of two handles.
pub struct Turns<T: ?Sized> {
    pub handles: [Arc<T>; 2],
    pub next: AtomicUsize,
    pub exercised: Arc<Exercised>,
}

macro_rules! take_turns {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        impl Named for dyn $Trait {
            const NAMES: &'static [&'static str] = &[$(stringify!($read),)* $(stringify!($write),)*];
            const WRITES: &'static [&'static str] = &[$(stringify!($write),)*];
        }

        impl $Trait for Turns<dyn $Trait> {
            $(fn $read(&self, $($of: $what),*) -> RepositoryFuture<'static, $found> {
                self.ask(stringify!($read), |handle| handle.$read($($of),*))
            })*
            $(fn $write(&self, $($with: $given),*) -> RepositoryFuture<'static, $reply> {
                self.ask(stringify!($write), |handle| handle.$write($($with),*))
            })*
        }
    };
}

repository_operations!(take_turns);
key_operations!(take_turns);

/// Credentials whose operations are recorded: those before the caller is known.
struct WatchedCredentials {
    credentials: Arc<dyn Credentials>,
    exercised: Arc<Exercised>,
}

impl Credentials for WatchedCredentials {
    fn find_key(&self, id: KeyId) -> RepositoryFuture<'_, Option<KnownKey>> {
        self.exercised.operation("find_key");
        self.credentials.find_key(id)
    }

    fn find_certificate(&self, san: San) -> RepositoryFuture<'_, Option<KnownKey>> {
        self.exercised.operation("find_certificate");
        self.credentials.find_certificate(san)
    }

    fn find_tenant(&self, name: Tenant) -> RepositoryFuture<'_, Option<Plant>> {
        self.exercised.operation("find_tenant");
        self.credentials.find_tenant(name)
    }

    fn has_keys(&self) -> RepositoryFuture<'_, bool> {
        self.exercised.operation("has_keys");
        self.credentials.has_keys()
    }

    fn note_uses(&self, uses: Vec<(KeyId, Timestamp)>) -> RepositoryFuture<'_, ()> {
        self.exercised.operation("note_uses");
        self.credentials.note_uses(uses)
    }
}
