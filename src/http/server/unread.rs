//! Bodies of requests that were answered before they had been read.
//!
//! The rest of such a body precedes the next request on the connection. A short rest is read and
//! forgotten; else the answer says that the connection closes, so that no client or proxy sends its
//! next request into it.

use std::{
    pin::Pin,
    sync::{Arc, Mutex, PoisonError},
    task::{Context, Poll, ready},
    time::Duration,
};

use axum::body::{Body, Bytes, HttpBody};
use http_body_util::BodyExt;
use hyper::body::{Frame, Incoming, SizeHint};

/// Longest rest that is read.
const SHORT: u64 = 64 << 10;
/// How long it may take to come.
const DRAIN_TIME: Duration = Duration::from_millis(500);

/// The unread rest of a request's body, once the body has been dropped.
#[derive(Clone, Default)]
pub struct Unread(Arc<Mutex<Option<Incoming>>>);

/// A body that leaves its unread rest behind.
struct TrackedBody {
    body: Option<Incoming>,
    rest: Unread,
}

impl Unread {
    /// The body for the handler, and where its rest will be.
    pub fn track(body: Incoming) -> (Body, Unread) {
        let rest = Unread::default();
        if body.is_end_stream() {
            return (Body::new(body), rest);
        }
        (Body::new(TrackedBody { body: Some(body), rest: rest.clone() }), rest)
    }

    /// Whether the connection can go on with its next request, after a short rest has been read.
    /// `expects`: the client has asked whether it may send the body at all, and has no response
    /// yet.
    pub async fn can_go_on(&self, expects: bool) -> bool {
        let left = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(mut body) = left else { return true };
        if expects || body.size_hint().upper().is_none_or(|upper| upper > SHORT) {
            return false;
        }
        let drained = async { while let Some(Ok(_)) = body.frame().await {} };
        tokio::time::timeout(DRAIN_TIME, drained).await.is_ok() && body.is_end_stream()
    }
}

impl HttpBody for TrackedBody {
    type Data = Bytes;
    type Error = hyper::Error;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, hyper::Error>>> {
        let Some(body) = &mut self.body else { return Poll::Ready(None) };
        let frame = ready!(Pin::new(body).poll_frame(cx));
        // of a body without a length only this says that it has ended
        if !matches!(frame, Some(Ok(_))) {
            self.body = None;
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.body.as_ref().is_none_or(HttpBody::is_end_stream)
    }

    fn size_hint(&self) -> SizeHint {
        self.body.as_ref().map_or_else(SizeHint::default, HttpBody::size_hint)
    }
}

impl Drop for TrackedBody {
    fn drop(&mut self) {
        if let Some(body) = self.body.take().filter(|body| !body.is_end_stream()) {
            *self.rest.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(body);
        }
    }
}
