//! A kept request, handed to its handler.

use axum::{
    Router,
    body::Body,
    http::{HeaderValue, Method, Request, header},
    response::Response,
};
use tower::ServiceExt;

use super::{
    super::{
        auth::{Principal, Proof},
        idempotency::KEY,
        observe::RequestId,
        server::Peer,
        state::AppState,
    },
    answer::{self, Answered},
};
use crate::{
    api::problem::Problem,
    jobs::{ClaimedTask, frames},
    pool::Handle,
};

/// What the handler of a task's request answers, read to its end.
pub async fn answer(state: &AppState, handlers: &Router, task: ClaimedTask) -> Answered {
    match respond(state, handlers, task).await {
        Ok(response) => Answered::read(response, &state.budget, state.settings.operation_bytes).await,
        Err(problem) => problem.into(),
    }
}

async fn respond(state: &AppState, handlers: &Router, task: ClaimedTask) -> Result<Response, Problem> {
    let ClaimedTask { lease, caller, scopes, request: path, key, headers, body, .. } = task;
    // unpacking is no part of what is told about; what was taken may be longer than is taken now
    let most = frames::LONGEST.max(state.settings.body_limit as u64);
    let body = state.pool.run_with(Handle::new(), move || frames::unpacked(&body, most)).await?;
    let body = body.map_err(Problem::internal)?;
    let length = body.len();
    let mut request =
        Request::builder().method(Method::POST).uri(path).body(Body::from(body)).map_err(Problem::internal)?;
    *request.headers_mut() = answer::headers(&headers);
    // so that it is not copied
    request.headers_mut().insert(header::CONTENT_LENGTH, length.into());
    request.headers_mut().insert(&KEY, HeaderValue::from_str(&key).map_err(Problem::internal)?);
    let extensions = request.extensions_mut();
    if let Some(id) = caller.origin.request_id.as_deref().and_then(|id| HeaderValue::from_str(id).ok()) {
        extensions.insert(RequestId(id));
    }
    caller.origin.peer.map(|peer| extensions.insert(Peer(peer)));
    extensions.insert(Principal { caller, scopes, role: None, proof: Proof::None });
    extensions.insert(lease);
    let Ok(response) = handlers.clone().oneshot(request).await;
    Ok(response)
}
