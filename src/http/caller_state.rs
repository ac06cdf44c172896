//! What a handler can reach for the caller of its request.

use std::ops::Deref;

use axum::{extract::FromRequestParts, http::request::Parts};

use super::{auth::Principal, observe::RequestId, server::Peer, state::AppState};
use crate::{
    api::problem::Problem,
    jobs::{Caller, Jobs, Origin},
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
        let principal = parts.extensions.get::<Principal>();
        let principal = principal.ok_or_else(|| Problem::internal("nobody made out the caller of the request"))?;
        let origin = Origin {
            request_id: parts.extensions.get::<RequestId>().map(|id| id.as_str().into()),
            peer: parts.extensions.get::<Peer>().map(|peer| peer.0),
        };
        let caller = Caller { origin, ..principal.caller.clone() };
        Ok(CallerState { app: state.clone(), jobs: state.jobs.of(&caller) })
    }
}

impl Deref for CallerState {
    type Target = AppState;

    fn deref(&self) -> &AppState {
        &self.app
    }
}
