//! `GET /v1/jobs/{job_id}/events`: what happens to a job, as server-sent events.
//!
//! Events are read from the store in pages, after the last one sent: a client that reads slowly
//! holds one page, whatever happens meanwhile, and one that comes back with `Last-Event-ID` goes on
//! where it was. Being woken only says that it is worth looking.

use std::{pin::Pin, time::Duration};

use axum::{
    body::{Body, Bytes},
    http::{HeaderMap, HeaderName, HeaderValue, header},
    response::Response,
};
use futures_util::{FutureExt, StreamExt, stream};
use serde::Deserialize;
use tokio::sync::watch;
use utoipa::IntoParams;
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use crate::{
    api::{
        faults::Faults,
        jobs::events::{self, JobEventBody},
        problem::{Problem, ProblemCode},
    },
    http::{
        caller_state::CallerState,
        extract::{PathOf, QueryOf},
        shutdown::OpenConnection,
        state::AppState,
    },
    jobs::RepositoryError,
};

/// Events read at a time.
const PAGE: u32 = 256;
/// After so long without an event a comment shows that the connection lives.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// The first line: how long a client waits before it comes back, in milliseconds.
const RETRY_LINE: &str = "retry: 2000\n\n";
static LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_job_events))
}

/// What is said of an id of another form.
fn not_an_event_id(from_header: bool) -> Problem {
    const FORM: &str = "the last event id is the `id` of an event of this job, or `latest`";
    match from_header {
        true => Problem::new(ProblemCode::MalformedRequest, format!("Last-Event-ID: {FORM}.")),
        false => Problem::invalid(Faults::one("/last_event_id", FORM)),
    }
}

#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct EventsQuery {
    /// As the header `Last-Event-ID`, for clients that cannot set it; `latest` begins with what
    /// happens from now on.
    last_event_id: Option<String>,
}

/// Sends what happens to a job: `iteration`, `fit`, `decision`, `stream`; from its beginning, or
/// after `Last-Event-ID`.
///
/// As server-sent events; the connection stays open, and a comment line is sent now and then to
/// keep it so. The id of each event is its number within the job, from which a client that lost its
/// connection goes on.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/events", operation_id = "get_job_events", tag = "jobs",
    params(
        ("job_id" = Uuid, Path),
        ("Last-Event-ID" = Option<String>, Header, description = "The id of the last event seen: sending goes on after \
            it.", pattern = "^(latest|[0-9]{1,18})?$"),
        EventsQuery
    ),
    responses(
        (status = 200, description = "Server-sent events without end; `data` of each is a JobEvent.",
            body = JobEventBody, content_type = "text/event-stream"),
        (status = 400, description = "`Last-Event-ID` is not the id of an event.", body = Problem,
            content_type = "application/problem+json"),
        (status = 422, description = "The query has something else in it, or `last_event_id` is not the id of an \
            event.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn get_job_events(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    headers: HeaderMap,
    QueryOf(query): QueryOf<EventsQuery>,
) -> Result<Response, Problem> {
    let last = state.jobs.last_event(job).await?;
    // the header is newer than the address it came back to
    let from_header = headers.contains_key(&LAST_EVENT_ID);
    let given = match headers.get(&LAST_EVENT_ID) {
        Some(value) => Some(value.to_str().unwrap_or("?").trim().to_owned()),
        None => query.last_event_id,
    };
    let after = match given.as_deref() {
        None | Some("") => 0,
        Some("latest") => last,
        // An id beyond the last event is of another database, say of one before a backup was
        // restored: everything is sent anew.
        Some(text) => {
            text.parse().map(|id| if id > last { 0 } else { id }).map_err(|_| not_an_event_id(from_header))?
        }
    };
    let listener = Listener {
        job,
        after,
        changes: state.jobs.listen(job),
        stopped: Box::pin(state.shutdown.begun()),
        refused: state.refused(),
        _open: state.shutdown.register("events"),
        begun: false,
        state,
    };
    let chunks = stream::unfold(listener, |mut listener| async move {
        let chunk = listener.next().await?;
        Some((Ok::<_, std::convert::Infallible>(chunk), listener))
    });
    let mut response = Response::new(Body::from_stream(chunks.fuse()));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/event-stream"));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    // proxies that collect answers would keep events back
    headers.insert(HeaderName::from_static("x-accel-buffering"), HeaderValue::from_static("no"));
    Ok(response)
}

struct Listener {
    state: CallerState,
    job: Uuid,
    after: u64,
    changes: watch::Receiver<()>,
    stopped: Pin<Box<dyn Future<Output = ()> + Send>>,
    /// Whoever listens is not let in any more.
    refused: Pin<Box<dyn Future<Output = ()> + Send>>,
    _open: OpenConnection,
    begun: bool,
}

impl Listener {
    /// What is sent next; `None` ends the answer (a client comes back by itself).
    async fn next(&mut self) -> Option<Bytes> {
        if !std::mem::replace(&mut self.begun, true) {
            return Some(Bytes::from_static(RETRY_LINE.as_bytes()));
        }
        let mut quiet = false;
        loop {
            // also where there is always something to send
            if (&mut self.refused).now_or_never().is_some() {
                return None;
            }
            // seen before looking, so that what happens while looking wakes again
            self.changes.borrow_and_update();
            match self.state.jobs.events(self.job, self.after, PAGE).await {
                Ok(page) => {
                    if let Some(last) = page.last().map(|event| event.number) {
                        self.after = last;
                        return Some(events::to_text(page).into());
                    }
                }
                Err(error) => return self.end(&error),
            }
            if quiet {
                return match self.state.jobs.last_event(self.job).await {
                    Ok(_) => Some(Bytes::from_static(b": quiet\n\n")),
                    Err(error) => self.end(&error),
                };
            }
            tokio::select! {
                _ = self.changes.changed() => {}
                () = &mut self.stopped => return None,
                () = &mut self.refused => return None,
                () = tokio::time::sleep(KEEP_ALIVE) => quiet = true,
            }
        }
    }

    fn end(&self, error: &RepositoryError) -> Option<Bytes> {
        if !matches!(error, RepositoryError::NotFound(_)) {
            tracing::warn!(%error, job = %self.job, "event stream closed after a store error");
        }
        None
    }
}
