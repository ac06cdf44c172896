//! Records of an iteration.

use sqlx::FromRow;
use uuid::Uuid;

use crate::{
    jobs::{Record, RecordDraft, RecordKind, RecordSummary},
    store::shared::columns::{Document, Moment},
};

#[derive(FromRow)]
pub struct RecordSummaryRow {
    id: Uuid,
    kind: RecordKind,
    method: String,
    created_at: Moment,
}

impl From<RecordSummaryRow> for RecordSummary {
    fn from(RecordSummaryRow { id, kind, method, created_at }: RecordSummaryRow) -> Self {
        RecordSummary { id, kind, method, created_at: created_at.0 }
    }
}

#[derive(FromRow)]
pub struct RecordRow {
    #[sqlx(flatten)]
    summary: RecordSummaryRow,
    request: Document,
    result: Document,
    gear: Option<String>,
}

impl RecordRow {
    /// Whether the record was purged.
    pub fn is_gone(&self) -> bool {
        self.result.0.is_empty()
    }
}

impl From<RecordRow> for Record {
    fn from(RecordRow { summary, request, result, gear }: RecordRow) -> Self {
        let RecordSummaryRow { id, kind, method, created_at } = summary;
        let gear = gear.map(Into::into);
        let draft = RecordDraft { kind, method, request: request.into(), result: result.into(), gear };
        Record { id, created_at: created_at.0, draft }
    }
}
