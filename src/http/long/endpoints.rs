//! `/v1/operations`: requests that are answered later.

use std::time::Duration;

use axum::{
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use tokio::time::{Instant, sleep};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    super::{
        caller_state::CallerState,
        extract::{PathOf, QueryOf},
        paging::PageQuery,
        state::AppState,
    },
    answer,
    prefer::{APPLIED, Preference},
};
use crate::{
    api::{
        jobs::operation::{OperationBody, OperationPageBody},
        problem::{Problem, ProblemCode},
    },
    jobs::{List, Task, TaskResult, TaskState},
};

/// Who waits looks so often, whatever is told, and no more often than that.
const LOOK: Duration = Duration::from_secs(1);
const PAUSE: Duration = Duration::from_millis(20);

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(list_operations))
        .routes(routes!(get_operation, cancel_operation))
        .routes(routes!(get_operation_result))
}

/// Lists the operations that the caller may see, newest first.
///
/// These are the operations whose requests the caller's scopes allow. An operation is kept for an
/// hour after its end.
#[utoipa::path(
    get, path = "/v1/operations", operation_id = "list_operations", tag = "operations",
    params(PageQuery),
    responses(
        (status = 200, description = "Some operations, and where the next page begins.", body = OperationPageBody)
    )
)]
async fn list_operations(
    state: CallerState,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<OperationPageBody>, Problem> {
    let mut page = state.jobs.tasks(state.principal.scopes, query.check(List::Tasks)?).await?;
    page.items.iter_mut().for_each(|task| observe(&state, task));
    Ok(axum::Json(OperationPageBody::of(page, state.app.jobs.now())))
}

/// An operation: state, progress and remaining time.
///
/// The operation was begun by a request with `Prefer: respond-async`. Every caller with the scope
/// of that request may see it, on any server.
#[utoipa::path(
    get, path = "/v1/operations/{operation_id}", operation_id = "get_operation", tag = "operations",
    params(
        ("operation_id" = Uuid, Path),
        ("Prefer" = Option<String>, Header, description = "`wait=N`: the answer is sent when the operation has ended, \
            or after N seconds.")
    ),
    responses(
        (status = 200, description = "The operation.", body = OperationBody)
    )
)]
async fn get_operation(state: CallerState, PathOf(id): PathOf<Uuid>, headers: HeaderMap) -> Result<Response, Problem> {
    let (preference, task) = (Preference::of(&headers), find(&state, id).await?);
    let task = waited(&state, task, preference).await?;
    Ok(applied(axum::Json(told(&state, &task).await?).into_response(), preference))
}

/// What is told of a task, with why it failed if it did.
pub async fn told(state: &CallerState, task: &Task) -> Result<OperationBody, Problem> {
    let mut body = OperationBody::of(task, state.app.jobs.now());
    if task.state == TaskState::Failed
        && let (_, Some(TaskResult::Own(own))) = state.jobs.task_result(task.id).await?
    {
        body.problem = state.pool.run(move || answer::problem(&own)).await?;
    }
    Ok(body)
}

/// Cancels an operation. If it has ended, its result is deleted.
///
/// Nothing is stored for it after this, and its computation ends within four seconds on any server.
/// Data stored before is kept.
#[utoipa::path(
    delete, path = "/v1/operations/{operation_id}", operation_id = "cancel_operation", tag = "operations",
    params(("operation_id" = Uuid, Path)),
    responses((status = 204, description = "The operation is cancelled, or was over and is forgotten."))
)]
async fn cancel_operation(state: CallerState, PathOf(id): PathOf<Uuid>) -> Result<StatusCode, Problem> {
    let task = find(&state, id).await?;
    state.jobs.cancel_task(&task).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// The answer to the request of an operation: its status, its media type and its headers, as the
/// plain request would have had them.
///
/// It is kept for an hour. The statuses named here are of operations without an answer; any other
/// is that of the request.
#[utoipa::path(
    get, path = "/v1/operations/{operation_id}/result", operation_id = "get_operation_result", tag = "operations",
    params(
        ("operation_id" = Uuid, Path),
        ("Prefer" = Option<String>, Header, description = "`wait=N`: the answer is sent when the operation has ended, \
            or after N seconds.")
    ),
    responses(
        (status = 200, description = "The answer of the request, with its status, media type and headers; 201 if it \
            stored something."),
        (status = 409, description = "The operation has not ended yet.", body = Problem,
            content_type = "application/problem+json"),
        (status = 410, description = "The operation was cancelled and has no result.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn get_operation_result(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (preference, task) = (Preference::of(&headers), find(&state, id).await?);
    let task = waited(&state, task, preference).await?;
    if !task.state.is_end() {
        let detail = "The operation has not ended yet; ask again, or with the header `Prefer: wait=30`.";
        return Err(Problem::new(ProblemCode::OperationRunning, detail).retry_after(1));
    }
    Ok(applied(result(&state, &task).await?, preference))
}

/// A task that the caller may ask after.
async fn find(state: &CallerState, id: Uuid) -> Result<Task, Problem> {
    let mut task = state.jobs.task(id).await?;
    if !state.principal.scopes.contains(task.scope) {
        let scope = task.scope.name();
        let detail = format!("The request of this operation asked for the scope `{scope}`, and so does this.");
        return Err(Problem::lacking_scope(detail));
    }
    observe(state, &mut task);
    Ok(task)
}

/// What this server does it knows best.
fn observe(state: &CallerState, task: &mut Task) {
    if task.state == TaskState::Running
        && let Some(progress) = state.long.progress(task.id)
    {
        task.progress = task.progress.max(progress);
        task.told_at = Some(state.app.jobs.now());
    }
}

async fn waited(state: &CallerState, task: Task, preference: Preference) -> Result<Task, Problem> {
    match preference.waiting(state.settings.request_timeout()) {
        Some(wait) => ended_within(state, task, wait).await,
        None => Ok(task),
    }
}

/// A task once it has ended, or as it stands after that time.
pub async fn ended_within(state: &CallerState, mut task: Task, wait: Duration) -> Result<Task, Problem> {
    let (until, mut changes) = (Instant::now() + wait, state.jobs.listen_to_tasks());
    let mut stopping = std::pin::pin!(state.shutdown.begun());
    while !task.state.is_end() && Instant::now() < until {
        tokio::select! {
            _ = changes.changed() => {}
            () = sleep(LOOK.min(until.saturating_duration_since(Instant::now()))) => {}
            () = &mut stopping => break,
        }
        task = state.jobs.task(task.id).await?;
        observe(state, &mut task);
        sleep(PAUSE).await;
    }
    Ok(task)
}

/// The result of a task that has ended.
pub async fn result(state: &CallerState, task: &Task) -> Result<Response, Problem> {
    let length = task.bytes.try_into().unwrap_or(usize::MAX);
    let mut permit = state.budget.take(length)?;
    // a store copies it
    permit.force(length);
    let (_, Some(result)) = state.jobs.task_result(task.id).await? else {
        let detail = "The operation was cancelled; nothing is kept of it.";
        return Err(Problem::new(ProblemCode::OperationCancelled, detail));
    };
    let mut response = state.pool.run(move || answer::response(result, permit)).await??;
    // as the answer to a POST: its version is one of what was stored, and not of this place
    response.headers_mut().entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    Ok(response)
}

fn applied(mut response: Response, preference: Preference) -> Response {
    preference.waited().map(|waited| response.headers_mut().insert(&APPLIED, waited));
    response
}
