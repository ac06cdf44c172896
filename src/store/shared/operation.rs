//! What is written, as data: the SQL is each database's own.
//!
//! An operation looks first and changes last: whatever it refuses, it refuses before its first
//! change, so a refusal leaves nothing to undo in the transaction that it shares with others. It
//! may run more than once, because a transaction that failed may be repeated.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::error::Outcome;
use crate::jobs::{
    Choice, DecisionEvent, FinishedStream, Job, JobPatch, NewBlock, NewFit, NewIteration, NewRun, NewStream,
    Precondition, Receipt, Record, Stored, nodes_codec,
};

/// A write with what it answers.
pub trait Operation: Send + Sync + 'static {
    type Reply: Send + 'static;

    /// Roughly what it adds to the log.
    fn bytes(&self) -> usize {
        0
    }
}

/// How an operation is done on a connection of some database, inside a transaction.
pub trait Run<C>: Operation {
    fn run(&self, db: &mut C) -> impl Future<Output = Outcome<Self::Reply>> + Send;
}

pub struct InsertJob {
    pub job: Job,
    pub receipt: Option<Receipt>,
}

impl Operation for InsertJob {
    type Reply = Stored;
}

pub struct PatchJob {
    pub id: Uuid,
    pub patch: JobPatch,
    pub precondition: Precondition,
    pub now: Timestamp,
}

impl Operation for PatchJob {
    type Reply = Job;
}

pub struct DeleteJob {
    pub id: Uuid,
    pub precondition: Precondition,
}

impl Operation for DeleteJob {
    type Reply = ();
}

/// Stores do many of these at once.
pub struct InsertIteration {
    pub iteration: Arc<NewIteration>,
    /// [`nodes_codec::encode`] of its nodes.
    pub nodes: Vec<u8>,
    pub receipt: Option<Receipt>,
}

impl InsertIteration {
    pub fn new(iteration: Arc<NewIteration>, receipt: Option<Receipt>) -> Self {
        let nodes = nodes_codec::encode(&iteration.nodes);
        InsertIteration { iteration, nodes, receipt }
    }
}

impl Operation for InsertIteration {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.nodes.len() + self.iteration.fit.computed.result.len()
    }
}

pub struct InsertFit {
    pub job: Uuid,
    pub number: u32,
    pub fit: Arc<NewFit>,
    pub receipt: Option<Receipt>,
}

impl Operation for InsertFit {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.fit.computed.result.len()
    }
}

pub struct Choose {
    pub job: Uuid,
    pub number: u32,
    pub choice: Choice,
    pub precondition: Precondition,
}

impl Operation for Choose {
    type Reply = Stored;
}

pub struct Decide {
    pub job: Uuid,
    pub number: u32,
    pub decision: DecisionEvent,
    pub precondition: Precondition,
}

impl Operation for Decide {
    type Reply = Stored;
}

pub struct InsertRecord {
    pub job: Uuid,
    pub number: u32,
    pub record: Arc<Record>,
    pub receipt: Option<Receipt>,
}

impl Operation for InsertRecord {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.record.draft.request.len() + self.record.draft.result.len()
    }
}

pub struct InsertStream {
    pub stream: Arc<NewStream>,
    pub receipt: Option<Receipt>,
}

impl Operation for InsertStream {
    type Reply = Stored;
}

pub struct InsertBlock {
    pub block: Arc<NewBlock>,
    /// [`nodes_codec::encode`] of its nodes.
    pub nodes: Vec<u8>,
    pub receipt: Option<Receipt>,
}

impl InsertBlock {
    pub fn new(block: Arc<NewBlock>, receipt: Option<Receipt>) -> Self {
        let nodes = nodes_codec::encode(&block.nodes);
        InsertBlock { block, nodes, receipt }
    }
}

impl Operation for InsertBlock {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.nodes.len() + self.block.state.as_ref().map_or(0, Vec::len)
    }
}

/// A stream becomes an iteration.
pub struct FinishStream {
    pub stream: Uuid,
    pub sequence: u64,
    pub iteration: InsertIteration,
}

impl FinishStream {
    pub fn new(finished: FinishedStream, receipt: Option<Receipt>) -> Self {
        let FinishedStream { stream, sequence, iteration } = finished;
        FinishStream { stream, sequence, iteration: InsertIteration::new(iteration, receipt) }
    }
}

impl Operation for FinishStream {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.iteration.bytes()
    }
}

pub struct DeleteStream {
    pub id: Uuid,
    pub precondition: Precondition,
    pub now: Timestamp,
}

impl Operation for DeleteStream {
    type Reply = ();
}

/// Jobs with their iterations.
pub struct InsertRuns {
    pub runs: Vec<(Job, Vec<InsertIteration>)>,
    pub receipt: Option<Receipt>,
    pub now: Timestamp,
}

impl InsertRuns {
    pub fn new(runs: Vec<NewRun>, receipt: Option<Receipt>, now: Timestamp) -> Self {
        let iterations = |of: Vec<Arc<NewIteration>>| of.into_iter().map(|new| InsertIteration::new(new, None));
        let runs = runs.into_iter().map(|run| (run.job, iterations(run.iterations).collect())).collect();
        InsertRuns { runs, receipt, now }
    }
}

impl Operation for InsertRuns {
    type Reply = Stored;

    fn bytes(&self) -> usize {
        self.runs.iter().flat_map(|(_, iterations)| iterations).map(InsertIteration::bytes).sum()
    }
}

/// Forgets kept answers from before a time, the oldest first, at most so many; answers how many.
pub struct ForgetAnswers {
    pub before: Timestamp,
    pub most: u32,
}

impl Operation for ForgetAnswers {
    type Reply = u64;
}

/// Writes what nobody reads, to find out whether anything can be written.
pub struct Probe {
    pub now: Timestamp,
}

impl Operation for Probe {
    type Reply = ();
}
