//! `ETag` and `If-Match`. The tag of a job or an iteration is its version, which moves on with every change.

use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderValue, header, request::Parts},
};

use super::state::AppState;
use crate::{api::problem::Problem, jobs::Precondition};

/// The version as an entity tag.
pub fn etag(version: u64) -> String {
    format!("\"{version}\"")
}

/// Puts the tag of a version into an answer.
pub fn set_etag(headers: &mut HeaderMap, version: u64) {
    if let Ok(value) = HeaderValue::from_str(&etag(version)) {
        headers.insert(header::ETAG, value);
    }
}

/// What the request's `If-Match` says the caller has seen.
///
/// `*` and no header ask for nothing (a resource that does not exist is a 404 anyway). Weak tags and tags that were never given
/// match no version, so they lead to a 412.
pub struct IfMatch(pub Precondition);

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
            let inside = tag.strip_prefix('"').and_then(|tag| tag.strip_suffix('"')).unwrap_or(tag);
            seen.extend(inside.parse::<u64>());
        }
    }
    if given { Precondition::AnyOf(seen) } else { Precondition::None }
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
        assert_eq!(of(&["W/\"3\""]), Precondition::AnyOf(vec![]));
        assert_eq!(of(&["\"something\""]), Precondition::AnyOf(vec![]));
    }
}
