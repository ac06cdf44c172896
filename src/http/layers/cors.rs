//! Requests of web pages that come from elsewhere: only from origins that the settings name, and
//! never with cookies.

use tower_http::cors::CorsLayer;

use super::prelude::*;
use super::{
    idempotency::REPLAYED,
    observe::{REQUEST_ID, TRACEPARENT, TRACESTATE},
};
use crate::config::Origin;

/// Time for which a browser may keep the response to a preflight.
const PREFLIGHT_MAX_AGE: Duration = Duration::from_secs(600);

/// The layer for these origins; none where there are none. It responds to preflights itself, so
/// they need no key.
pub fn layer(origins: &[Origin]) -> Option<CorsLayer> {
    if origins.is_empty() {
        return None;
    }
    let name = HeaderName::from_static;
    // an origin that was read is of ASCII
    let origins: Vec<_> = origins.iter().filter_map(|origin| HeaderValue::from_str(origin.as_str()).ok()).collect();
    let layer = CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::PUT, Method::PATCH, Method::DELETE])
        .allow_headers([
            header::CONTENT_TYPE,
            header::CONTENT_ENCODING,
            header::AUTHORIZATION,
            name("x-api-key"),
            name("idempotency-key"),
            header::IF_MATCH,
            header::IF_NONE_MATCH,
            name("last-event-id"),
            REQUEST_ID.clone(),
            TRACEPARENT.clone(),
            TRACESTATE.clone(),
        ])
        .expose_headers([
            header::ETAG,
            header::LOCATION,
            header::RETRY_AFTER,
            header::ALLOW,
            header::CONTENT_DISPOSITION,
            REPLAYED.clone(),
            REQUEST_ID.clone(),
            TRACEPARENT.clone(),
        ])
        .vary([header::ORIGIN])
        .max_age(PREFLIGHT_MAX_AGE);
    Some(layer)
}
