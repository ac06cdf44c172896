//! `/v1/simulations`: machines that are corrected in a loop, each run kept as a job.

use axum::{extract::State, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};

use super::{body::Payload, fits::json, state::AppState};
use crate::{
    api::{
        gears::closed_loop::{self, ClosedLoopBody, ClosedLoopResultBody, Kept, Told},
        problem::Problem,
    },
    jobs::RepositoryError,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(simulate_closed_loop))
}

/// Simulates a machine whose settings are off: measured, corrected and machined again, by several ways to correct.
#[utoipa::path(
    post, path = "/v1/simulations/closed-loop", operation_id = "simulate_closed_loop", tag = "simulations",
    request_body(content = ClosedLoopBody, description = "The machine, the probe and the ways to correct; everything has a default."),
    responses((status = 200, description = "Round by round what was measured and changed, and the jobs that keep it.", body = ClosedLoopResultBody))
)]
async fn simulate_closed_loop(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let (limit, plans) = (state.settings.body_limit, state.plans.clone());
    let simulated = state.pool.run(move || closed_loop::simulate(&payload.into_json(limit)?, &plans)).await??;
    let mut runs = Vec::with_capacity(simulated.runs.len());
    for told in simulated.runs {
        runs.push(keep(&state, told).await?);
    }
    let body = ClosedLoopResultBody { seed: simulated.seed, condition: simulated.condition, runs };
    Ok(json(serde_json::to_vec(&body).map_err(Problem::internal)?))
}

/// Keeps a run as a job whose iterations and corrections are those of any other.
async fn keep(
    state: &AppState,
    Told { mut run, kept }: Told,
) -> Result<closed_loop::ClosedLoopRunBody, RepositoryError> {
    let Some(Kept { job, rounds }) = kept else { return Ok(run) };
    let job = state.jobs.create_job(job, None).await?;
    for iteration in rounds {
        state.jobs.add_iteration(job.id, iteration, None).await?;
    }
    run.job_id = Some(job.id);
    Ok(run)
}
