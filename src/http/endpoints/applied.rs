//! `…/correction/applied`: the changes that were entered on the machine.

use axum::response::Response;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::records::{JobRecordRequest, NewRecord, RecordRequest};
use crate::{
    api::{
        gears::correction::applied::{self, AppliedRequestBody},
        jobs::records::RecordBody,
        json::value::read_json,
        problem::{Problem, ProblemCode, Room},
    },
    http::{caller_state::CallerState, layers::idempotency::IdempotencyKey, state::AppState},
    jobs::Record,
    usecases::entered,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_applied_changes)).routes(routes!(create_gear_applied_changes))
}

/// Record the changes entered for an iteration's correction
///
/// The changes belong to the iteration's newest correction. The next measurement is compared with
/// them instead of the proposed changes. A setting that is not named counts as changed as proposed.
/// Nothing is overwritten: the newest entry counts, and earlier ones stay in the trace.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/correction/applied", operation_id = "create_applied_changes",
    tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        IdempotencyKey
    ),
    request_body(content = AppliedRequestBody, description = "The changes that were entered."),
    responses(
        (status = 201, description = "The record: its `result` has every setting with the change that was entered and \
            the proposed one.", body = RecordBody,
            headers(("Location" = String, description = "Address of the record.")))
    )
)]
async fn create_applied_changes(request: RecordRequest) -> Result<Response, Problem> {
    let correction = async |state: CallerState, job, number| match entered::newest(state.context(), job, number).await?
    {
        Some(correction) => Ok((number, correction)),
        None => Err(Problem::new(
            ProblemCode::NotFound,
            format!("Iteration {number} has no correction: compute one before entering changes."),
        )),
    };
    let build = |text: &[u8], (number, correction): &(u32, Record), _: Room| {
        let draft = applied::draft(&read_json::<AppliedRequestBody>(text)?, correction, *number, "")?;
        Ok(NewRecord::from(draft))
    };
    request.keep_of("correction/applied", correction, build).await
}

/// Record the changes entered for a gear's correction
///
/// The changes belong to the gear's newest correction. The next round is compared with them instead
/// of the proposed changes. A setting that is not named counts as changed as proposed. The newest
/// entry counts, and earlier ones stay in the trace.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/correction/applied", operation_id = "create_gear_applied_changes", tag = "jobs",
    params(
        ("job_id" = Uuid, Path),
        IdempotencyKey
    ),
    request_body(content = AppliedRequestBody, description = "The changes that were entered."),
    responses(
        (status = 201, description = "The record: its `result` has every setting with the change that was entered and \
            the proposed one.", body = RecordBody,
            headers(("Location" = String, description = "Address of the record.")))
    )
)]
async fn create_gear_applied_changes(request: JobRecordRequest) -> Result<Response, Problem> {
    let correction = async |state: CallerState, job| {
        state.jobs.job(job).await?;
        match entered::newest_of_gear(state.context(), job).await? {
            Some((number, correction)) => Ok((number, (number, correction))),
            None => Err(Problem::new(
                ProblemCode::NotFound,
                "The job has no correction of the gear: compute one before entering changes.",
            )),
        }
    };
    let build = |text: &[u8], (number, correction): &(u32, Record), _: Room| {
        let draft = applied::draft(&read_json::<AppliedRequestBody>(text)?, correction, *number, "")?;
        Ok(NewRecord::from(draft))
    };
    request.keep_of("correction/applied", correction, build).await
}
