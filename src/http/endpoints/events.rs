//! Events of a job (`GET /v1/jobs/{job_id}/events`) or of all jobs (`GET /v1/events`), as
//! server-sent events.
//!
//! Events are read from the store in pages, after the last one sent: a client that reads slowly
//! holds one page, whatever happens meanwhile, and one that comes back with `Last-Event-ID` goes on
//! where it was. A wake only means that new events may exist; listeners at the same position share
//! one read (`event_pages`).

use std::{fmt::Display, future, pin::Pin};

use axum::{http::HeaderName, response::sse::Event};
use futures_util::{FutureExt, StreamExt, stream};
use tokio::sync::watch;

use super::event_pages::PageKey;
use super::prelude::*;
use crate::{
    api::jobs::events::{self, JobEventBody},
    http::{layers::sse, shutdown::OpenConnection},
    jobs::{EventPlace, Jobs},
};

/// Events read at a time.
const PAGE: u32 = 256;
/// Time between two looks at a job, whatever happens: it may be there no more.
const JOB_LOOK: Duration = Duration::from_secs(15);
/// How long a client waits before it comes back.
const RETRY: Duration = Duration::from_secs(2);
static LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_job_events)).routes(routes!(get_events))
}

/// Time between two polls for listeners to all jobs: an event is sent once the transactions before
/// it have ended, which wakes nobody.
const LOOK: Duration = Duration::from_secs(1);

/// The id of the last event that a client has seen, where it says one.
struct Given {
    id: Option<String>,
    from_header: bool,
}

impl Given {
    fn of(headers: &HeaderMap, query: EventsQuery) -> Self {
        // the header is newer than the address it came back to
        match headers.get(&LAST_EVENT_ID) {
            Some(value) => Given { id: Some(value.to_str().unwrap_or("?").trim().to_owned()), from_header: true },
            None => Given { id: query.last_event_id, from_header: false },
        }
    }

    /// Returns the problem for an id of another form.
    fn refused(&self, of: &str) -> Problem {
        let form = format!("the last event id is the `id` of an event of {of}, or `latest`");
        match self.from_header {
            true => Problem::new(ProblemCode::MalformedRequest, format!("Last-Event-ID: {form}.")),
            false => Problem::invalid(Faults::one("/last_event_id", form)),
        }
    }
}

#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct EventsQuery {
    /// Same as the header `Last-Event-ID`, for clients that cannot set it; `latest` sends new
    /// events only.
    last_event_id: Option<String>,
}

/// Follow the events of a job
///
/// Sends server-sent events: `iteration`, `fit`, `decision`, `record`, `stream`, `job` (its own
/// data) and `purged`, from the first one, or after `Last-Event-ID`. The connection stays open, and
/// comment lines keep it alive. The id of each event is its number within the job. After a lost
/// connection a client continues from the last one.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/events", operation_id = "get_job_events", tag = "jobs",
    params(
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event received; events after it are \
            sent.", pattern = "^(latest|[0-9]{1,18})?$"),
        EventsQuery
    ),
    responses(
        (status = 200, description = "Server-sent events without end; `data` of each is a JobEvent.",
            body = JobEventBody, content_type = "text/event-stream"),
        (status = 400, description = "`Last-Event-ID` is not the id of an event."),
        (status = 422, description = "The query has an unknown parameter, or `last_event_id` is not the id of an \
            event.")
    )
)]
async fn get_job_events(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    headers: HeaderMap,
    QueryOf(query): QueryOf<EventsQuery>,
) -> Result<Response, Problem> {
    let last = state.jobs.last_event(job).await?;
    let given = Given::of(&headers, query);
    let after = match given.id.as_deref() {
        None | Some("") => 0,
        Some("latest") => last,
        // An id above the last event is of another database, say of one before a backup was
        // restored: everything is sent anew.
        Some(text) => text.parse().map(|id| if id > last { 0 } else { id }).map_err(|_| given.refused("this job"))?,
    };
    let changes = state.jobs.listen(job);
    Listener::answer(state, Subject { job: Some(job), after: of_job(after), missed: false }, changes)
}

/// Follow the events of all jobs
///
/// Sends new events of all jobs of the caller's tenant, or those after `Last-Event-ID`. Each has
/// its `job_id`; jobs that are created or deleted send `job`. The format is that of the events of a
/// job; the id of an event is its place among all. If the given id is older than seven days, or not
/// of this database (as after a restored backup), the first event is a `reset`, and only new events
/// follow: read the list of jobs again then.
#[utoipa::path(
    get, path = "/v1/events", operation_id = "get_events", tag = "jobs",
    params(
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event received; events after it are \
            sent.", pattern = "^(latest|[0-9]{1,19}-[0-9]{1,19})?$"),
        EventsQuery
    ),
    responses(
        (status = 200, description = "Server-sent events without end; `data` of each is a JobEvent.",
            body = JobEventBody, content_type = "text/event-stream"),
        (status = 400, description = "`Last-Event-ID` is not the id of an event."),
        (status = 422, description = "The query has an unknown parameter, or `last_event_id` is not the id of an \
            event.")
    )
)]
async fn get_events(
    state: CallerState,
    headers: HeaderMap,
    QueryOf(query): QueryOf<EventsQuery>,
) -> Result<Response, Problem> {
    // what happens between the two is heard of
    let changes = state.jobs.listen_to_all();
    let last = state.jobs.last_place().await?;
    let given = Given::of(&headers, query);
    let (after, missed) = match given.id.as_deref() {
        None | Some("" | "latest") => (last, false),
        Some(text) => {
            let asked = events::place_of(text).ok_or_else(|| given.refused("`/v1/events`"))?;
            let all = asked <= last && state.jobs.has_all_after(asked).await?;
            if all { (asked, false) } else { (last, true) }
        }
    };
    Listener::answer(state, Subject { job: None, after, missed }, changes)
}

/// Whose events are sent: those of one job or of all jobs, after a place.
struct Subject {
    job: Option<Uuid>,
    after: EventPlace,
    /// Whether events before the place are forgotten.
    missed: bool,
}

impl Subject {
    /// The next events, if there are any; they count as sent.
    async fn page(&mut self, state: &CallerState, wakes: u64) -> Result<Option<Arc<[Event]>>, RepositoryError> {
        let (jobs, tenant) = (&state.jobs, state.principal.caller.tenant.clone());
        if std::mem::take(&mut self.missed) {
            let reset = event(events::place_text(self.after), &JobEventBody::reset(jobs.now()));
            return Ok(Some(Arc::from([reset])));
        }
        let (job, after) = (self.job, self.after);
        let read = async {
            let page: Vec<_> = match job {
                Some(job) => {
                    let page = jobs.events(job, after.number, PAGE).await?.into_iter();
                    page.map(|one| (of_job(one.number), event(one.number, &one.into()))).collect()
                }
                None => {
                    let page = jobs.all_events(after, PAGE).await?.into_iter();
                    page.map(|one| (one.place, event(events::place_text(one.place), &one.into()))).collect()
                }
            };
            let last = page.last().map(|(place, _)| *place);
            Ok(last.map(|last| (page.into_iter().map(|(_, event)| event).collect(), last)))
        };
        let page = state.event_pages.get(PageKey { tenant, job, after }, wakes, read).await?;
        Ok(page.map(|(page, last)| {
            self.after = last;
            page
        }))
    }

    /// Refuses a job that is there no more.
    async fn check_exists(&self, jobs: &Jobs) -> Result<(), RepositoryError> {
        match self.job {
            Some(job) => jobs.last_event(job).await.map(drop),
            None => Ok(()),
        }
    }

    /// After how long it is worth looking without being woken.
    fn patience(&self) -> Duration {
        if self.job.is_some() { JOB_LOOK } else { LOOK }
    }
}

/// The place of a job's event among those of the job.
fn of_job(number: u64) -> EventPlace {
    EventPlace { change: 0, number }
}

struct Listener {
    state: CallerState,
    subject: Subject,
    changes: watch::Receiver<u64>,
    stopped: Pin<Box<dyn Future<Output = ()> + Send>>,
    /// Whoever listens is not let in any more.
    refused: Pin<Box<dyn Future<Output = Problem> + Send>>,
    _open: OpenConnection,
}

fn event(id: impl Display, body: &JobEventBody) -> Event {
    Event::default().id(id.to_string()).event(body.kind.name()).data(text_of(body))
}

impl Listener {
    /// The answer without end.
    fn answer(state: CallerState, subject: Subject, changes: watch::Receiver<u64>) -> Result<Response, Problem> {
        let listener = Listener {
            subject,
            changes,
            stopped: Box::pin(state.shutdown.begun()),
            refused: state.refused(),
            _open: state.shutdown.register("events", state.settings.max_connections)?,
            state,
        };
        let silence = listener.state.settings.pace.comment;
        let pages = stream::unfold(listener, |mut listener| async move { Some((listener.next().await?, listener)) });
        let events = pages.flat_map(|page| stream::iter((0..page.len()).map(move |at| page[at].clone())));
        let retry = stream::once(future::ready(Event::default().retry(RETRY)));
        Ok(sse::response(retry.chain(events), silence))
    }

    /// The events that are sent next; `None` ends the answer (a client comes back by itself).
    async fn next(&mut self) -> Option<Arc<[Event]>> {
        loop {
            // also where there is always something to send
            if (&mut self.refused).now_or_never().is_some() {
                return None;
            }
            // seen before looking, so that what happens while looking wakes again
            let wakes = *self.changes.borrow_and_update();
            match self.subject.page(&self.state, wakes).await {
                Ok(Some(page)) => return Some(page),
                Ok(None) => {}
                Err(error) => return self.end(&error),
            }
            tokio::select! {
                _ = self.changes.changed() => {}
                () = &mut self.stopped => return None,
                _ = &mut self.refused => return None,
                () = tokio::time::sleep(self.subject.patience()) => {
                    if let Err(error) = self.subject.check_exists(&self.state.jobs).await {
                        return self.end(&error);
                    }
                }
            }
        }
    }

    fn end(&self, error: &RepositoryError) -> Option<Arc<[Event]>> {
        if !matches!(error, RepositoryError::NotFound(_)) {
            tracing::warn!(%error, "event stream closed after a store error");
        }
        None
    }
}
