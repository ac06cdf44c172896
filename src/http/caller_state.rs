//! What a handler can reach for the caller of its request.

use std::ops::Deref;

use axum::{extract::FromRequestParts, http::request::Parts};

use super::state::AppState;
use crate::{
    api::problem::Problem,
    jobs::{Caller, Jobs},
};

/// The state of the service, with the jobs of the tenant whose caller is answered.
#[derive(Clone)]
pub struct CallerState {
    pub app: AppState,
    pub jobs: Jobs,
}

impl FromRequestParts<AppState> for CallerState {
    type Rejection = Problem;

    /// The caller was made out before any handler (see [`super::auth`]).
    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        let caller = parts.extensions.get::<Caller>();
        let caller = caller.ok_or_else(|| Problem::internal("nobody made out the caller of the request"))?;
        Ok(CallerState { app: state.clone(), jobs: state.jobs.of(caller) })
    }
}

impl Deref for CallerState {
    type Target = AppState;

    fn deref(&self) -> &AppState {
        &self.app
    }
}
