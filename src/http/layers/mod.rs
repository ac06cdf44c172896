//! Layers around the handlers: checks of a request, extractors, response formats.

pub mod accept;
pub mod auth;
pub mod body;
pub mod chunked;
pub mod compute;
pub mod conditional;
pub mod content_encoding;
pub mod cors;
pub mod extract;
pub mod files;
pub mod form;
pub mod headers;
pub mod idempotency;
pub mod include;
pub mod job_query;
pub mod media_type;
pub mod multipart;
pub mod observe;
pub mod operations;
pub mod paging;
pub mod problem;
pub mod progress;
pub mod rates;
pub mod readiness;
pub mod sites;
pub mod sse;
pub mod unsent;

/// Names that most files of layers use.
mod prelude {
    pub use axum::{
        body::{Body, Bytes},
        extract::Request,
        http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header},
        middleware::Next,
        response::{IntoResponse, Response},
    };
    pub use std::{sync::Arc, time::Duration};

    pub use crate::{
        api::problem::{Problem, ProblemCode},
        http::state::AppState,
        telemetry,
    };
}
