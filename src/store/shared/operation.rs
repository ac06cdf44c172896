//! What callers read and write, as data: the SQL is each database's own.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::weight::Weight;
use crate::{
    jobs::{
        Answer, Block, Caller, Choice, DecisionEvent, FinishedStream, FitRecord, FitSummary, Iteration, Job, JobEvent,
        JobPatch, Measurand, NewBlock, NewFit, NewIteration, NewRun, NewStream, Page, PageRequest, Precondition,
        Predecessor, Predecessors, Receipt, Record, RecordKind, RecordSummary, Stored, Stream, StreamState, Successors,
        Trace,
    },
    repository_operations,
};
use flankfit_engine::estimation::Nodes;

/// A read or a write with what it answers.
pub trait Operation: Send + Sync + 'static {
    type Reply: Send + 'static;

    /// Roughly what a write adds to the log.
    fn bytes(&self) -> usize {
        0
    }
}

/// A write as a caller asks for it.
pub struct Asked<O> {
    pub caller: Caller,
    pub write: O,
}

impl<O: Operation> Operation for Asked<O> {
    type Reply = O::Reply;

    fn bytes(&self) -> usize {
        self.write.bytes()
    }
}

/// Makes a struct of each operation.
macro_rules! declare {
    (
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
            }
        )*
    };
}

repository_operations!(declare);
