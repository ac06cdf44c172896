//! Records of an iteration.

use uuid::Uuid;

use crate::{
    jobs::{Record, RecordDraft, RecordKind, RecordSummary},
    store::sql::columns::{Document, Integer, Moment},
};

row! {
    pub struct RecordSummaryRow {
        id: Uuid,
        kind: RecordKind,
        method: String,
        created_at: Moment,
        actor: Option<String>,
        measurand: Option<String>,
    }
}

impl From<RecordSummaryRow> for RecordSummary {
    fn from(row: RecordSummaryRow) -> Self {
        let RecordSummaryRow { id, kind, method, created_at, actor, measurand } = row;
        let (by, measurand) = (actor.map(Into::into), measurand.map(Into::into));
        RecordSummary { id, kind, method, created_at: created_at.0, by, measurand }
    }
}

row! {
    pub struct RecordRow {
        @summary: RecordSummaryRow,
        request: Document,
        result: Document,
        gear: Option<String>,
        class: Option<Integer<u8>>,
    }
}

impl RecordRow {
    /// Whether the record was purged.
    pub fn is_gone(&self) -> bool {
        self.result.0.is_empty()
    }
}

impl From<RecordRow> for Record {
    fn from(RecordRow { summary, request, result, gear, class }: RecordRow) -> Self {
        let RecordSummaryRow { id, kind, method, created_at, actor, measurand } = summary;
        let (gear, measurand) = (gear.map(Into::into), measurand.map(Into::into));
        let (request, result, class) = (request.into(), result.into(), class.map(|class| class.0));
        let draft = RecordDraft { kind, method, request, result, gear, class, measurand };
        Record { id, created_at: created_at.0, by: actor.map(Into::into), draft }
    }
}
