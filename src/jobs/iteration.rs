//! An iteration of a job: nodes measured once, the fits made of them, and the events that followed.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::*;

/// Content of a new iteration: nodes, first fit and the choice of that fit, all or
/// nothing.
#[derive(Clone, Debug)]
pub struct NewIteration {
    pub id: Uuid,
    pub job_id: Uuid,
    pub measurand: Measurand,
    pub details: MeasurementDetails,
    pub created_at: Timestamp,
    pub nodes: EncodedNodes,
    pub fit: NewFit,
    /// Its first records, stored in the same transaction.
    pub records: Vec<Record>,
    /// The gear that the job must still have.
    pub expected_gear: Option<ExpectedGear>,
}

impl NewIteration {
    /// Returns the bytes that it adds to the log of a database, roughly.
    pub fn bytes(&self) -> usize {
        self.nodes.bytes().len() + self.fit.bytes()
    }

    /// Refuses what the job's gear, a document, contradicts as it is now.
    pub fn check_gear(&self, gear: Option<&str>) -> Result<(), RepositoryError> {
        let of_another = |ExpectedGear(expected): &ExpectedGear| expected.as_deref() != gear;
        if self.expected_gear.as_ref().is_some_and(of_another) {
            return Err(RepositoryError::GearChanged);
        }
        if self.measurand.tooth.is_none() {
            return Ok(());
        }
        let gear = gear.map(|document| JobGear::from(document.to_owned()));
        self.measurand.check_tooth(gear.as_ref().and_then(JobGear::teeth))
    }
}

/// A job about to be stored with its iterations.
#[derive(Clone, Debug)]
pub struct NewRun {
    pub job: Job,
    pub iterations: Vec<Arc<NewIteration>>,
}

/// Entries of a list that are read with an iteration; older ones are counted.
pub const MAX_LISTED: u32 = 100;

/// A stored iteration with its fits, in the order in which they were made.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    pub id: Uuid,
    pub job_id: Uuid,
    /// 1, 2, 3 … within the job, without gaps.
    pub number: u32,
    pub measurand: Measurand,
    pub details: MeasurementDetails,
    pub created_at: Timestamp,
    /// Nodes posted, missing ones included.
    pub node_count: u64,
    /// 1 when created, one more with every fit, choice and decision.
    pub version: u64,
    /// The last [`MAX_LISTED`].
    pub fits: Vec<FitSummary>,
    /// Fits made before those.
    pub earlier_fits: u64,
    /// The latest decision, if there is one.
    pub decision: Option<DecisionEvent>,
    /// When its nodes, results, texts and names were taken away, if they were.
    pub purged_at: Option<Timestamp>,
}

/// An iteration in a list, with its chosen fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedIteration {
    pub id: Uuid,
    pub number: u32,
    pub measurand: Measurand,
    pub measured_at: Option<Timestamp>,
    pub instrument: Option<String>,
    pub operator: Option<String>,
    pub created_at: Timestamp,
    /// The latest, with who took it.
    pub decision: Option<Decision>,
    pub decided_by: Option<Arc<str>>,
    pub fit: FitSummary,
}

/// A part of the story of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    pub job: Job,
    pub iterations: Vec<TracedIteration>,
    pub next: Option<Cursor>,
}

/// An iteration in the trace: fits, choices and decisions in the order in which they were
/// made, of each the last [`MAX_LISTED`].
#[derive(Clone, Debug, PartialEq)]
pub struct TracedIteration {
    pub id: Uuid,
    pub number: u32,
    pub measurand: Measurand,
    pub measured_at: Option<Timestamp>,
    pub instrument: Option<String>,
    pub operator: Option<String>,
    pub created_at: Timestamp,
    pub fits: Vec<TracedFit>,
    pub choices: Vec<Choice>,
    pub decisions: Vec<DecisionEvent>,
    /// Records of the iteration, oldest first.
    pub records: Vec<RecordSummary>,
    pub earlier: Earlier,
}

/// How many entries of each list stand before those listed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Earlier {
    pub fits: u64,
    pub choices: u64,
    pub decisions: u64,
    pub records: u64,
}

/// A fit by its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSummary {
    pub id: Uuid,
    pub chosen: bool,
    /// Who chose it, if it is the chosen fit and somebody is known.
    pub chosen_by: Option<Arc<str>>,
    pub figures: Figures,
    /// The figures of the flank, as they were answered first.
    pub flank: Option<Arc<str>>,
    pub event: Event,
}

/// A fit in the trace.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedFit {
    pub summary: FitSummary,
    /// The answered coefficients, as the JSON array that was answered; of a purged job `[]`.
    pub coefficients: String,
    /// Its prior, as the JSON object of the response.
    pub prior: Option<String>,
}

/// A change of the measurand of nodes. It is stored in one transaction with the fit whose figures
/// follow from it and with the decision sent with it.
#[derive(Clone, Debug)]
pub struct Amendment {
    /// The new measurand of the nodes.
    pub measurand: Measurand,
    /// Record of the change, with the values before and after.
    pub record: Record,
    /// The chosen fit repeated with the figures of the new measurand; it becomes the chosen one.
    pub fit: Option<NewFit>,
    pub decision: Option<DecisionEvent>,
}

impl Amendment {
    /// Returns by how much the version of the iteration increases: one for the change, each fit,
    /// choice and decision.
    pub fn steps(&self) -> u64 {
        1 + 2 * u64::from(self.fit.is_some()) + u64::from(self.decision.is_some())
    }
}

/// An earlier iteration of the same flank and tooth.
#[derive(Clone, Debug, PartialEq)]
pub struct Predecessor {
    pub number: u32,
    pub measurand: Measurand,
    /// The chosen fit.
    pub fit_id: Uuid,
}

/// Which of them: numbers from `from` on and below `before`, and of these the last `most`.
#[derive(Clone, Debug, PartialEq)]
pub struct Predecessors {
    pub of: Measurand,
    pub from: u32,
    /// The iteration that they precede; `None` for one that is about to be stored.
    pub before: Option<u32>,
    pub most: usize,
}
