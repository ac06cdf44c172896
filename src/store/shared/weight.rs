//! How much a write adds to the log of a database, roughly: nodes, answers and what is as long.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::{
    Amendment, Choice, DecisionEvent, FinishedStream, Job, JobPatch, KeptMapping, KeyId, KeyPatch, NewBlock, NewFit,
    NewIteration, NewKey, NewPlant, NewPurge, NewRun, NewStream, NewTask, PlantPatch, Precondition, Receipt, Record,
    Rotation, Tenant,
};

/// Part of a write.
pub trait Weight {
    /// Little, unless it is said.
    fn bytes(&self) -> usize {
        0
    }

    /// The receipt, of the part that is one.
    fn receipt(&self) -> Option<&Receipt> {
        None
    }
}

/// Parts that are little.
macro_rules! light {
    ($($part:ty),* $(,)?) => {
        $(impl Weight for $part {})*
    };
}

light!(
    Choice,
    DecisionEvent,
    Job,
    JobPatch,
    KeptMapping,
    KeyId,
    KeyPatch,
    NewKey,
    NewPlant,
    NewPurge,
    NewStream,
    PlantPatch,
    Precondition,
    Rotation,
    Tenant,
    Timestamp,
    Uuid,
    u32,
    u64
);

impl Weight for Option<Uuid> {}

impl Weight for NewTask {
    fn bytes(&self) -> usize {
        NewTask::bytes(self)
    }
}

impl Weight for Option<Receipt> {
    fn receipt(&self) -> Option<&Receipt> {
        self.as_ref()
    }
}

impl<T: Weight> Weight for Arc<T> {
    fn bytes(&self) -> usize {
        T::bytes(self)
    }
}

impl Weight for NewFit {
    fn bytes(&self) -> usize {
        self.computed.result.bytes().len() + self.computed.flank.as_ref().map_or(0, |flank| flank.len())
    }
}

impl Weight for NewIteration {
    fn bytes(&self) -> usize {
        self.nodes.bytes().len() + self.fit.bytes()
    }
}

impl Weight for Vec<NewRun> {
    fn bytes(&self) -> usize {
        self.iter().flat_map(|run| &run.iterations).map(Weight::bytes).sum()
    }
}

impl Weight for Record {
    fn bytes(&self) -> usize {
        self.draft.request.len() + self.draft.result.len()
    }
}

impl Weight for Amendment {
    fn bytes(&self) -> usize {
        self.record.bytes() + self.fit.as_ref().map_or(0, Weight::bytes)
    }
}

impl Weight for NewBlock {
    fn bytes(&self) -> usize {
        self.nodes.bytes().len() + self.state.as_ref().map_or(0, Vec::len)
    }
}

impl Weight for FinishedStream {
    fn bytes(&self) -> usize {
        self.iteration.bytes()
    }
}
