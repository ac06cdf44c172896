//! `…/correction/applied`: the changes that were entered on the machine.

use axum::response::Response;
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    caller_state::CallerState,
    idempotency::IdempotencyKey,
    records::{JobRecordRequest, NewRecord, RecordRequest},
    rounds,
    state::AppState,
};
use crate::{
    api::{
        faults::Faults,
        gears::correction::applied::{self, AppliedRequestBody},
        jobs::records::RecordBody,
        json::value::read_json,
        problem::{Problem, ProblemCode, Room},
    },
    jobs::{Measurand, Predecessors, Record, RecordDraft, RecordKind},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_applied_changes)).routes(routes!(create_gear_applied_changes))
}

/// Keeps the changes that were entered on the machine after the iteration's correction.
///
/// The changes belong to the iteration's newest correction; the next measurement is then compared
/// with them instead of the proposed changes. A setting that is not named counts as changed as
/// proposed. Nothing is overwritten: the newest entry counts, and earlier ones stay in the trace.
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
            headers(("Location" = String, description = "Where the record is.")))
    )
)]
async fn create_applied_changes(request: RecordRequest) -> Result<Response, Problem> {
    let correction = async |state: CallerState, job, number| match newest(&state, job, number).await? {
        Some(correction) => Ok((number, correction)),
        None => Err(Problem::new(
            ProblemCode::NotFound,
            format!("Iteration {number} has no correction: make one before entering what was set of it."),
        )),
    };
    let build = |text: &[u8], (number, correction): &(u32, Record), _: Room| {
        let draft = applied::draft(&read_json::<AppliedRequestBody>(text)?, correction, *number, "")?;
        Ok(NewRecord::from(draft))
    };
    request.keep_of("correction/applied", correction, build).await
}

/// Keeps the changes that were entered on the machine after the correction of the gear.
///
/// The changes belong to the gear's newest correction; the next round is then compared with them
/// instead of the proposed changes. A setting that is not named counts as changed as proposed. The
/// newest entry counts, and earlier ones stay in the trace.
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
            headers(("Location" = String, description = "Where the record is.")))
    )
)]
async fn create_gear_applied_changes(request: JobRecordRequest) -> Result<Response, Problem> {
    let correction = async |state: CallerState, job| {
        state.jobs.job(job).await?;
        match newest_of_gear(&state, job).await? {
            Some((number, correction)) => Ok((number, (number, correction))),
            None => Err(Problem::new(
                ProblemCode::NotFound,
                "The job has no correction of the gear: make one before entering what was set of it.",
            )),
        }
    };
    let build = |text: &[u8], (number, correction): &(u32, Record), _: Room| {
        let draft = applied::draft(&read_json::<AppliedRequestBody>(text)?, correction, *number, "")?;
        Ok(NewRecord::from(draft))
    };
    request.keep_of("correction/applied", correction, build).await
}

async fn newest_of_gear(state: &CallerState, job: Uuid) -> Result<Option<(u32, Record)>, Problem> {
    let made = state.jobs.rounds(job).await?;
    let found = rounds::newest(state, job, &made).await?;
    Ok(found.map(|(made, record)| (made.number, record)))
}

async fn newest(state: &CallerState, job: Uuid, number: u32) -> Result<Option<Record>, Problem> {
    Ok(state.jobs.latest_record(job, number, RecordKind::Correction).await?)
}

/// Returns the record of what was entered before an iteration of `measurand` that is about to be
/// stored: after the newest correction of the flank's iteration before it, or of the gear.
pub async fn before_next(
    state: &CallerState,
    job: Uuid,
    measurand: &Measurand,
    asked: &AppliedRequestBody,
) -> Result<RecordDraft, Problem> {
    let wanted = Predecessors { of: measurand.clone(), from: 1, before: None, most: 1 };
    let Some(previous) = state.jobs.predecessors(job, wanted).await?.pop() else {
        let detail = format!("the job has no earlier iteration of {} that was corrected", measurand.words());
        return Err(Problem::invalid(Faults::one("/applied", detail)));
    };
    let own = newest(state, job, previous.number).await?.map(|correction| (previous.number, correction));
    // the newer of the corrections of the iteration and of the gear
    let newest = own.into_iter().chain(newest_of_gear(state, job).await?).max_by_key(|(_, made)| made.created_at);
    match newest {
        Some((number, correction)) => applied::draft(asked, &correction, number, "/applied"),
        None => {
            let detail = format!("iteration {}, the last of {}, has no correction", previous.number, measurand.words());
            Err(Problem::invalid(Faults::one("/applied", detail)))
        }
    }
}
