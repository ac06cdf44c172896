//! Old jobs: archived, and purged.

use std::io;

use axum::body::Body;
use futures_util::{StreamExt, stream};
use tokio::{
    sync::mpsc,
    time::{Instant, timeout, timeout_at},
};

use super::prelude::*;
use crate::{
    api::jobs::purge::{PurgeBody, PurgeRequestBody},
    http::layers::chunked::PIECE,
    jobs::{Purge, Scope},
};

/// Pieces of lines that wait for the client.
const PIECES: usize = 8;
/// Bytes a second that a client takes at least, on average.
const SLOWEST: f64 = 65_536.0;

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(archive_job)).routes(routes!(purge_job))
}

/// Download the archive of a job
///
/// The archive has everything stored of the job: nodes, fits, records, streams, events, and the
/// audit. It consists of JSON lines in the format of `flankfit export` and `flankfit import`. The
/// bytes are the same until the job changes. A file without its last line, `{"archive":…}`, is
/// incomplete.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/archive", operation_id = "archive_job", tag = "jobs",
    responses(
        (status = 200, description = "The archive.", content((String = "application/jsonl"))),
        (status = 403, description = "The caller lacks a scope: `admin` or `read`.")
    )
)]
async fn archive_job(state: CallerState, PathOf(job): PathOf<Uuid>) -> Result<Response, Problem> {
    if !state.principal.scopes.contains(Scope::Read) {
        return Err(Problem::lacking_scope(
            "An archive contains everything of a job, so it needs the scope `read` too.",
        ));
    }
    state.jobs.job(job).await?;
    let place = state.jobs.archiving().ok_or_else(|| {
        Problem::new(ProblemCode::Overloaded, "Other archives are being sent; try again in a moment.").retry_after(5)
    })?;
    let (pieces, taken) = mpsc::channel(PIECES);
    let (jobs, patience) = (state.jobs.clone(), state.settings.write_timeout());
    let mut end = Instant::now() + patience;
    tokio::spawn(async move {
        let write = |line: String| {
            if pieces.capacity() == PIECES {
                // the client has taken everything: it need not make up for the time of the database
                end = Instant::now() + patience;
            }
            end += Duration::from_secs_f64(line.len() as f64 / SLOWEST);
            send(&pieces, line.into(), patience, end)
        };
        let written = jobs.archive(place, job, write).await;
        match written {
            Ok(()) => drop(timeout(patience, pieces.send(None)).await),
            Err(error) => tracing::warn!(%job, %error, "an archive was not sent to its end"),
        }
    });
    let pieces = stream::unfold(Some(taken), |taken| async move {
        let mut taken = taken?;
        match taken.recv().await {
            Some(Some(piece)) => Some((Ok(piece), Some(taken))),
            Some(None) => None,
            // the connection ends without the end of the answer, so that no reader takes it for
            // whole
            None => Some((Err(io::Error::other("the archive is cut off")), None)),
        }
    });
    let mut response = Response::new(Body::from_stream(pieces.fuse()));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/jsonl"));
    if let Ok(name) = HeaderValue::from_str(&format!("attachment; filename=\"job-{job}.jsonl\"")) {
        headers.insert(header::CONTENT_DISPOSITION, name);
    }
    Ok(response)
}

/// Sends a line piece by piece. A client that takes too long for one, or for all up to now, holds
/// a place and a connection to the database no longer.
async fn send(to: &mpsc::Sender<Option<Bytes>>, mut line: Bytes, patience: Duration, end: Instant) -> io::Result<()> {
    while !line.is_empty() {
        let piece = line.split_to(line.len().min(PIECE));
        let sent = timeout_at(end.min(Instant::now() + patience), to.send(Some(piece))).await;
        sent.map_err(|_| io::ErrorKind::TimedOut)?.map_err(|_| io::ErrorKind::BrokenPipe)?;
    }
    Ok(())
}

/// Purge a job
///
/// Removes nodes, results, texts and names for good, and frees space. The job's row, its numbers,
/// times and gear figures, and its audit are kept. Requests for anything else get status 410, and
/// the job cannot be changed any more. First download the archive of the job, if the data may be
/// needed again, and verify its audit: purged data cannot be verified.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/purge", operation_id = "purge_job", tag = "jobs",
    params(IdempotencyKey),
    request_body(content = PurgeRequestBody, description = "Reason of the purge."),
    responses(
        (status = 200, description = "The purge.", body = PurgeBody),
        (status = 410, description = "The job is already purged.")
    )
)]
async fn purge_job(PathOf(job): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let PurgeRequestBody { reason } = read_small::<PurgeRequestBody>(&state, payload).await?;
        let keyed = key.map(|key| key.answered_by(purged));
        let new = state.jobs.purge(job, reason.into(), keyed).await?;
        Ok(purged(&new, Stored { number: 0, version: 0 }))
    })
    .await
}

fn purged(new: &Purge, _stored: Stored) -> Answer {
    Answer::ok(text_of(&PurgeBody::from(new)).into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_client_that_takes_nothing_is_not_waited_for() {
        let (pieces, mut taken) = mpsc::channel(1);
        let line = Bytes::from(vec![b'x'; PIECE + 1]);
        let (soon, late) = (Duration::from_millis(20), Instant::now() + Duration::from_secs(3600));
        let sent = send(&pieces, line.clone(), soon, late).await;
        assert_eq!(sent.unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert_eq!(taken.recv().await.unwrap().unwrap().len(), PIECE);
        // nor is one that takes something in time, and all too late
        let sent = send(&pieces, line.clone(), Duration::from_secs(3600), Instant::now() + soon).await;
        assert_eq!(sent.unwrap_err().kind(), io::ErrorKind::TimedOut);
        drop(taken);
        assert_eq!(send(&pieces, line, soon, late).await.unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
