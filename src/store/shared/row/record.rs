//! Records of an iteration.

use sqlx::FromRow;
use uuid::Uuid;

use crate::{
    jobs::{Record, RecordDraft, RecordKind, RecordSummary},
    store::shared::columns::{Document, Integer, Moment},
};

#[derive(FromRow)]
pub struct RecordSummaryRow {
    id: Uuid,
    kind: RecordKind,
    method: String,
    created_at: Moment,
    actor: Option<String>,
}

impl From<RecordSummaryRow> for RecordSummary {
    fn from(RecordSummaryRow { id, kind, method, created_at, actor }: RecordSummaryRow) -> Self {
        RecordSummary { id, kind, method, created_at: created_at.0, by: actor.map(Into::into) }
    }
}

#[derive(FromRow)]
pub struct RecordRow {
    #[sqlx(flatten)]
    summary: RecordSummaryRow,
    request: Document,
    result: Document,
    gear: Option<String>,
    class: Option<Integer<u8>>,
}

impl RecordRow {
    /// Whether the record was purged.
    pub fn is_gone(&self) -> bool {
        self.result.0.is_empty()
    }
}

impl From<RecordRow> for Record {
    fn from(RecordRow { summary, request, result, gear, class }: RecordRow) -> Self {
        let RecordSummaryRow { id, kind, method, created_at, actor } = summary;
        let gear = gear.map(Into::into);
        let (request, result, class) = (request.into(), result.into(), class.map(|class| class.0));
        let draft = RecordDraft { kind, method, request, result, gear, class };
        Record { id, created_at: created_at.0, by: actor.map(Into::into), draft }
    }
}
