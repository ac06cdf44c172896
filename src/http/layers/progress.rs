//! Answers with progress (`Accept: text/event-stream`) to the operations for which the document
//! offers them ([`crate::http::openapi::progress`]).
//!
//! The handler is that of the plain request. Its work is done under one handle, which knows how far
//! it is; the last event is its answer. When the client closes the connection, the handler is
//! dropped, which cancels its work.

use std::{future, pin::Pin};

use axum::{
    RequestPartsExt,
    body::{self},
    response::sse::Event,
};
use futures_util::stream;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval, timeout};
use tracing::Instrument as _;

use super::prelude::*;
use super::{
    body::Payload,
    idempotency::REPLAYED,
    observe::{self, LateReport},
    sse,
};
use crate::{
    api::{json::writer::text_of, progress::ProgressBody},
    http::caller_state::CallerState,
    pool::{self, Handle},
    usecases::budget::Permit,
};

/// The media type of events.
pub const EVENT_STREAM: &str = "text/event-stream";

type Answer = Pin<Box<dyn Future<Output = Response> + Send>>;

/// Answers a request with progress. A problem that is found at once is that of the plain request.
pub async fn respond(state: AppState, request: Request, next: Next) -> Response {
    begin(state, request, next).await.unwrap_or_else(IntoResponse::into_response)
}

async fn begin(state: AppState, request: Request, next: Next) -> Result<Response, Problem> {
    let (mut parts, body) = request.into_parts();
    let caller = parts.extract_with_state::<CallerState, _>(&state).await?;
    // many clients read nothing before they have sent everything
    let whole = Request::from_parts(parts.clone(), body);
    let bytes = Payload::collect(whole, &state, state.settings.body_limit).await?.bytes();
    // a body of the declared length is not copied
    parts.headers.remove(header::TRANSFER_ENCODING);
    parts.headers.insert(header::CONTENT_LENGTH, bytes.len().into());
    parts.headers.remove(header::ACCEPT);
    let (handle, begun) = (Handle::new(), Instant::now());
    let handling = pool::under(handle.clone(), next.run(Request::from_parts(parts, Body::from(bytes))));
    let handling = pool::on_behalf_of(pool::party(), handling);
    let mut answer: Answer = Box::pin(observe::in_time(state.settings.progress_timeout, handling).in_current_span());
    let look = state.settings.pace.look.min(state.settings.request_timeout() / 2);
    let mut replayed = None;
    match timeout(look, &mut answer).await {
        Ok(response) if response.extensions().get::<Problem>().is_some() => return Ok(response),
        Ok(response) => {
            replayed = response.headers().get(&REPLAYED).cloned();
            answer = Box::pin(future::ready(response));
        }
        Err(_elapsed) => {}
    }
    let mut looks = interval(look.max(Duration::from_millis(1)));
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let (refused, report) = (caller.refused(), LateReport::default());
    let work = Work { caller, handle, begun, answer, refused, looks, reported: None, report: report.clone() };
    let events = stream::unfold(Stage::Working(Box::new(work)), |stage| async move {
        match stage {
            Stage::Working(work) => Some(work.next().await),
            Stage::Sent(_permit) => None,
        }
    });
    let mut response = sse::response(events, state.settings.pace.comment);
    response.extensions_mut().insert(report);
    response.headers_mut().extend(replayed.map(|replayed| (REPLAYED.clone(), replayed)));
    Ok(response)
}

/// How far the events are.
enum Stage {
    Working(Box<Work>),
    /// The last event has been handed over; the permit is for its text.
    Sent(Permit),
}

/// A request that is being worked on.
struct Work {
    caller: CallerState,
    handle: Handle,
    begun: Instant,
    answer: Answer,
    /// The problem of the caller as soon as it is not let in any more.
    refused: Pin<Box<dyn Future<Output = Problem> + Send>>,
    looks: Interval,
    reported: Option<f64>,
    report: LateReport,
}

impl Work {
    /// The next event.
    async fn next(mut self: Box<Self>) -> (Event, Stage) {
        loop {
            let response = tokio::select! {
                biased;
                response = &mut self.answer => response,
                problem = &mut self.refused => problem.into_response(),
                _ = self.looks.tick() => {
                    let progress = self.handle.progress();
                    if self.reported.replace(progress) == Some(progress) {
                        continue;
                    }
                    let data = text_of(&ProgressBody::of(progress, self.begun.elapsed().as_secs_f64()));
                    return (Event::default().event("progress").data(data), Stage::Working(self));
                }
            };
            return self.last(response).await;
        }
    }

    /// The event of the answer.
    async fn last(self: Box<Self>, mut response: Response) -> (Event, Stage) {
        let mut permit = self.caller.budget.permit();
        let status = response.status().as_u16();
        let result = async {
            if let Some(problem) = response.extensions_mut().remove::<Problem>() {
                return Err(problem);
            }
            let bytes = body::to_bytes(response.into_body(), usize::MAX).await.map_err(Problem::internal)?;
            // what was computed is sent, even above the limit
            permit.force(bytes.len());
            let text = str::from_utf8(&bytes).map_err(Problem::internal)?;
            Ok(Event::default().event("result").data(text))
        };
        let (status, event) = result.await.map(|event| (status, event)).unwrap_or_else(|problem| {
            let id = self.caller.principal.caller.origin.request_id.as_deref();
            let problem = observe::named(problem, id.unwrap_or_default());
            (problem.status, Event::default().event("problem").data(text_of(&problem)))
        });
        self.report.end(status);
        (event, Stage::Sent(permit))
    }
}
