//! `ETag`, `If-Match` and `If-None-Match`. The tag of an iteration is its version, which moves on
//! with every change; that of a job has its status too, which changes with decisions.

use axum::{extract::FromRequestParts, http::request::Parts};
use sha2::{Digest, Sha256};
use utoipa::IntoParams;

use super::prelude::*;
use crate::jobs::{Job, JobStatus, Precondition, rows::to_hex};

/// The version as an entity tag.
pub fn etag(version: u64) -> String {
    format!("\"{version}\"")
}

/// Returns the entity tag of a job.
pub fn job_etag(job: &Job) -> String {
    format!("\"{}-{}\"", job.version, job.status.name())
}

/// Puts the tag of a version into an answer.
pub fn set_etag(headers: &mut HeaderMap, version: u64) {
    set_tag(headers, &etag(version));
}

/// Puts a tag into an answer.
pub fn set_tag(headers: &mut HeaderMap, tag: &str) {
    if let Ok(value) = HeaderValue::from_str(tag) {
        headers.insert(header::ETAG, value);
    }
}

/// The tag of bytes that have no version.
pub fn content_tag(bytes: &[u8]) -> Option<HeaderValue> {
    let digest = Sha256::digest(bytes);
    HeaderValue::from_str(&format!("\"{}\"", to_hex(&digest[..16]))).ok()
}

/// Versions that the caller has seen, by the header `If-Match`.
///
/// `*` and no header ask for nothing (a resource that does not exist is a 404 anyway). Weak tags
/// and tags that were never given match no version, so they lead to a 412.
#[derive(IntoParams)]
#[into_params(names("If-Match"), parameter_in = Header)]
pub struct IfMatch(
    /// Only if the resource is still at this ETag.
    #[param(value_type = Option<String>)]
    pub Precondition,
);

impl FromRequestParts<AppState> for IfMatch {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _state: &AppState) -> Result<Self, Problem> {
        Ok(IfMatch(precondition(&parts.headers)))
    }
}

fn precondition(headers: &HeaderMap) -> Precondition {
    let mut seen = Vec::new();
    let mut given = false;
    for value in headers.get_all(header::IF_MATCH) {
        given = true;
        for tag in value.to_str().unwrap_or_default().split(',').map(str::trim) {
            if tag == "*" {
                return Precondition::None;
            }
            let inside = tag.strip_prefix('"').and_then(|tag| tag.strip_suffix('"'));
            seen.extend(inside.and_then(version_of));
        }
    }
    if given { Precondition::AnyOf(seen) } else { Precondition::None }
}

/// Returns the version in a tag. The status of a job is left aside: no request changes it by
/// itself.
fn version_of(tag: &str) -> Option<u64> {
    let (digits, status) = tag.split_once('-').map_or((tag, None), |(digits, status)| (digits, Some(status)));
    // a tag is compared as a text: `"01"` was never given
    let version: u64 = digits.parse().ok().filter(|version: &u64| version.to_string() == digits)?;
    status.is_none_or(|status| JobStatus::named(status).is_some()).then_some(version)
}

/// Answers 304 without a body where a GET's `If-None-Match` has the tag of what would be answered.
pub async fn not_modified(request: Request, next: Next) -> Response {
    let reads = matches!(*request.method(), Method::GET | Method::HEAD);
    let seen = if reads { tags(request.headers()) } else { Vec::new() };
    let mut response = next.run(request).await;
    if response.status() != StatusCode::OK || !is_match(&seen, response.headers().get(header::ETAG)) {
        return response;
    }
    *response.status_mut() = StatusCode::NOT_MODIFIED;
    // What the answer itself would say; an empty one is not compressed, so nobody else says it (RFC
    // 9110, 15.4.5).
    response.headers_mut().append(header::VARY, HeaderValue::from_static("accept-encoding"));
    *response.body_mut() = Body::empty();
    for name in [header::CONTENT_TYPE, header::CONTENT_LENGTH, header::CONTENT_ENCODING, header::CONTENT_DISPOSITION] {
        response.headers_mut().remove(name);
    }
    response
}

/// The values of `If-None-Match`.
fn tags(headers: &HeaderMap) -> Vec<HeaderValue> {
    headers.get_all(header::IF_NONE_MATCH).iter().cloned().collect()
}

/// Whether a tag is among the seen ones, by weak comparison (RFC 9110, 8.8.3.2).
fn is_match(seen: &[HeaderValue], tag: Option<&HeaderValue>) -> bool {
    let Some(tag) = tag.and_then(|tag| tag.to_str().ok()) else { return false };
    let opaque = |tag: &str| tag.strip_prefix("W/").unwrap_or(tag).to_owned();
    let wanted = opaque(tag);
    let lists = seen.iter().filter_map(|value| value.to_str().ok());
    lists.flat_map(split_tags).any(|seen| seen == "*" || opaque(seen) == wanted)
}

/// The members of a list of tags. Tags may have commas between their quotes.
fn split_tags(list: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    list.split(move |c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    })
    .map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[&'static str]) -> Precondition {
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append(header::IF_MATCH, HeaderValue::from_static(value));
        }
        precondition(&headers)
    }

    #[test]
    fn tags_are_read_and_strange_ones_match_nothing() {
        assert_eq!(of(&[]), Precondition::None);
        assert_eq!(of(&["*"]), Precondition::None);
        assert_eq!(of(&["\"3\""]), Precondition::AnyOf(vec![3]));
        assert_eq!(of(&["\"3\", \"4\"", "\"5\""]), Precondition::AnyOf(vec![3, 4, 5]));
        assert_eq!(of(&["\"3-open\""]), Precondition::AnyOf(vec![3]));
        assert_eq!(of(&["\"3-else\"", "\"3-\""]), Precondition::AnyOf(vec![]));
        assert_eq!(of(&["W/\"3\""]), Precondition::AnyOf(vec![]));
        assert_eq!(of(&["\"something\""]), Precondition::AnyOf(vec![]));
        assert_eq!(of(&["\"01\"", "\"+1\"", "1"]), Precondition::AnyOf(vec![]), "these were never given");
    }

    #[test]
    fn seen_tags_are_compared_weakly() {
        let seen = |values: &[&'static str], tag: &'static str| {
            let values: Vec<_> = values.iter().map(|value| HeaderValue::from_static(value)).collect();
            is_match(&values, Some(&HeaderValue::from_static(tag)))
        };
        assert!(seen(&["\"3\""], "\"3\""));
        assert!(seen(&["W/\"3\""], "\"3\"") && seen(&["\"3\""], "W/\"3\""));
        assert!(seen(&["\"1\", \"a,b\"", "\"3\""], "\"3\"") && seen(&["\"1\",\"a,b\""], "\"a,b\""));
        assert!(seen(&["*"], "\"3\""));
        assert!(!seen(&[], "\"3\"") && !seen(&["\"4\"", ""], "\"3\"") && !seen(&["3"], "\"3\""));
        assert!(!is_match(&[HeaderValue::from_static("*")], None), "nothing that has a tag");
    }
}
