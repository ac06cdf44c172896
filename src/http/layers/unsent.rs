//! Answers that wait for their clients are charged to the budget until they are sent.

use std::{
    pin::Pin,
    task::{Context, Poll, ready},
};

use axum::{body::HttpBody, extract::State};
use hyper::body::{Frame, SizeHint};

use super::prelude::*;
use crate::usecases::budget::Permit;

/// Answers that are shorter are not charged.
const SHORT: u64 = 4 << 10;

/// The permit of an answer that is charged already.
#[derive(Clone)]
struct ResponsePermit(Arc<Permit>);

/// An answer with the permit for what it was made of.
pub fn with_permit(mut response: Response, permit: Permit) -> Response {
    response.extensions_mut().insert(ResponsePermit(Arc::new(permit)));
    response
}

/// Charges an answer whose length is known. (Others are made piece by piece as they are sent.)
pub async fn charge(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let ready = response.extensions_mut().remove().and_then(|ResponsePermit(permit)| Arc::into_inner(permit));
    let Some(length) = response.body().size_hint().exact().filter(|length| *length >= SHORT) else { return response };
    let ready = ready.unwrap_or_else(|| state.budget.permit());
    match permit(ready, response.status(), length as usize) {
        Ok(permit) => response.map(|body| Body::new(PermitBody { body, permit: Some(permit) })),
        Err(refused) => refused,
    }
}

/// A response about stored data is sent even above the limit.
fn permit(mut permit: Permit, status: StatusCode, length: usize) -> Result<Permit, Response> {
    permit.shrink_to(length);
    let length = length - permit.bytes();
    if status == StatusCode::CREATED {
        permit.force(length);
    } else {
        permit.grow(length).map_err(IntoResponse::into_response)?;
    }
    Ok(permit)
}

/// A body whose bytes hold the permit, also when they wait for the connection.
struct PermitBody {
    body: Body,
    permit: Option<Permit>,
}

impl HttpBody for PermitBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let frame = ready!(Pin::new(&mut self.body).poll_frame(cx));
        // a body of known length is one piece
        let guarded = |bytes: Bytes| match self.permit.take() {
            Some(permit) => permit.guard(bytes),
            None => bytes,
        };
        Poll::Ready(frame.map(|frame| frame.map(|frame| frame.map_data(guarded))))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
