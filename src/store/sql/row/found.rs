//! Rows of a job as the audit finds them: each with the number of its iteration, and read for its
//! digest alone.

use uuid::Uuid;

use super::{
    fit::{ChoiceRow, DecisionRow, FigureRow, ReasonRow},
    iteration::{DetailsRow, MeasurandRow},
    record::RecordRow,
};
use crate::{
    jobs::{
        Told,
        audit::{
            FoundStream, Kind, Sha256Digest, block_digest, choice_digest, decision_digest, fit_digest,
            iteration_digest, nodes_digest, record_digest, stream_digest,
        },
    },
    store::sql::columns::{Digest, Document, Integer, Moment},
};

/// A row of some kind.
pub trait FoundRow {
    const KIND: Kind;

    fn digest(self) -> Sha256Digest;
}

row! {
    pub struct FoundIteration {
        @measurand: MeasurandRow,
        @details: DetailsRow,
        id: Uuid,
        created_at: Moment,
    }
}

impl FoundRow for FoundIteration {
    const KIND: Kind = Kind::Iteration;

    fn digest(self) -> Sha256Digest {
        iteration_digest(self.id, &self.measurand.into(), &self.details.into(), self.created_at.0)
    }
}

row! {
    pub struct FoundNodes {
        count: Integer<u64>,
        data: Vec<u8>,
    }
}

impl FoundRow for FoundNodes {
    const KIND: Kind = Kind::Nodes;

    fn digest(self) -> Sha256Digest {
        nodes_digest(self.count.0, &self.data)
    }
}

row! {
    struct FoundFit {
        @event: ReasonRow,
        @figures: FigureRow,
        id: Uuid,
        spec: Document,
        result: Document,
        flank_figures: Option<String>,
    }
}

row! {
    /// A fit with what the trace tells of it, where columns of their own have what is in its result
    /// as well.
    pub struct FoundFitTold {
        @fit: FoundFit,
        coefficients: Option<Document>,
        prior: Option<Document>,
    }
}

fn text(document: &Option<Document>) -> Option<&str> {
    document.as_ref().map(|Document(text)| text.as_str())
}

impl FoundRow for FoundFitTold {
    const KIND: Kind = Kind::Fit;

    fn digest(self) -> Sha256Digest {
        let FoundFitTold { fit, coefficients, prior } = self;
        let kept = Told { coefficients: text(&coefficients), prior: text(&prior) };
        // where nothing is kept the trace reads the result itself
        if kept != Told::default() && kept != Told::of(&fit.result.0) {
            return [0; 32];
        }
        let FoundFit { id, event, figures, spec, result, flank_figures } = fit;
        fit_digest(id, &event.into(), &figures.into(), &spec.0, &result.0, flank_figures.as_deref())
    }
}

impl FoundRow for ChoiceRow {
    const KIND: Kind = Kind::Choice;

    fn digest(self) -> Sha256Digest {
        choice_digest(&self.into())
    }
}

impl FoundRow for DecisionRow {
    const KIND: Kind = Kind::Decision;

    fn digest(self) -> Sha256Digest {
        decision_digest(&self.into())
    }
}

impl FoundRow for RecordRow {
    const KIND: Kind = Kind::Record;

    fn digest(self) -> Sha256Digest {
        record_digest(&self.into())
    }
}

row! {
    pub struct FoundStreamRow {
        @measurand: MeasurandRow,
        id: Uuid,
        spec: Document,
        forgetting_factor: f64,
        created_at: Moment,
        open: bool,
    }
}

impl From<FoundStreamRow> for (Uuid, FoundStream) {
    fn from(row: FoundStreamRow) -> Self {
        let measurand = row.measurand.into();
        let digest = stream_digest(row.id, &row.spec.0, row.forgetting_factor, &measurand, row.created_at.0);
        (row.id, FoundStream { digest, open: row.open })
    }
}

row! {
    pub struct FoundBlock {
        stream: Uuid,
        sequence: Integer<u64>,
        sha256: Digest,
        count: Integer<u64>,
        data: Vec<u8>,
    }
}

impl From<FoundBlock> for ((Uuid, u64), Sha256Digest) {
    fn from(row: FoundBlock) -> Self {
        let digest = block_digest(row.sequence.0, &row.sha256.0, row.count.0, &row.data);
        ((row.stream, row.sequence.0), digest)
    }
}
