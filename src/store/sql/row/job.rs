//! Jobs, and answers kept under idempotency keys.

use uuid::Uuid;

use crate::{
    jobs::{Answer, Job},
    store::sql::columns::{Digest, Document, Integer, Moment, Tags},
};

/// The columns of [`JobRow`].
macro_rules! job_columns {
    () => {
        "id, name, part_number, serial_number, machine, gear, requirements, tags, version, created_at, updated_at, \
         purged_at"
    };
}
pub(in crate::store) use job_columns;

row! {
    pub struct JobRow {
        id: Uuid,
        name: String,
        part_number: Option<String>,
        serial_number: Option<String>,
        machine: Option<String>,
        gear: Option<String>,
        requirements: Option<String>,
        tags: Tags,
        version: Integer<u64>,
        created_at: Moment,
        updated_at: Moment,
        purged_at: Option<Moment>,
    }
}

impl From<JobRow> for Job {
    fn from(row: JobRow) -> Self {
        Job {
            id: row.id,
            name: row.name,
            part_number: row.part_number,
            serial_number: row.serial_number,
            machine: row.machine,
            gear: row.gear.map(Into::into),
            requirements: row.requirements.map(Into::into),
            tags: row.tags.0,
            version: row.version.0,
            created_at: row.created_at.0,
            updated_at: row.updated_at.0,
            purged_at: row.purged_at.map(|at| at.0),
        }
    }
}

row! {
    /// An answer kept under an idempotency key: whole, or around the result of a fit.
    pub struct AnswerRow {
        request_sha256: Digest,
        status: Integer<u16>,
        location: Option<String>,
        etag: Option<String>,
        body: Vec<u8>,
        result: Option<Document>,
        body_end: Option<Vec<u8>>,
    }
}

impl From<AnswerRow> for ([u8; 32], Answer) {
    fn from(row: AnswerRow) -> Self {
        let mut body = row.body;
        body.extend(row.result.map_or_else(Vec::new, |result| result.0.into_bytes()));
        body.extend(row.body_end.unwrap_or_default());
        let answer = Answer { status: row.status.0, location: row.location, etag: row.etag, body };
        (row.request_sha256.0, answer)
    }
}
