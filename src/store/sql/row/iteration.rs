//! Iterations, and what they are of.

use crate::jobs::{
    Iteration, ListedIteration, MadeCorrection, Measurand, MeasuredIteration, MeasurementDetails, Predecessor,
    RepositoryError, TracedIteration, has_no_tooth,
};
use flankfit_engine::estimation::Nodes;

from_row! {
    Measurand { flank, tooth, axes, accept_units }
    MeasurementDetails { measured_at, instrument, operator, note }
    ListedIteration {
        @measurand, @fit,
        id = "iteration_id", number, measured_at, instrument, operator, created_at = "stored_at", decision, decided_by,
    }
    Iteration {
        @measurand, @details, id, job_id, number, created_at, node_count, version, purged_at;
        fits, earlier_fits, decision
    }
    TracedIteration {
        @measurand, id, number, measured_at, instrument, operator, created_at;
        fits, choices, decisions, records, earlier
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
