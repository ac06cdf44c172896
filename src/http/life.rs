//! Old jobs: archived, and purged.

use std::io;

use axum::{
    body::{Body, Bytes},
    http::{HeaderValue, header},
    response::Response,
};
use futures_util::{StreamExt, stream};
use tokio::sync::mpsc;
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    body::Payload,
    caller_state::CallerState,
    compute::read_small_json,
    extract::PathOf,
    idempotency::{IdempotencyKey, idempotent},
    state::AppState,
};
use crate::{
    api::{
        jobs::purge::{PurgeBody, PurgeRequestBody},
        json::{value::read_json, writer::text_of},
        problem::Problem,
    },
    jobs::{Answer, Purge, Scope, Stored},
};

/// Lines that wait for the client.
const LINES: usize = 8;

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(archive_job)).routes(routes!(purge_job))
}

/// Download everything that is stored of a job: nodes, fits, records, streams, events, and the
/// audit.
///
/// JSON lines in the format of `flankfit export` and `flankfit import`. The bytes are the same
/// until the job changes. A file without its last line, `{"archive":…}`, is incomplete.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/archive", operation_id = "archive_job", tag = "jobs",
    params(("job_id" = Uuid, Path)),
    responses(
        (status = 200, description = "The archive.", content((String = "application/jsonl"))),
        (status = 403, description = "The caller lacks a scope: `admin` or `read`.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn archive_job(state: CallerState, PathOf(job): PathOf<Uuid>) -> Result<Response, Problem> {
    if !state.principal.scopes.contains(Scope::Read) {
        return Err(Problem::lacking_scope(
            "An archive contains everything of a job, so it needs the scope `read` too.",
        ));
    }
    state.jobs.job(job).await?;
    let (lines, taken) = mpsc::channel(LINES);
    let jobs = state.jobs.clone();
    tokio::spawn(async move {
        let write = |line: String| {
            let sent = lines.send(Ok(Bytes::from(line)));
            async move { sent.await.map_err(|_| io::ErrorKind::BrokenPipe.into()) }
        };
        if let Err(error) = jobs.archive(job, write).await {
            tracing::warn!(%job, %error, "an archive was not sent to its end");
            // the client sees that the answer was cut off
            let _gone = lines.send(Err(io::Error::other(error))).await;
        }
    });
    let lines = stream::unfold(taken, |mut taken| async move { taken.recv().await.map(|line| (line, taken)) }).fuse();
    let mut response = Response::new(Body::from_stream(lines));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/jsonl"));
    if let Ok(name) = HeaderValue::from_str(&format!("attachment; filename=\"job-{job}.jsonl\"")) {
        headers.insert(header::CONTENT_DISPOSITION, name);
    }
    Ok(response)
}

/// Remove nodes, results, texts and names of a job, for good.
///
/// Removes personal names and frees space. The job's row, its numbers, times and figures, and its
/// audit are kept; requests for anything else are answered 410, and the job cannot be changed any
/// more. Download the archive of the job before, if the data may be wanted again, and verify its
/// audit: what is purged can be verified no more.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/purge", operation_id = "purge_job", tag = "jobs",
    params(("job_id" = Uuid, Path), IdempotencyKey),
    request_body(content = PurgeRequestBody, description = "Why."),
    responses(
        (status = 200, description = "The purge.", body = PurgeBody),
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
        let PurgeRequestBody { reason } = read_small_json(&state, payload, limit, read).await?;
        let keyed = key.map(|key| key.answered_by(purged));
        let new = state.jobs.purge(job, reason.into(), keyed).await?;
        Ok(purged(&new, Stored { number: 0, version: 0 }))
    })
    .await
}

fn purged(new: &Purge, _stored: Stored) -> Answer {
    Answer { status: 200, location: None, etag: None, body: text_of(&PurgeBody::from(new)).into_bytes() }
}
