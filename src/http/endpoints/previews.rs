//! `POST …/iterations/{number}/preview`: what a refit would answer; stores nothing.

use super::prelude::*;
use crate::{
    api::{fits::answer::FitResultBody, jobs::iteration_requests::PreviewRequest},
    usecases::fit,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(preview_iteration_fit))
}

/// Preview a fit of an iteration
///
/// Fits the stored nodes with another λ* or model. The response is that of `POST /v1/fits` for the
/// same nodes. Nothing is stored. To store such a fit, post it to `…/fits`.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/preview", operation_id = "preview_iteration_fit",
    tag = "iterations",
    request_body(content = PreviewRequest, description = "A fit request without nodes."),
    responses((status = 200, description = "The estimate with its diagnostics.", body = FitResultBody))
)]
async fn preview_iteration_fit(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    payload: Payload,
) -> Result<Response, Problem> {
    let nodes = nodes::stored(state.context(), job, number).await?;
    let plans = state.plans.clone();
    let refit = read_json(&state, payload, move |text| fit::previewed(text, nodes, &plans)).await?;
    Ok(json_held(fit::preview(state.context(), (job, number), refit).await?))
}
