//! `/v1/jobs`: gear jobs.

use super::prelude::*;
use crate::{
    api::jobs::{
        job::{JobBody, JobPatchBody, NewJobBody},
        job_list::ListedJobBody,
    },
    http::layers::{
        conditional::{job_etag, set_tag},
        job_query::JobsQuery,
    },
    jobs::{Job, JobSummary},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_job, list_jobs))
        .routes(routes!(summarize_jobs))
        .routes(routes!(get_job, update_job, delete_job))
}

/// Create a job
///
/// Iterations, streams and records belong to a job. Corrections and evaluations use its gear.
#[utoipa::path(
    post, path = "/v1/jobs", operation_id = "create_job", tag = "jobs",
    params(IdempotencyKey),
    request_body(content = NewJobBody, description = "Name, machine, gear and requirements of the job."),
    responses((status = 201, description = "The job.", body = JobBody))
)]
async fn create_job(post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let draft = read_small::<NewJobBody>(&state, payload).await?;
        let keyed = key.map(|key| key.answered_by(created));
        let job = state.jobs.create_job(draft.try_into().map_err(Problem::invalid)?, keyed).await?;
        Ok(created(&job, Stored { number: 0, version: job.version }))
    })
    .await
}

fn created(job: &Job, _: Stored) -> Answer {
    Answer::created(format!("/v1/jobs/{}", job.id), job_etag(job), text_of(&JobBody::from(job.clone())).into_bytes())
}

/// List jobs
///
/// Each job has the status of its last iteration. Jobs changed last come first. `next_cursor` of
/// one page is the `cursor` of the next; the last page has none. No page repeats a job. With
/// `sort=changed` a job that is changed while the list is read moves to the first page.
#[utoipa::path(
    get, path = "/v1/jobs", operation_id = "list_jobs", tag = "jobs",
    params(JobsQuery),
    responses((status = 200, description = "A page of jobs.", body = PageBody<ListedJobBody>))
)]
async fn list_jobs(
    state: CallerState,
    QueryOf(query): QueryOf<JobsQuery>,
) -> Result<axum::Json<PageBody<ListedJobBody>>, Problem> {
    let page = state.jobs.jobs(query.check()?).await?;
    Ok(axum::Json(page.into()))
}

/// Count jobs by status, machine and week
///
/// Weeks are those of ISO 8601 in UTC, by the last change of a job.
#[utoipa::path(
    get, path = "/v1/jobs/summary", operation_id = "summarize_jobs", tag = "jobs",
    responses((status = 200, description = "Numbers of jobs.", body = JobSummary))
)]
async fn summarize_jobs(state: CallerState) -> Result<axum::Json<JobSummary>, Problem> {
    Ok(axum::Json(state.jobs.summary().await?))
}

/// Get a job
///
/// The header `ETag` has its version, for a conditional `PATCH` or `DELETE`.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}", operation_id = "get_job", tag = "jobs",
    responses((status = 200, description = "The job.", body = JobBody))
)]
async fn get_job(state: CallerState, PathOf(id): PathOf<Uuid>) -> Result<Response, Problem> {
    Ok(present(state.jobs.job(id).await?))
}

/// Update a job
///
/// Omitted fields stay unchanged. Fields that `clear` names are removed. `gear`, `requirements` and
/// `tags` are replaced as a whole. The new gear must have every tooth that the job has an iteration
/// of.
#[utoipa::path(
    patch, path = "/v1/jobs/{job_id}", operation_id = "update_job", tag = "jobs",
    params(IfMatch),
    request_body(content = JobPatchBody, description = "The fields to change."),
    responses(
        (status = 200, description = "The job after the change.", body = JobBody),
        (status = 409, description = "An iteration or an open stream is of a tooth that the new gear does not have.")
    )
)]
async fn update_job(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    IfMatch(precondition): IfMatch,
    JsonOf(patch): JsonOf<JobPatchBody>,
) -> Result<Response, Problem> {
    Ok(present(state.jobs.patch_job(id, patch.try_into().map_err(Problem::invalid)?, precondition).await?))
}

/// Delete a job without iterations
///
/// A job with iterations cannot be deleted: its trace records every decision on the gear.
#[utoipa::path(
    delete, path = "/v1/jobs/{job_id}", operation_id = "delete_job", tag = "jobs",
    params(IfMatch),
    responses(
        (status = 204, description = "The job is deleted."),
        (status = 409, description = "The job has iterations, which cannot be deleted.")
    )
)]
async fn delete_job(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    IfMatch(precondition): IfMatch,
) -> Result<StatusCode, Problem> {
    state.jobs.delete_job(id, precondition).await?;
    Ok(StatusCode::NO_CONTENT)
}

fn present(job: Job) -> Response {
    let tag = job_etag(&job);
    let mut response = axum::Json(JobBody::from(job)).into_response();
    set_tag(response.headers_mut(), &tag);
    response
}
