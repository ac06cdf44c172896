//! Rows of a job as the audit finds them: each with the number of its iteration, and read for its
//! digest alone.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::fit::figure_columns;

use crate::jobs::{
    Choice, DecisionEvent, Event, Figures, Measurand, MeasurementDetails, Record, Told,
    audit::{
        FoundStream, Kind, Sha256Digest, block_digest, choice_digest, decision_digest, fit_digest, iteration_digest,
        nodes_digest, record_digest, stream_digest,
    },
};

/// A row of some kind.
pub trait FoundRow {
    const KIND: Kind;
    /// Reads the rows of a job in order, each with the number of its iteration.
    const SQL: &'static str;

    fn digest(self) -> Sha256Digest;
}

row! {
    pub struct FoundIteration {
        @measurand: Measurand,
        @details: MeasurementDetails,
        id: Uuid,
        created_at: Timestamp,
    }
}

impl FoundRow for FoundIteration {
    const KIND: Kind = Kind::Iteration;
    const SQL: &'static str = "
        SELECT number, id, flank, tooth, axes, false AS units_accepted, measured_at, instrument, operator, note,
               created_at
        FROM iterations WHERE job = $1 ORDER BY number";

    fn digest(self) -> Sha256Digest {
        iteration_digest(self.id, &self.measurand, &self.details, self.created_at)
    }
}

row! {
    pub struct FoundNodes {
        count: u64,
        data: Vec<u8>,
    }
}

impl FoundRow for FoundNodes {
    const KIND: Kind = Kind::Nodes;
    const SQL: &'static str = "SELECT number, count, data FROM nodes WHERE job = $1 ORDER BY number";

    fn digest(self) -> Sha256Digest {
        nodes_digest(self.count, &self.data)
    }
}

row! {
    /// A fit with the parts of its result that columns of their own have as well.
    pub struct FoundFit {
        @event: Event,
        @figures: Figures,
        id: Uuid,
        spec: Arc<str>,
        result: Arc<str>,
        flank_figures: Option<String>,
        coefficients: Option<Arc<str>>,
        prior: Option<Arc<str>>,
    }
}

impl FoundRow for FoundFit {
    const KIND: Kind = Kind::Fit;
    const SQL: &'static str = concat!(
        "SELECT number, id, reason, actor, created_at, ",
        figure_columns!(),
        ", spec, result, flank_figures, coefficients, prior FROM fits WHERE job = $1 ORDER BY number, position"
    );

    fn digest(self) -> Sha256Digest {
        let FoundFit { event, figures, id, spec, result, flank_figures, coefficients, prior } = self;
        let kept = Told { coefficients: coefficients.as_deref(), prior: prior.as_deref() };
        // where nothing is stored separately the trace reads the result itself
        if kept != Told::default() && kept != Told::of(&result) {
            return [0; 32];
        }
        fit_digest(id, &event, &figures, &spec, &result, flank_figures.as_deref())
    }
}

impl FoundRow for Choice {
    const KIND: Kind = Kind::Choice;
    const SQL: &'static str = "
        SELECT c.number, f.id AS fit_id, c.reason, c.actor, c.created_at
        FROM fit_choices c JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
        WHERE c.job = $1 ORDER BY c.number, c.position";

    fn digest(self) -> Sha256Digest {
        choice_digest(&self)
    }
}

impl FoundRow for DecisionEvent {
    const KIND: Kind = Kind::Decision;
    const SQL: &'static str = "
        SELECT number, decision, concession IS NOT NULL AS concession, reason, actor, created_at
        FROM decisions WHERE job = $1 ORDER BY number, position";

    fn digest(self) -> Sha256Digest {
        decision_digest(&self)
    }
}

impl FoundRow for Record {
    const KIND: Kind = Kind::Record;
    const SQL: &'static str = "
        SELECT number, id, kind, method, created_at, actor, request, result, gear, class, measurand
        FROM records WHERE job = $1 ORDER BY number, position";

    fn digest(self) -> Sha256Digest {
        record_digest(&self)
    }
}

row! {
    pub struct FoundStreamRow {
        @measurand: Measurand,
        id: Uuid,
        spec: Arc<str>,
        forgetting_factor: f64,
        created_at: Timestamp,
        open: bool,
    }
}

impl From<FoundStreamRow> for (Uuid, FoundStream) {
    fn from(row: FoundStreamRow) -> Self {
        let digest = stream_digest(row.id, &row.spec, row.forgetting_factor, &row.measurand, row.created_at);
        (row.id, FoundStream { digest, open: row.open })
    }
}

row! {
    pub struct FoundBlock {
        stream: Uuid,
        sequence: u64,
        sha256: [u8; 32],
        count: u64,
        data: Vec<u8>,
    }
}

impl From<FoundBlock> for ((Uuid, u64), Sha256Digest) {
    fn from(row: FoundBlock) -> Self {
        ((row.stream, row.sequence), block_digest(row.sequence, &row.sha256, row.count, &row.data))
    }
}
