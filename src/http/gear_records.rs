//! Deviations, evaluations and corrections kept with an iteration.

use axum::{extract::State, http::HeaderMap, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    accept::Form,
    body::Payload,
    extract::PathOf,
    idempotency::IdempotencyKey,
    records::{About, keep},
    state::AppState,
};
use crate::{
    api::{
        gears::{
            correction::{self, CorrectionBody},
            correction_answer::{self, KeptCorrectionBody},
            correction_csv,
            correction_request::CorrectionRequestBody,
            deviations,
            deviations_request::DeviationsRequestBody,
            evaluate,
            evaluate_request::EvaluateBody,
            gear::of_job,
        },
        problem::{Problem, ProblemCode},
        records::{self, RecordBody},
    },
    jobs::{Record, RecordKind, RepositoryError, What},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_iteration_deviations))
        .routes(routes!(create_iteration_evaluation))
        .routes(routes!(create_iteration_correction, get_iteration_correction))
}

/// Keeps the deviations of measured points with an iteration.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/deviations", operation_id = "create_iteration_deviations", tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response again.", max_length = 255)
    ),
    request_body(content = DeviationsRequestBody, description = "Points or a grid; the gear is that of the job where the request has none."),
    responses(
        (status = 201, description = "What `POST /v1/gears/deviations` answers, kept.", body = RecordBody, headers(("Location" = String, description = "Where the record is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn create_iteration_deviations(
    State(state): State<AppState>,
    PathOf(place): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], about: &About| {
        records::draft(RecordKind::Deviations, text, deviations::build(text, of_job(&about.job)?.as_ref())?)
    };
    keep(state, place, ("deviations", records::record), key, payload, build).await
}

/// Keeps the evaluation of measured traces with an iteration.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/evaluations", operation_id = "create_iteration_evaluation", tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response again.", max_length = 255)
    ),
    request_body(content = EvaluateBody, description = "Traces and how they are evaluated; the gear is that of the job where the request has none."),
    responses(
        (status = 201, description = "What `POST /v1/gears/evaluate` answers, kept.", body = RecordBody, headers(("Location" = String, description = "Where the record is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn create_iteration_evaluation(
    State(state): State<AppState>,
    PathOf(place): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], about: &About| {
        records::draft(RecordKind::Evaluation, text, evaluate::build(text, of_job(&about.job)?.as_ref())?)
    };
    keep(state, place, ("evaluations", records::record), key, payload, build).await
}

/// Computes changes of machine settings by the deviations (µm) that the iteration's nodes hold, and keeps them with it.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/correction", operation_id = "create_iteration_correction", tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response again.", max_length = 255)
    ),
    request_body(content = CorrectionRequestBody, description = "What the settings do, how far they may go, and how far that is trusted."),
    responses(
        (status = 201, description = "The changes and what they should bring.", body = CorrectionBody, headers(("Location" = String, description = "Where the record is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn create_iteration_correction(
    State(state): State<AppState>,
    PathOf(place): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], about: &About| {
        let built = correction::build(text, &about.nodes, of_job(&about.job)?.as_ref())?;
        records::draft(RecordKind::Correction, text, built)
    };
    let body = |record: &Record| record.draft.result.as_bytes().to_vec();
    keep(state, place, ("correction", body), key, payload, build).await
}

/// The correction of an iteration that was made last, with what the next iteration measured of it.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/correction", operation_id = "get_iteration_correction", tag = "iterations",
    params(("job_id" = Uuid, Path), ("number" = u32, Path)),
    responses(
        (status = 200, description = "The correction; beside what it predicted what was measured, once there is a next iteration. As CSV a line for each setting, under the names of OPC UA for Geometrical Measuring Systems.", content((KeptCorrectionBody = "application/json"), (String = "text/csv"))),
        (status = 406, description = "Neither application/json nor text/csv is accepted.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn get_iteration_correction(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let form = Form::wanted(&headers, "Corrections")?;
    let Some(record) = state.jobs.latest_record(job, number, RecordKind::Correction).await? else {
        return Err(Problem::new(ProblemCode::NotFound, "The iteration has no correction."));
    };
    if form == Form::Csv {
        return Ok(form.response(state.pool.run(move || correction_csv::write(&record)).await??));
    }
    let before = state.jobs.nodes(job, number).await?;
    let after = match number.checked_add(1) {
        Some(next) => match state.jobs.nodes(job, next).await {
            Ok(nodes) => Some((next, nodes)),
            Err(RepositoryError::NotFound(What::Iteration)) => None,
            Err(error) => return Err(error.into()),
        },
        None => None,
    };
    let gear = of_job(&state.jobs.job(job).await?)?;
    let body =
        state.pool.run(move || correction_answer::write(&record, &before, after.as_ref(), gear.as_ref())).await??;
    Ok(form.response(body))
}
