//! `GET /v1/jobs/{job_id}/trace`: the whole story of a job.

use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use crate::{
    api::{jobs::trace::TraceBody, problem::Problem},
    http::{
        caller_state::CallerState,
        layers::{
            extract::{PathOf, QueryOf},
            paging::PageQuery,
        },
        state::AppState,
    },
    jobs::List,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_trace))
}

/// Every fit, λ* choice and decision of a job in the order in which they were made.
///
/// They come iteration by iteration in pages; a page of big iterations may hold fewer than `limit`.
/// Of each list of an iteration the last hundred entries are listed; `earlier` counts the others.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/trace", operation_id = "get_trace", tag = "iterations",
    params(("job_id" = Uuid, Path), PageQuery),
    responses(
        (status = 200, description = "The job with some of its iterations, by number, and where the next page begins.",
            body = TraceBody)
    )
)]
async fn get_trace(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<TraceBody>, Problem> {
    Ok(axum::Json(state.jobs.trace(job, query.check(List::Iterations)?).await?.into()))
}
