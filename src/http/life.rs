//! Old jobs: archived, and purged.

use std::{
    fmt::{self, Display, Formatter},
    io,
    sync::LazyLock,
    time::Duration,
};

use axum::{
    http::{HeaderName, HeaderValue, header},
    response::Response,
};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    body::Payload,
    caller_state::CallerState,
    compute::read_small_json,
    extract::PathOf,
    growing::{self, Growing},
    idempotency::{IdempotencyKey, idempotent},
    state::AppState,
};
use crate::{
    api::{
        jobs::purge::{PurgeBody, PurgeRequestBody, told},
        json::{value::read_json, writer::text_of},
        problem::Problem,
    },
    jobs::{Answer, NewPurge, RepositoryError, Scope, Stored},
    pool::computing,
};

/// Tells the digest of an archive.
pub static ARCHIVE_SHA256: HeaderName = HeaderName::from_static("archive-sha256");
/// The media type of archives: frames of zstd.
pub const ARCHIVE: &str = "application/zstd";
/// An archive that takes longer is sent as it is written.
const PATIENCE: Duration = Duration::from_secs(30);

static MEDIA: LazyLock<HeaderValue> = LazyLock::new(|| HeaderValue::from_static(ARCHIVE));

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(archive_job)).routes(routes!(purge_job))
}

/// Writes all that there is of a job into a file: nodes, fits, records, streams, events, and the
/// audit.
///
/// JSON lines, compressed by zstd, in the format of `flankfit export` and `flankfit import`. The
/// bytes are the same until the job changes. Nothing is stored. A large archive is sent while it is
/// written, without `archive-sha256` and length; a file without its last line is incomplete.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/archive", operation_id = "archive_job", tag = "jobs",
    params(("job_id" = Uuid, Path)),
    responses(
        (status = 200, description = "The archive, to be saved.", content((String = "application/zstd")),
            headers(("archive-sha256" = String, description = "SHA-256 of the file, in 64 hexadecimal digits; absent \
                for a large archive."))),
        (status = 403, description = "The caller lacks a scope: `admin` or `read`.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn archive_job(state: CallerState, PathOf(job): PathOf<Uuid>) -> Result<Response, Problem> {
    if !state.principal.scopes.contains(Scope::Read) {
        return Err(Problem::lacking_scope(
            "An archive holds all that there is of a job: it asks for the scope `read` too.",
        ));
    }
    // what there is to refuse is refused before the answer begins
    state.jobs.job(job).await?;
    let (own, spool) = (state.jobs.clone(), Growing::new(state.settings.retention.spool_dir()));
    let to = spool.clone();
    let write = async move { own.archive(job, to).await.map(|(_, archived)| archived).map_err(Unwritten) };
    let patience = PATIENCE.min(state.settings.request_timeout() / 2);
    let growing::Sent { body, written } = growing::send(spool, write, patience).await.map_err(|error| error.0)?;
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, MEDIA.clone());
    if let Ok(name) = HeaderValue::from_str(&format!("attachment; filename=\"job-{job}.jsonl.zst\"")) {
        headers.insert(header::CONTENT_DISPOSITION, name);
    }
    let Some(archived) = written else { return Ok(response) };
    headers.insert(header::CONTENT_LENGTH, HeaderValue::from(archived.bytes));
    if let Ok(digest) = HeaderValue::from_str(&told(&archived.sha256)) {
        headers.insert(&ARCHIVE_SHA256, digest);
    }
    Ok(response)
}

/// Why an archive was not written.
struct Unwritten(RepositoryError);

impl Display for Unwritten {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<io::Error> for Unwritten {
    fn from(error: io::Error) -> Self {
        Unwritten(RepositoryError::Failed(error.to_string()))
    }
}

/// Takes nodes, results, texts and names of a job away, for good.
///
/// Removes personal names and frees space. The job's row, its numbers, times and figures, and its
/// audit are kept; requests for anything else are answered 410, and the job cannot be changed any
/// more. The request must contain the digest of the job's current archive (`POST …/archive`): keep
/// that file, it is the only copy of the removed data. The purge is recorded in the audits of the
/// job and of the tenant.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/purge", operation_id = "purge_job", tag = "jobs",
    params(("job_id" = Uuid, Path), IdempotencyKey),
    request_body(content = PurgeRequestBody, description = "Why, and which archive is kept."),
    responses(
        (status = 200, description = "The purge.", body = PurgeBody),
        (status = 409, description = "An operation of the job has not ended, or its audit is broken.", body = Problem,
            content_type = "application/problem+json"),
        (status = 410, description = "The job is purged already.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn purge_job(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    idempotent(state, key, format!("POST /v1/jobs/{job}/purge"), payload, |state, payload, key| async move {
        let limit = state.settings.body_limit;
        let read = |text: &[u8]| Ok(read_json::<PurgeRequestBody>(text)?);
        let PurgeRequestBody { reason, archive_sha256 } = read_small_json(&state, payload, limit, read).await?;
        let keyed = key.map(|key| key.answered_by(purged));
        if state.jobs.job(job).await?.purged_at.is_none() {
            // it is archived once more
            state.pool.run(computing).await?;
        }
        let new = state.jobs.purge(job, reason.into(), archive_sha256.0, keyed).await?;
        Ok(purged(&new, Stored { number: 0, version: 0 }))
    })
    .await
}

fn purged(new: &NewPurge, _stored: Stored) -> Answer {
    Answer { status: 200, location: None, etag: None, body: text_of(&PurgeBody::from(new)).into_bytes() }
}
