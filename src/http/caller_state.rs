//! State of a handler for the caller of its request.

use std::{ops::Deref, pin::Pin};

use axum::{extract::FromRequestParts, http::request::Parts};

use super::{server::Peer, state::AppState};
use crate::{
    api::problem::Problem,
    http::layers::{auth::Principal, observe::RequestId},
    jobs::{Jobs, Origin, TenantKeys},
    usecases::Context,
};

/// The state of the service, with the jobs of the tenant whose caller is answered.
#[derive(Clone)]
pub struct CallerState {
    pub app: AppState,
    pub jobs: Jobs,
    /// The caller.
    pub principal: Principal,
}

impl CallerState {
    /// Returns what use cases work with for this caller.
    pub fn context(&self) -> Context<'_> {
        Context { jobs: &self.jobs, pool: &self.app.pool, budget: &self.app.budget, plans: &self.app.plans }
    }

    /// The keys of the caller's tenant.
    pub fn tenant_keys(&self) -> TenantKeys {
        self.app.jobs.keys_of(&self.principal.caller)
    }

    /// Returns the problem of the caller as soon as it is not let in any more.
    pub fn refused(&self) -> Pin<Box<dyn Future<Output = Problem> + Send>> {
        let (app, proof) = (self.app.clone(), self.principal.proof.clone());
        Box::pin(async move { app.callers.ended(&proof).await })
    }
}

impl FromRequestParts<AppState> for CallerState {
    type Rejection = Problem;

    /// The caller was made out before any handler (see `layers::auth`).
    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Problem> {
        let principal = parts.extensions.get::<Principal>().cloned();
        let mut principal =
            principal.ok_or_else(|| Problem::internal("the caller of the request was not authenticated"))?;
        principal.caller.origin = Origin {
            request_id: parts.extensions.get::<RequestId>().map(|id| id.as_str().into()),
            peer: parts.extensions.get::<Peer>().map(|peer| peer.0),
        };
        Ok(CallerState { app: state.clone(), jobs: state.jobs.of(&principal.caller), principal })
    }
}

impl Deref for CallerState {
    type Target = AppState;

    fn deref(&self) -> &AppState {
        &self.app
    }
}
