//! Extractors whose refusals are problems.

use axum::{
    extract::{FromRequest, FromRequestParts, Path, Query, path::ErrorKind, rejection::PathRejection},
    http::request::Parts,
};
use serde::de::DeserializeOwned;
use utoipa::ToSchema;
use uuid::Uuid;

use super::prelude::*;
use super::{body::Payload, compute::read_small_json};
use crate::api::json::value::read_json;

/// Path parameters; an id of the wrong form is an id that does not exist (404).
pub struct PathOf<T>(pub T);

impl<T: Segments> FromRequestParts<AppState> for PathOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        let nothing = |detail: String| Problem::new(ProblemCode::NotFound, detail);
        let Path(segments) = Path::<Vec<(String, String)>>::from_request_parts(parts, state)
            .await
            .map_err(|rejection| nothing(unreadable(rejection)))?;
        let value = T::read(&mut segments.iter()).map_err(nothing)?;
        match segments.iter().find_map(|(name, segment)| unusual(name, segment)) {
            None => Ok(PathOf(value)),
            Some(detail) => Err(nothing(detail)),
        }
    }
}

/// Types that the parameters of a path are read into, one after the other.
pub trait Segments: Sized {
    /// Returns the value, or the message for a parameter that is none.
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String>;
}

impl Segments for Uuid {
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String> {
        let (name, segment) = segments.next().ok_or(NOTHING)?;
        Uuid::try_parse(segment).map_err(|_| misread(segment, &format!(", {name},"), UUID))
    }
}

impl Segments for u32 {
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String> {
        let (_, segment) = segments.next().ok_or(NOTHING)?;
        segment.parse().map_err(|_| misread(segment, "", NUMBER))
    }
}

impl Segments for String {
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String> {
        segments.next().map(|(_, segment)| segment.clone()).ok_or(NOTHING.to_owned())
    }
}

impl<A: Segments, B: Segments> Segments for (A, B) {
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String> {
        Ok((A::read(segments)?, B::read(segments)?))
    }
}

impl<A: Segments, B: Segments, C: Segments> Segments for (A, B, C) {
    fn read<'a>(segments: &mut impl Iterator<Item = &'a (String, String)>) -> Result<Self, String> {
        Ok((A::read(segments)?, B::read(segments)?, C::read(segments)?))
    }
}

/// Returns the message for a number or an id that is not in its usual form: a thing has one
/// address.
fn unusual(name: &str, segment: &str) -> Option<String> {
    let number = segment.parse::<u32>().ok().map(|number| number.to_string());
    let id = Uuid::try_parse(segment).ok().map(|id| id.to_string());
    let usual = number.filter(|_| name == "number").or(id)?;
    let differs = !usual.eq_ignore_ascii_case(segment);
    differs.then(|| format!("There is no such path: write its segment `{segment}` ({name}) as `{usual}`."))
}

/// Returns the message for a segment of the wrong form.
fn misread(segment: &str, name: &str, form: &str) -> String {
    let segment: String = segment.chars().take(64).collect();
    format!("There is no such path: its segment `{segment}`{name} must be {form}.")
}

/// Returns the message for a path whose segments are no text.
fn unreadable(rejection: PathRejection) -> String {
    if let PathRejection::FailedToDeserializePathParams(failed) = rejection
        && let ErrorKind::InvalidUtf8InPathParam { key } = failed.into_kind()
    {
        return format!("The path segment `{key}` is not UTF-8.");
    }
    NOTHING.to_owned()
}

const NOTHING: &str = "There is no such path.";
const UUID: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000";
const NUMBER: &str = "a whole number of at least 1";

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

/// A small JSON body; errors carry JSON Pointers. (Fit requests have their own reader.)
pub struct JsonOf<T>(pub T);

/// Longest small body, unless the limit on all bodies is lower.
const SMALL_BODY: usize = 1 << 20;

impl<T: DeserializeOwned + ToSchema + Send + 'static> FromRequest<AppState> for JsonOf<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &AppState) -> Result<Self, Problem> {
        let limit = state.settings.body_limit.min(SMALL_BODY);
        let payload = Payload::collect(request, state, limit).await?;
        let read = |text: &[u8]| Ok(JsonOf(read_json(text)?));
        read_small_json(state, payload, limit, read).await
    }
}
