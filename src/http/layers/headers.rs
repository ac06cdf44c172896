//! Headers that every answer carries: what may be cached, what a browser may make of it.

use super::prelude::*;

/// Answers that belong to one request.
const NO_STORE: HeaderValue = HeaderValue::from_static("no-store");
/// Answers with a tag: kept by the client alone, and asked about before each use.
const PRIVATE_NO_CACHE: HeaderValue = HeaderValue::from_static("private, no-cache");
/// Pages load nothing from elsewhere and stand in no frame; the dashboard has a policy of its own.
/// The documentation sets styles from its script, and has pictures in them.
const PAGE_POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
     connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
);
/// All else is no page, whatever a browser is made to take it for.
const DATA_POLICY: HeaderValue = HeaderValue::from_static("default-src 'none'; frame-ancestors 'none'");
static REFERRER_POLICY: HeaderName = HeaderName::from_static("referrer-policy");

/// Adds them where the answer has not its own.
pub fn protect(response: &mut Response, method: &Method) {
    let reads = matches!(*method, Method::GET | Method::HEAD);
    let status = response.status();
    complete(response.headers_mut(), reads, status);
}

fn complete(headers: &mut HeaderMap, reads: bool, status: StatusCode) {
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(&REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    let good = status.is_success() || status == StatusCode::NOT_MODIFIED;
    if !headers.contains_key(header::CACHE_CONTROL) && status != StatusCode::SWITCHING_PROTOCOLS {
        let tagged = reads && good && headers.contains_key(header::ETAG);
        headers.insert(header::CACHE_CONTROL, if tagged { PRIVATE_NO_CACHE } else { NO_STORE });
    }
    let page = headers.get(header::CONTENT_TYPE).is_some_and(|media| media.as_bytes().starts_with(b"text/html"));
    if !headers.contains_key(header::CONTENT_SECURITY_POLICY) && status != StatusCode::SWITCHING_PROTOCOLS {
        headers.insert(header::CONTENT_SECURITY_POLICY, if page { PAGE_POLICY } else { DATA_POLICY });
    }
}

/// Leaves of the encodings that a client takes those that are offered. Where none is, or even the
/// answer as it is would not be taken, it goes as it is (RFC 9110, 12.5.3): a 406 after the work
/// has been done, and perhaps stored, would be useless.
pub fn offered_encodings(mut request: Request) -> Request {
    let headers = request.headers_mut();
    let values = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let taken: Vec<&str> =
        values.flat_map(|value| value.split(',')).map(str::trim).filter(|one| is_offered(one)).collect();
    let taken = (!taken.is_empty()).then(|| HeaderValue::try_from(taken.join(", ")).ok()).flatten();
    headers.remove(header::ACCEPT_ENCODING);
    headers.extend(taken.map(|taken| (header::ACCEPT_ENCODING, taken)));
    request
}

/// Whether, of the encodings that [`offered_encodings`] has left, there is gzip.
pub fn takes_gzip(headers: &HeaderMap) -> bool {
    let values = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|value| value.split(',')).any(|one| one.trim().to_ascii_lowercase().contains("gzip"))
}

fn is_offered(coding: &str) -> bool {
    let mut parts = coding.split(';').map(str::trim);
    let name = parts.next().unwrap_or_default();
    let refused = parts.any(|part| {
        let quality = part.strip_prefix("q=").or(part.strip_prefix("Q="));
        quality.is_some_and(|quality| quality.parse::<f64>().is_ok_and(|quality| quality <= 0.0))
    });
    ["gzip", "x-gzip", "zstd"].iter().any(|offered| name.eq_ignore_ascii_case(offered)) && !refused
}
