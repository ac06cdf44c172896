//! Extractors whose refusals are problems.

use axum::{
    extract::{
        FromRequest, FromRequestParts, Path, Query, RawPathParams, Request, path::ErrorKind, rejection::PathRejection,
    },
    http::request::Parts,
};
use serde::de::DeserializeOwned;
use uuid::Uuid;

use super::{body::Payload, compute::read_small_json, state::AppState};
use crate::api::{
    json::part::read_json,
    problem::{Problem, ProblemCode},
};

/// Path parameters; an id of the wrong form is an id that does not exist (404).
pub struct PathOf<T>(pub T);

impl<T: DeserializeOwned + Send> FromRequestParts<AppState> for PathOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        let unusual = match RawPathParams::from_request_parts(parts, state).await {
            Ok(segments) => segments.iter().find_map(|(name, segment)| unusual(name, segment)),
            Err(_) => None,
        };
        let Path(value) = Path::from_request_parts(parts, state)
            .await
            .map_err(|rejection| Problem::new(ProblemCode::NotFound, misread_path(rejection)))?;
        match unusual {
            None => Ok(PathOf(value)),
            Some(detail) => Err(Problem::new(ProblemCode::NotFound, detail)),
        }
    }
}

/// What to say of a segment that could be read but is not how a number or an id is written: a thing
/// has one address.
fn unusual(name: &str, segment: &str) -> Option<String> {
    let number = segment.parse::<u32>().ok().map(|number| number.to_string());
    let id = Uuid::try_parse(segment).ok().map(|id| id.to_string());
    let usual = number.filter(|_| name == "number").or(id)?;
    let differs = !usual.eq_ignore_ascii_case(segment);
    differs.then(|| format!("The path names nothing: its segment `{segment}`, {name}, is written `{usual}`."))
}

/// Which segment of the path is not what it must be. Segments are numbers or UUIDs.
fn misread_path(rejection: PathRejection) -> String {
    let PathRejection::FailedToDeserializePathParams(failed) = rejection else {
        return "The path names nothing.".to_owned();
    };
    let (name, value, form) = match failed.into_kind() {
        ErrorKind::DeserializeError { key, value, .. } => (Some(key), value, UUID),
        ErrorKind::ParseErrorAtKey { key, value, .. } => (Some(key), value, NUMBER),
        ErrorKind::ParseErrorAtIndex { value, .. } | ErrorKind::ParseError { value, .. } => (None, value, NUMBER),
        ErrorKind::InvalidUtf8InPathParam { key } => return format!("The path segment `{key}` is not UTF-8."),
        _ => return "The path names nothing.".to_owned(),
    };
    let name = name.map_or(String::new(), |name| format!(", {name},"));
    let value: String = value.chars().take(64).collect();
    format!("The path names nothing: its segment `{value}`{name} must be {form}.")
}

const UUID: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000";
const NUMBER: &str = "a whole number from 1 on";

/// Query parameters.
pub struct QueryOf<T>(pub T);

impl<T: DeserializeOwned> FromRequestParts<AppState> for QueryOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        Query::from_request_parts(parts, state)
            .await
            .map(|Query(value)| QueryOf(value))
            // names are checked before, and values are texts, which handlers look at
            .map_err(|_| Problem::new(ProblemCode::MalformedRequest, "The query of the URL cannot be read."))
    }
}

/// A small JSON body; faults carry JSON Pointers. (Fit requests have their own reader.)
pub struct JsonOf<T>(pub T);

/// Longest small body, unless the limit on all bodies is lower.
const SMALL_BODY: usize = 1 << 20;

impl<T: DeserializeOwned + Send + 'static> FromRequest<AppState> for JsonOf<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &AppState) -> Result<Self, Problem> {
        let limit = state.settings.body_limit.min(SMALL_BODY);
        let payload = Payload::collect(request, state, limit).await?;
        let read = |text: &[u8]| Ok(JsonOf(read_json(text)?));
        read_small_json(state, payload, limit, read).await
    }
}
