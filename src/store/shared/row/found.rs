//! Rows of a job as the audit finds them: each with the number of its iteration, and read for its
//! digest alone.

use sqlx::FromRow;
use uuid::Uuid;

use super::{
    fit::{ChoiceRow, DecisionRow, FigureRow, ReasonRow},
    iteration::{DetailsRow, MeasurandRow},
    record::RecordRow,
};
use crate::{
    jobs::audit::{
        Kind, Sha256Digest, choice_digest, decision_digest, fit_digest, iteration_digest, nodes_digest, record_digest,
    },
    store::shared::columns::{Document, Integer, Moment},
};

/// A row of some kind.
pub trait FoundRow {
    const KIND: Kind;

    fn digest(self) -> Sha256Digest;
}

#[derive(FromRow)]
pub struct FoundIteration {
    id: Uuid,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    #[sqlx(flatten)]
    details: DetailsRow,
    created_at: Moment,
}

impl FoundRow for FoundIteration {
    const KIND: Kind = Kind::Iteration;

    fn digest(self) -> Sha256Digest {
        iteration_digest(self.id, &self.measurand.into(), &self.details.into(), self.created_at.0)
    }
}

#[derive(FromRow)]
pub struct FoundNodes {
    count: Integer<u64>,
    data: Vec<u8>,
}

impl FoundRow for FoundNodes {
    const KIND: Kind = Kind::Nodes;

    fn digest(self) -> Sha256Digest {
        nodes_digest(self.count.0, &self.data)
    }
}

#[derive(FromRow)]
pub struct FoundFit {
    id: Uuid,
    #[sqlx(flatten)]
    event: ReasonRow,
    #[sqlx(flatten)]
    figures: FigureRow,
    spec: Document,
    pub result: Document,
}

impl FoundRow for FoundFit {
    const KIND: Kind = Kind::Fit;

    fn digest(self) -> Sha256Digest {
        fit_digest(self.id, &self.event.into(), &self.figures.into(), &self.spec.0, &self.result.0)
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
