//! Extractors whose refusals are problems.

use axum::{
    extract::{FromRequest, FromRequestParts, Path, Query, Request},
    http::request::Parts,
};
use serde::de::DeserializeOwned;

use super::{body::Payload, state::AppState};
use crate::api::{
    problem::{Problem, ProblemCode},
    reader,
};

/// Path parameters; an id of the wrong form is an id that does not exist (404).
pub struct PathOf<T>(pub T);

impl<T: DeserializeOwned + Send> FromRequestParts<AppState> for PathOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        Path::from_request_parts(parts, state).await.map(|Path(value)| PathOf(value)).map_err(|rejection| {
            Problem::new(ProblemCode::NotFound, format!("The path names nothing: {}.", rejection.body_text()))
        })
    }
}

/// Query parameters.
pub struct QueryOf<T>(pub T);

impl<T: DeserializeOwned> FromRequestParts<AppState> for QueryOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        Query::from_request_parts(parts, state)
            .await
            .map(|Query(value)| QueryOf(value))
            .map_err(|rejection| Problem::new(ProblemCode::InvalidRequest, format!("{}.", rejection.body_text())))
    }
}

/// A small JSON body; faults carry JSON Pointers. (Fit requests have their own reader.)
pub struct JsonOf<T>(pub T);

impl<T: DeserializeOwned> FromRequest<AppState> for JsonOf<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &AppState) -> Result<Self, Problem> {
        let payload = Payload::from_request(request, state).await?;
        let text = payload.into_json(state.settings.body_limit)?;
        Ok(JsonOf(reader::read_json(&text)?))
    }
}
