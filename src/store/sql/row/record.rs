//! Records of an iteration.

use crate::jobs::{Record, RecordDraft, RecordSummary};

from_row! {
    RecordSummary { id, kind, method, created_at, by = "actor", measurand }
    RecordDraft { kind, method, request, result, gear, class, measurand }
    Record { @draft, id, created_at, by = "actor" }
}
