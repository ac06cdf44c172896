//! Server-sent events (`text/event-stream`).

use std::convert::Infallible;

use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::{Stream, StreamExt};

use super::prelude::*;

/// Returns events as an answer that no proxy keeps back; after so long a silence a comment shows
/// that the connection lives.
pub fn response(events: impl Stream<Item = Event> + Send + 'static, silence: Duration) -> Response {
    let keep_alive = KeepAlive::new().interval(silence).text("quiet");
    let mut response = Sse::new(events.map(Ok::<_, Infallible>).fuse()).keep_alive(keep_alive).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert(HeaderName::from_static("x-accel-buffering"), HeaderValue::from_static("no"));
    response
}
