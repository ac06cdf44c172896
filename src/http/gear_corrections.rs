//! Corrections of the gear: by all teeth of both flanks that were measured since the last one.

use axum::{http::HeaderMap, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    accept::Format,
    caller_state::CallerState,
    entered::entered_after,
    extract::{PathOf, QueryOf},
    idempotency::IdempotencyKey,
    include::CorrectionQuery,
    records::{JobRecordRequest, NewRecord, gear_record},
    rounds::{Iterations, measured_of, newest, tooth_shift},
    state::AppState,
};
use crate::{
    api::{
        faults::Faults,
        gears::{
            correction::{
                self,
                blocks::Subject,
                csv::{self, OutsideLimitsName},
                include::{CorrectionInclude, StoredIncludeName},
                request::CorrectionRequestBody,
                result::CorrectionBody,
                round::{self, MadeFor, Round},
                same_nodes::Measured,
                sensitivity::Level,
                stored::StoredCorrectionBody,
            },
            gear::of_job,
            requirements::RequirementsBody,
        },
        problem::{Problem, ProblemCode, Room},
    },
    jobs::{Job, RecordKind, Rounds},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_gear_correction, get_gear_correction))
}

/// What a correction of the gear is made of.
struct GearContext {
    job: Job,
    iterations: Iterations,
}

/// Computes changes of machine settings by all teeth of both flanks that were measured since the
/// last correction, and keeps them with the last of these iterations.
///
/// Of each flank the deviations are averaged over the teeth, and both flanks are corrected by the
/// same settings. A tooth that was measured more than once counts by its newest iteration. Where
/// nothing was measured after the last correction, the new one is made for the same iterations.
/// Teeth are chosen by `teeth`.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/correction", operation_id = "create_gear_correction", tag = "jobs",
    params(
        ("job_id" = Uuid, Path),
        IdempotencyKey
    ),
    request_body(content = CorrectionRequestBody, description = "What the settings do, how far they may go, and how \
        far that is trusted."),
    responses(
        (status = 201, description = "The changes and what they should bring.", body = CorrectionBody,
            headers(("Location" = String, description = "Where the record is."))),
        (status = 409, description = "The units of an iteration are implausible (`implausible_unit`), or the first \
            request with this idempotency key is still running.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn create_gear_correction(request: JobRecordRequest) -> Result<Response, Problem> {
    let context = async |state: CallerState, job| {
        let of = state.jobs.job(job).await?;
        let rounds = state.jobs.rounds(job).await?;
        let numbers: Vec<u32> = rounds.current().iter().map(|one| one.number).collect();
        let Some(last) = numbers.iter().copied().max() else { return Err(nothing_measured(&rounds)) };
        let iterations = measured_of(&state, job, &numbers).await?;
        Ok((last, GearContext { job: of, iterations }))
    };
    let build = |text: &[u8], context: &GearContext, room: Room| {
        room(aligned(&context.iterations))?;
        let gear = of_job(&context.job)?;
        let required = RequirementsBody::of(&context.job);
        let subject = Subject {
            level: Level::Gear,
            measured: list(&context.iterations),
            other: None,
            gear: gear.as_ref(),
            requirements: required.as_ref(),
        };
        let (built, include) = correction::build(text, &subject)?;
        let draft = gear_record(&context.job, RecordKind::GearCorrection, text, built)?;
        let answer = include.of_result(&draft.result)?.into_bytes();
        Ok(NewRecord { draft, answer: Some(answer.into()) })
    };
    request.keep_of("correction", context, build).await
}

fn nothing_measured(rounds: &Rounds) -> Problem {
    let detail = match rounds.iterations.len() {
        0 => "the job has no iteration: measure a flank before correcting the gear",
        _ => {
            "no iteration that was measured since the last correction says which flank it is of: send `flank` by \
             `PATCH` of the iteration"
        }
    };
    Problem::invalid(Faults::one("", detail))
}

/// The correction of the gear that was made last, with what the next round measured of it.
///
/// The next round is what was measured after the correction and before the next one. Its means are
/// compared with those that are predicted for the changes that were entered, and the scatter of the
/// teeth is in the errors of both. By `Accept: text/csv` it is answered for the control of the
/// machine, a line for each setting.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/correction", operation_id = "get_gear_correction", tag = "jobs",
    params(
        ("job_id" = Uuid, Path),
        ("include" = Option<Vec<StoredIncludeName>>, Query, style = Form, explode = false, description = "What is \
            answered beside: names with commas between them."),
        ("outside_limits" = Option<OutsideLimitsName>, Query, description = "Of the CSV: that the predicted figures \
            may lie outside their limits.")
    ),
    responses(
        (status = 200, description = "The correction with its request, and the answer of the machine once there is \
            one. As CSV a line for each setting, named as in OPC UA for Geometrical Measuring Systems.",
            content((StoredCorrectionBody = "application/json"), (String = "text/csv"))),
        (status = 406, description = "Neither application/json nor text/csv is accepted.", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "As CSV: predicted figures lie outside their limits \
            (`predicted_outside_limits`).", body = Problem, content_type = "application/problem+json")
    )
)]
async fn get_gear_correction(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<CorrectionQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Csv, "Corrections")?;
    let names: Vec<StoredIncludeName> = query.names()?;
    let include = CorrectionInclude::of_stored(&names);
    let of = state.jobs.job(job).await?;
    let rounds = state.jobs.rounds(job).await?;
    let Some((made, record)) = newest(&state, job, &rounds).await? else { return Err(none()) };
    let MadeFor { flanks, iterations } = MadeFor::of(&record)?;
    if format == Format::Csv {
        let allowed = query.outside_limits == Some(OutsideLimitsName::Allowed);
        let written = move || csv::write(&record, &csv::About { job: &of, flanks, iterations: &iterations }, allowed);
        return Ok(format.response(state.pool.run(written).await??));
    }
    let later: Vec<u32> = rounds.after(made).iter().map(|one| one.number).collect();
    let applied = entered_after(&state, job, &record, made.number, &later).await?;
    let before = if later.is_empty() { Vec::new() } else { measured_of(&state, job, &iterations).await? };
    let after = measured_of(&state, job, &later).await?;
    let shift = tooth_shift(&state, job, &iterations, &later).await?;
    let today = of_job(&of)?;
    let _aligned = state.budget.take(aligned(&before) + aligned(&after))?;
    let write = move || {
        let round = Round { before: list(&before), after: list(&after) };
        round::write(&record, applied, &round, shift, today.as_ref(), include)
    };
    Ok(format.response(state.pool.run(write).await??))
}

/// Returns the bytes that a mean over teeth takes: deviations and residuals of each tooth at the
/// nodes of the one with most of them.
fn aligned(iterations: &Iterations) -> usize {
    let most = iterations.iter().map(|one| one.nodes.posted()).max().unwrap_or(0);
    2 * size_of::<f64>() * most * iterations.len()
}

fn list(iterations: &Iterations) -> Vec<&Measured> {
    iterations.iter().map(|one| &**one).collect()
}

fn none() -> Problem {
    Problem::new(ProblemCode::NotFound, "The job has no correction of the gear.")
}
