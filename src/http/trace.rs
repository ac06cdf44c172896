//! `GET /v1/jobs/{job_id}/trace`: the whole story of a job.

use axum::{extract::State, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{extract::PathOf, fits::json, state::AppState};
use crate::api::{
    job_trace::{self, TraceBody},
    problem::Problem,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_trace))
}

/// Every fit, λ* choice and decision of a job in the order in which they were made.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/trace", operation_id = "get_trace", tag = "iterations",
    params(("job_id" = Uuid, Path)),
    responses((status = 200, description = "The trace.", body = TraceBody))
)]
async fn get_trace(State(state): State<AppState>, PathOf(job): PathOf<Uuid>) -> Result<Response, Problem> {
    Ok(json(job_trace::trace(state.jobs.trace(job).await?)))
}
