//! Which operations and which refusals the suite has met: one that it never meets is not held to
//! anything.

use std::{
    collections::BTreeSet,
    pin::Pin,
    sync::{Arc, Mutex, atomic::AtomicUsize},
};

use flankfit::{
    jobs::{
        Answer, Block, Caller, Choice, DecisionEvent, FinishedStream, FitRecord, FitSummary, Iteration, Job, JobEvent,
        JobPatch, Measurand, NewBlock, NewFit, NewIteration, NewRun, NewStream, Page, PageRequest, Precondition,
        Predecessor, Predecessors, Receipt, Record, RecordKind, RecordSummary, Repository, RepositoryError,
        RepositoryFuture, Resource, Store, Stored, Stream, StreamState, Successors, Trace, Upkeep, Wakes,
        audit::{Chain, Entry, Verdict},
    },
    repository_operations,
};
use flankfit_engine::estimation::Nodes;
use jiff::Timestamp;
use uuid::Uuid;

/// What was met.
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
        let operations = OPERATIONS.iter().chain(&UPKEEP).filter(|name| !operations.contains(*name));
        operations.chain(ERRORS.iter().filter(|name| !errors.contains(*name))).copied().collect()
    }
}

/// Every refusal.
const ERRORS: [&str; 18] = [
    "no job",
    "no iteration",
    "no fit",
    "no stream",
    "no record",
    "iterations",
    "streams",
    "no such tooth",
    "tooth measured",
    "gear changed",
    "stream finished",
    "unexpected block",
    "version",
    "foreign fit",
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
        RepositoryError::HasIterations(_) => "iterations",
        RepositoryError::HasStreams(_) => "streams",
        RepositoryError::NoSuchTooth { .. } => "no such tooth",
        RepositoryError::ToothMeasured { .. } => "tooth measured",
        RepositoryError::GearChanged => "gear changed",
        RepositoryError::StreamFinished { .. } => "stream finished",
        RepositoryError::UnexpectedBlock { .. } => "unexpected block",
        RepositoryError::VersionMismatch { .. } => "version",
        RepositoryError::ForeignFit(_) => "foreign fit",
        RepositoryError::KeyTaken => "key taken",
        RepositoryError::Unavailable(_) => "unavailable",
        RepositoryError::Overloaded => "overloaded",
        RepositoryError::Failed(_) => "failed",
        // no store says so unless its server is killed, which is tested elsewhere
        RepositoryError::OutcomeUnknown(_) => "outcome unknown",
    }
}

/// What is done for no caller.
const UPKEEP: [&str; 4] = ["forget_answers", "check_writable", "ping", "close"];

/// A handle of which it is noted what is done for no caller.
pub struct Watched {
    pub store: Arc<dyn Store>,
    pub exercised: Arc<Exercised>,
}

impl Store for Watched {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        self.store.of(caller)
    }

    fn wakes(&self) -> Option<Arc<dyn Wakes>> {
        self.store.wakes()
    }
}

impl Upkeep for Watched {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.exercised.operation("forget_answers");
        self.store.forget_answers(before, most)
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

/// A repository of which each call goes to the other of two handles.
pub struct Turns {
    pub handles: [Arc<dyn Repository>; 2],
    pub next: AtomicUsize,
    pub exercised: Arc<Exercised>,
}

macro_rules! take_turns {
    (
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        /// The name of every operation.
        const OPERATIONS: &[&str] = &[$(stringify!($read),)* $(stringify!($write),)*];

        impl Repository for Turns {
            $(fn $read(&self, $($of: $what),*) -> RepositoryFuture<'_, $found> {
                self.ask(stringify!($read), |handle| handle.$read($($of),*))
            })*
            $(fn $write(&self, $($with: $given),*) -> RepositoryFuture<'_, $reply> {
                self.ask(stringify!($write), |handle| handle.$write($($with),*))
            })*
        }
    };
}

repository_operations!(take_turns);
