//! `POST …/iterations/{number}/preview`: what a refit would answer; stores nothing.

use axum::response::Response;
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    body::Payload,
    budget::WithPermit,
    caller_state::CallerState,
    compute::read_json,
    extract::PathOf,
    fits::json_held,
    prior::{self, Fitted},
    state::AppState,
    stored,
};
use crate::api::{
    fits::{answer::FitResultBody, reader, service},
    jobs::iteration_requests::PreviewRequest,
    problem::Problem,
};
use flankfit_engine::estimation::{FitSpec, Nodes};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(preview_iteration_fit))
}

/// Fits the stored nodes with another λ* or model, and stores nothing.
///
/// The answer is that of `POST /v1/fits` for the same nodes. To store such a fit, post it to
/// `…/fits`.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/preview", operation_id = "preview_iteration_fit",
    tag = "iterations",
    params(("job_id" = Uuid, Path), ("number" = u32, Path)),
    request_body(content = PreviewRequest, description = "A fit request without nodes."),
    responses((status = 200, description = "The estimate with its diagnostics.", body = FitResultBody))
)]
async fn preview_iteration_fit(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    payload: Payload,
) -> Result<Response, Problem> {
    let nodes = stored::nodes(&state, job, number).await?;
    let plans = state.plans.clone();
    let read = read_json(&state, payload, move |text| {
        let (spec, ()) = reader::read_refit(text)?;
        if prior::waits(&spec) {
            return Ok(Preview::Waiting(nodes, Box::new(spec)));
        }
        let answer = service::fit(&nodes, &spec, &plans)?;
        Ok(Preview::Made(answer, nodes))
    });
    let (answer, nodes) = match read.await? {
        Preview::Made(answer, nodes) => (answer, nodes),
        Preview::Waiting(nodes, spec) => {
            let measurand = state.jobs.measurand(job, number).await?;
            prior::compute_by(&state, job, Fitted::Stored(number), &measurand, (nodes, *spec), service::fit).await?
        }
    };
    let (_, permit) = nodes.into_parts();
    Ok(json_held(WithPermit::new(answer, permit)))
}

/// An answer, or what it is made of once the job has been asked for its prior.
enum Preview {
    Made(Vec<u8>, WithPermit<Nodes>),
    Waiting(WithPermit<Nodes>, Box<FitSpec>),
}
