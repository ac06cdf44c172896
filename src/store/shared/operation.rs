//! Reads and writes of callers as data; each database has its own SQL.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    subject::{About, Subject},
    weight::Weight,
};
use crate::{
    jobs::{
        Amendment, Answer, ApiKey, Block, Caller, Choice, DecisionEvent, EventPlace, FinishedStream, FitRecord,
        FitSummary, Iteration, Job, JobCounts, JobEvent, JobPage, JobPatch, JobQuery, KeptMapping, KeyId, KeyPatch,
        Lease, ListedIteration, Measurand, NewBlock, NewFit, NewIteration, NewKey, NewPlant, NewPurge, NewRun,
        NewStream, NewTask, Page, PageRequest, Plant, PlantPatch, Precondition, Predecessor, Predecessors, Receipt,
        Record, RecordKind, RecordSummary, Rotation, Rounds, Stored, Stream, StreamState, Successors, Task, TaskQuery,
        TaskResult, Tenant, ToldEvent, Trace,
        audit::{Chain, Contents, Entry, Prepared, Seal, Verdict},
    },
    key_operations, repository_operations,
};
use flankfit_engine::estimation::Nodes;

/// A read or a write with what it answers.
pub trait Operation: Send + Sync + 'static {
    type Reply: Send + 'static;

    /// Roughly what a write adds to the log.
    fn bytes(&self) -> usize {
        0
    }

    /// What a write changes.
    fn subject(&self) -> Subject {
        Subject::Nothing
    }

    /// The contents of the entries that a write leaves, as far as they are known before.
    fn contents(&self) -> Vec<Contents> {
        Vec::new()
    }

    /// What is kept of its request.
    fn receipt(&self) -> Option<&Receipt> {
        None
    }

    /// The idempotency key that it uses, once it is known whose.
    fn key(&self) -> Option<Key<'_>> {
        None
    }

    /// The lease under which a task asks for it.
    fn lease(&self) -> Option<Lease> {
        None
    }

    /// Whether what it takes away shall be nowhere afterwards.
    fn erases(&self) -> bool {
        false
    }
}

/// An idempotency key: tenant, key and scope.
pub type Key<'a> = (&'a str, &'a str, &'a str);

/// The key of a receipt.
pub fn key_of<'a>(tenant: &'a Tenant, receipt: &'a Receipt) -> Key<'a> {
    (tenant.as_str(), receipt.request.key.as_str(), receipt.request.scope.as_str())
}

/// A write as a caller asks for it.
pub struct Asked<O> {
    pub caller: Caller,
    /// When.
    pub at: Timestamp,
    /// The entries that it leaves.
    pub prepared: Vec<Prepared>,
    pub write: O,
}

impl<O: Operation> Operation for Asked<O> {
    type Reply = O::Reply;

    fn bytes(&self) -> usize {
        self.write.bytes()
    }

    fn subject(&self) -> Subject {
        self.write.subject()
    }

    fn key(&self) -> Option<Key<'_>> {
        self.write.receipt().map(|receipt| key_of(&self.caller.tenant, receipt))
    }

    fn lease(&self) -> Option<Lease> {
        self.write.receipt().and_then(|receipt| receipt.request.lease)
    }

    fn erases(&self) -> bool {
        self.write.erases()
    }
}

/// Makes a struct of each operation.
macro_rules! declare {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        $(
            $(#[$about])*
            pub struct $Read {
                $(pub $of: $what,)*
            }

            impl Operation for $Read {
                type Reply = $found;
            }
        )*

        $(
            $(#[$on])*
            pub struct $Write {
                $(pub $with: $given,)*
            }

            impl Operation for $Write {
                type Reply = $reply;

                fn bytes(&self) -> usize {
                    [$(self.$with.bytes()),*].iter().sum()
                }

                fn subject(&self) -> Subject {
                    About::about(self)
                }

                fn contents(&self) -> Vec<Contents> {
                    About::contents(self)
                }

                fn erases(&self) -> bool {
                    About::erases(self)
                }

                fn receipt(&self) -> Option<&Receipt> {
                    [$(self.$with.receipt()),*].into_iter().flatten().next()
                }
            }
        )*
    };
}

repository_operations!(declare);
key_operations!(declare);
