//! Iterations, and what they are of.

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::{
    DecisionEvent, FitSummary, Iteration, ListedIteration, MadeCorrection, Measurand, MeasuredIteration,
    MeasurementDetails, Predecessor, RepositoryError, TracedIteration, has_no_tooth,
};
use flankfit_engine::estimation::Nodes;

from_row! {
    Measurand { flank, tooth, axes, units_accepted }
    MeasurementDetails { measured_at, instrument, operator, note }
    ListedIteration {
        @measurand, @fit,
        id = "iteration_id", number, measured_at, instrument, operator, created_at = "stored_at", decision, decided_by,
    }
    Predecessor { @measurand, number, fit_id }
    MeasuredIteration { @measurand, number, created_at }
    MadeCorrection { number, id, kind, created_at }
}

row! {
    pub struct SuccessorRow {
        @pub measurand: Measurand,
        pub number: u32,
    }
}

row! {
    pub struct IterationRow {
        @measurand: Measurand,
        @details: MeasurementDetails,
        id: Uuid,
        created_at: Timestamp,
        node_count: u64,
        version: u64,
        purged_at: Option<Timestamp>,
    }
}

impl IterationRow {
    /// Returns the iteration of this number of a job, with its last fits and how many come before
    /// them.
    pub fn with(
        self,
        (job_id, number): (Uuid, u32),
        (fits, earlier_fits): (Vec<FitSummary>, u64),
        decision: Option<DecisionEvent>,
    ) -> Iteration {
        let IterationRow { measurand, details, id, created_at, node_count, version, purged_at } = self;
        Iteration {
            id,
            job_id,
            number,
            measurand,
            details,
            created_at,
            node_count,
            version,
            fits,
            earlier_fits,
            decision,
            purged_at,
        }
    }
}

row! {
    pub struct TracedIterationRow {
        @measurand: Measurand,
        id: Uuid,
        number: u32,
        measured_at: Option<Timestamp>,
        instrument: Option<String>,
        operator: Option<String>,
        created_at: Timestamp,
    }
}

impl From<TracedIterationRow> for TracedIteration {
    /// Returns the iteration without its lists.
    fn from(row: TracedIterationRow) -> Self {
        let TracedIterationRow { measurand, id, number, measured_at, instrument, operator, created_at } = row;
        TracedIteration {
            id,
            number,
            measurand,
            measured_at,
            instrument,
            operator,
            created_at,
            fits: Vec::new(),
            choices: Vec::new(),
            decisions: Vec::new(),
            records: Vec::new(),
            earlier: Default::default(),
        }
    }
}

row! {
    /// Nodes, unless they are longer than the limit, with their length.
    pub struct NodesRow {
        length: usize,
        data: Option<Nodes>,
    }
}

impl NodesRow {
    /// Returns whether the nodes were purged: no encoding of any is empty.
    pub fn is_gone(&self) -> bool {
        self.length == 0
    }
}

impl From<NodesRow> for Result<Nodes, usize> {
    fn from(NodesRow { length, data }: NodesRow) -> Self {
        data.ok_or(length)
    }
}

row! {
    /// A tooth that was measured, by an iteration or by a stream that may become one.
    pub struct MeasuredTooth {
        tooth: String,
        iteration: Option<u32>,
    }
}

impl MeasuredTooth {
    /// Refuses a gear with so many teeth, if it lacks one that was measured.
    pub fn check(measured: Vec<MeasuredTooth>, teeth: u32) -> Result<(), RepositoryError> {
        match measured.into_iter().find(|measured| has_no_tooth(&measured.tooth, teeth)) {
            None => Ok(()),
            Some(MeasuredTooth { tooth, iteration }) => Err(RepositoryError::ToothMeasured { tooth, teeth, iteration }),
        }
    }
}
