//! Problems as HTTP responses.

use super::prelude::*;
use crate::{api::json::writer::text_of, pool::PoolError};

impl IntoResponse for Problem {
    /// The problem also travels as an extension, for `layers::observe` to add the request id and
    /// log the cause.
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = text_of(&self);
        let mut response = (status, body).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if let Some(seconds) = self.retry_after {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        if let Some(challenge) = self.challenge {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static(challenge));
        }
        response.extensions_mut().insert(self);
        response
    }
}

impl From<PoolError> for Problem {
    fn from(error: PoolError) -> Self {
        match error {
            PoolError::Full => {
                telemetry::record_shed("queue");
                Problem::new(
                    ProblemCode::Overloaded,
                    "Every worker is busy and the queue is full; try again in a moment.",
                )
                .retry_after(1)
            }
            PoolError::Cancelled | PoolError::Stopped => {
                Problem::new(ProblemCode::Overloaded, "The server is stopping; try again in a moment.").retry_after(1)
            }
            PoolError::Lost => Problem::internal(error),
        }
    }
}
