//! `GET /v1/jobs/{job_id}/trace`: the whole story of a job.

use super::prelude::*;
use crate::api::jobs::trace::TraceBody;

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_trace))
}

/// Get the trace of a job
///
/// Returns every fit, λ* choice and decision in the order in which they were made, iteration by
/// iteration in pages. A page of large iterations may hold fewer than `limit`. Each list of an
/// iteration has its last hundred entries; `earlier` counts the others.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/trace", operation_id = "get_trace", tag = "iterations",
    params(PageQuery),
    responses((status = 200, description = "The job with a page of its iterations, by number.", body = TraceBody))
)]
async fn get_trace(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<TraceBody>, Problem> {
    Ok(axum::Json(state.jobs.trace(job, query.check(List::Iterations)?).await?.into()))
}
