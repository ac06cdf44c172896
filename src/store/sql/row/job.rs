//! Jobs, and answers kept under idempotency keys.

use std::sync::Arc;

use crate::jobs::{Answer, Job};

/// The columns of a [`Job`].
macro_rules! job_columns {
    () => {
        "id, name, part_number, serial_number, machine, gear, requirements, tags, status, version, created_at, \
         updated_at, purged_at"
    };
}
pub(in crate::store::sql) use job_columns;

from_row! {
    Job {
        id, name, part_number, serial_number, machine, gear, requirements, tags, status, version, created_at,
        updated_at, purged_at,
    }
}

row! {
    /// An answer kept under an idempotency key: whole, or around the result of a fit.
    pub struct AnswerRow {
        request_sha256: [u8; 32],
        status: u16,
        location: Option<String>,
        etag: Option<String>,
        body: Vec<u8>,
        result: Option<Arc<str>>,
        body_end: Option<Vec<u8>>,
    }
}

impl From<AnswerRow> for ([u8; 32], Answer) {
    fn from(row: AnswerRow) -> Self {
        let AnswerRow { request_sha256, status, location, etag, mut body, result, body_end } = row;
        body.extend(result.iter().flat_map(|result| result.as_bytes()));
        body.extend(body_end.unwrap_or_default());
        (request_sha256, Answer { status, location, etag, body })
    }
}
