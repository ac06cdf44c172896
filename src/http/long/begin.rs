//! A request becomes a task.

use std::time::Duration;

use axum::{
    RequestPartsExt,
    body::Body,
    extract::{MatchedPath, RawPathParams, Request},
    http::{HeaderValue, StatusCode, header, request::Parts},
    middleware::Next,
    response::{IntoResponse, Response},
};
use uuid::Uuid;

use super::{
    super::{
        body::Payload,
        caller_state::CallerState,
        extract::not_utf_8,
        idempotency::{IdempotencyKey, KEY, REPLAYED, reused},
        multipart,
        state::AppState,
    },
    answer, endpoints, packed,
    prefer::{APPLIED, Preference},
};
use crate::{
    api::{json::writer::text_of, problem::Problem},
    jobs::{Begun, Scope, Task, TaskDraft},
    pool::{self, Handle, PoolError},
};

/// Longest time in which a request is read and checked before it counts as checked.
const CHECKS: Duration = Duration::from_secs(10);

/// Keeps the request as a task and tells where, once nothing speaks against it.
pub async fn respond_async(
    state: AppState,
    scope: Scope,
    preference: Preference,
    request: Request,
    next: Next,
) -> Response {
    begin(state, scope, preference, request, next).await.unwrap_or_else(IntoResponse::into_response)
}

async fn begin(
    state: AppState,
    scope: Scope,
    preference: Preference,
    request: Request,
    next: Next,
) -> Result<Response, Problem> {
    let (mut parts, body) = request.into_parts();
    let key = parts.extract_with_state::<IdempotencyKey, _>(&state).await?.given();
    let caller = parts.extract_with_state::<CallerState, _>(&state).await?;
    let target = Target::of(&mut parts).await?;
    let (limit, whole) = (state.settings.body_limit, Request::from_parts(parts.clone(), body));
    let payload = Payload::collect(whole, &state, limit).await?;
    let bytes = payload.bytes();
    let request_sha256 = beside(&state, move || multipart::digest(payload, limit)).await??;
    if let Some(key) = &key
        && let Some(before) = caller.jobs.task_of_key(key, &target.scope, &request_sha256).await?
    {
        return told(&caller, before, preference).await;
    }
    let checks = Handle::for_checks();
    let id = caller.app.jobs.fresh_id(caller.app.jobs.now());
    // its handler takes the permit for the bytes now, and does not copy what is as long as it says
    let mut checked = Request::from_parts(parts.clone(), Body::from(bytes.clone()));
    checked.headers_mut().insert(header::CONTENT_LENGTH, bytes.len().into());
    checked.headers_mut().remove(header::TRANSFER_ENCODING);
    if key.is_none() {
        // what is so quick that it is stored before it is given up is not stored again
        let own = HeaderValue::from_str(&TaskDraft::own_key(id)).map_err(Problem::internal)?;
        checked.headers_mut().insert(&KEY, own);
    }
    match tokio::time::timeout(CHECKS, pool::under(checks.clone(), next.run(checked))).await {
        Ok(answered) if !checks.has_begun() => return Ok(answered),
        // the next thing would be to compute, or there is so much to read that nobody should wait
        Ok(_) | Err(_) => {}
    }
    let mut permit = state.budget.permit();
    permit.force(bytes.len());
    let draft = TaskDraft {
        id,
        scope,
        scopes: caller.principal.scopes,
        request: parts.uri.path_and_query().map_or("/", |path| path.as_str()).to_owned(),
        job: target.job,
        key,
        key_scope: target.scope,
        request_sha256,
        headers: answer::of_request(&parts.headers),
        body: beside(&state, move || packed::packed_bytes(&bytes)).await??,
    };
    drop(permit);
    let begun = caller.jobs.begin_task(draft, state.settings.operation_bytes).await?;
    told(&caller, begun, preference).await
}

/// Does work before the task is kept, which waits for none of those who compute.
async fn beside<T: Send + 'static>(
    state: &AppState,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, PoolError> {
    pool::under(Handle::for_checks(), state.pool.run(work)).await
}

/// What a request is for.
struct Target {
    /// Method and path, as handlers write the scopes of keys.
    scope: String,
    /// Whose events tell of it.
    job: Option<Uuid>,
}

/// No event of its job tells that a purge waits: that would change the archive whose digest it
/// names.
const UNTOLD: &str = "/v1/jobs/{job_id}/purge";

impl Target {
    async fn of(parts: &mut Parts) -> Result<Self, Problem> {
        let path = parts.extensions.get::<MatchedPath>().map_or(String::new(), |path| path.as_str().to_owned());
        let parameters = parts.extract::<RawPathParams>().await.map_err(|_| not_utf_8())?;
        let (mut scope, mut job) = (format!("POST {path}"), None);
        for (name, value) in &parameters {
            // ids and numbers are written in more than one way
            let id = Uuid::try_parse(value).ok();
            let number = value.parse::<u64>().ok().map(|number| number.to_string());
            let value = id.map(|id| id.to_string()).or(number).unwrap_or_else(|| value.to_owned());
            scope = scope.replace(&format!("{{{name}}}"), &value);
            job = job.or(id.filter(|_| name == "job_id" && path != UNTOLD));
        }
        Ok(Target { scope, job })
    }
}

/// Tells of a task: with its result if it has one within the time that the client would wait.
async fn told(caller: &CallerState, begun: Begun, preference: Preference) -> Result<Response, Problem> {
    let (mut task, before) = match begun {
        Begun::New(task) => (task, false),
        Begun::Before(task) => (task, true),
        Begun::OtherRequest => return Err(reused()),
    };
    let mut response = None;
    if let Some(wait) = preference.waiting(caller.settings.request_timeout()) {
        // the task is kept, whatever can be said of it now: then 202 tells where to ask again
        task = endpoints::ended_within(caller, task.clone(), wait).await.unwrap_or(task);
        if task.state.is_end() {
            response = match endpoints::result(caller, &task).await {
                Ok(mut result) => {
                    preference.waited().map(|waited| result.headers_mut().insert(&APPLIED, waited));
                    Some(result)
                }
                Err(problem) if problem.status == 503 => None,
                Err(problem) => return Err(problem),
            };
        }
    }
    let mut response = match response {
        Some(response) => response,
        None => accepted(caller, &task).await?,
    };
    if before {
        response.headers_mut().insert(&REPLAYED, HeaderValue::from_static("true"));
    }
    Ok(response)
}

async fn accepted(caller: &CallerState, task: &Task) -> Result<Response, Problem> {
    let text = text_of(&endpoints::told(caller, task).await?);
    let mut response = (StatusCode::ACCEPTED, text).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    headers.extend(HeaderValue::from_str(&format!("/v1/operations/{}", task.id)).map(|at| (header::LOCATION, at)));
    if !task.state.is_end() {
        headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
    }
    headers.insert(&APPLIED, HeaderValue::from_static("respond-async"));
    Ok(response)
}
