//! `…/correction/applied`: the changes that were entered on the machine.

use super::prelude::*;
use super::records::{JobRecordRequest, NewRecord, RecordRequest};
use crate::{
    api::{
        gears::correction::applied::{self, AppliedRequestBody},
        json::value,
    },
    jobs::Record,
    usecases::entered as corrections,
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
    params(IdempotencyKey),
    request_body(content = AppliedRequestBody, description = "The changes that were entered."),
    responses(
        (status = 201, description = "The record: its `result` has every setting with the change that was entered and \
            the proposed one.", body = RecordBody)
    )
)]
async fn create_applied_changes(request: RecordRequest) -> Result<Response, Problem> {
    let correction =
        async |state: CallerState, job, number| match corrections::newest(state.context(), job, number).await? {
            Some(correction) => Ok((number, correction)),
            None => Err(Problem::new(
                ProblemCode::NotFound,
                format!("Iteration {number} has no correction: compute one before entering changes."),
            )),
        };
    request.keep_of(correction, entered).await
}

/// Record the changes entered for a gear's correction
///
/// The changes belong to the gear's newest correction. The next round is compared with them instead
/// of the proposed changes. A setting that is not named counts as changed as proposed. The newest
/// entry counts, and earlier ones stay in the trace.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/correction/applied", operation_id = "create_gear_applied_changes", tag = "jobs",
    params(IdempotencyKey),
    request_body(content = AppliedRequestBody, description = "The changes that were entered."),
    responses(
        (status = 201, description = "The record: its `result` has every setting with the change that was entered and \
            the proposed one.", body = RecordBody)
    )
)]
async fn create_gear_applied_changes(request: JobRecordRequest) -> Result<Response, Problem> {
    let correction = async |state: CallerState, job| {
        state.jobs.job(job).await?;
        match corrections::newest_of_gear(state.context(), job).await? {
            Some((number, correction)) => Ok((number, (number, correction))),
            None => Err(Problem::new(
                ProblemCode::NotFound,
                "The job has no correction of the gear: compute one before entering changes.",
            )),
        }
    };
    request.keep_of(correction, entered).await
}

/// Returns the record of entered changes of a correction.
fn entered(text: &[u8], (number, correction): &(u32, Record), _: Room) -> Result<NewRecord, Problem> {
    Ok(applied::draft(&value::read_json::<AppliedRequestBody>(text)?, correction, *number, "")?.into())
}
