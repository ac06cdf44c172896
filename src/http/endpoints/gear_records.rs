//! Deviations, evaluations, pitches and corrections kept with an iteration.

use super::prelude::*;
use super::records::{NewRecord, RecordContext, RecordRequest};
use crate::{
    api::gears::{
        correction::{csv::OutsideLimitsName, request::CorrectionRequestBody, stored::CorrectionBody},
        deviations::{self, request::DeviationsRequestBody},
        evaluation::{
            self,
            pitch::{self, PitchRequestBody},
            request::EvaluateBody,
        },
        gear::of_job,
        requirements::RequirementsBody,
    },
    http::layers::include::CorrectionQuery,
    usecases::correct::{self, Basis},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_iteration_deviations))
        .routes(routes!(create_iteration_evaluation))
        .routes(routes!(create_iteration_pitch))
        .routes(routes!(create_iteration_correction, get_iteration_correction))
}

/// Add deviations to an iteration
///
/// Computes the deviations of measured points and stores them with the iteration. The points may be
/// those of the iteration's nodes or others of the same gear. The gear is that of the job unless
/// the request has one.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/deviations", operation_id = "create_iteration_deviations",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = DeviationsRequestBody, description = "Points or a grid; the gear is that of the job unless \
        the request has one."),
    responses(
        (status = 201, description = "The record with the result of `POST /v1/gears/deviations`.", body = RecordBody)
    )
)]
async fn create_iteration_deviations(request: RecordRequest) -> Result<Response, Problem> {
    let build = |text: &[u8], context: &RecordContext, room: Room| {
        let built = deviations::build(text, of_job(&context.job)?.as_ref(), Some(&context.measurand), room)?;
        Ok(context.gear_record(RecordKind::Deviations, text, built)?.into())
    };
    request.keep(build).await
}

/// Add an evaluation of traces to an iteration
///
/// As `POST /v1/gears/evaluate`, with the gear of the job unless the request has one. Without
/// `tolerance_limits` or `k_bands` in `evaluation`, those of the job's `requirements` apply and are
/// repeated in the response. Later changes of the requirements do not affect the record. With
/// `Accept: application/x-q-das-dfq` the response is a file for statistical process control.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/evaluations", operation_id = "create_iteration_evaluation",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = EvaluateBody, description = "Traces and settings of the evaluation; the gear is that of \
        the job unless the request has one."),
    responses(
        (status = 201, description = "The record with the result of `POST /v1/gears/evaluate`.",
            content((RecordBody = "application/json"), (String = "application/x-q-das-dfq")))
    )
)]
async fn create_iteration_evaluation(headers: HeaderMap, request: RecordRequest) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Dfq, "Evaluations")?;
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        let required = RequirementsBody::of(&context.job);
        let built = evaluation::build(text, of_job(&context.job)?.as_ref(), Some(&context.measurand), required)?;
        Ok(context.gear_record(RecordKind::Evaluation, text, built)?.into())
    };
    request.keep_as(format, build).await
}

/// Add an evaluation of pitches to an iteration
///
/// As `POST /v1/gears/pitch`, with the gear of the job unless the request has one. Pitches cover
/// all teeth. If the iteration has a flank, pitches of the other flank alone are refused. Without
/// `pitch_limits`, those of the job's `requirements` apply and are repeated in the response. With
/// `Accept: application/x-q-das-dfq` the response is a file for statistical process control.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/pitch", operation_id = "create_iteration_pitch",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = PitchRequestBody, description = "Positions of the flanks; the gear is that of the job \
        unless the request has one."),
    responses(
        (status = 201, description = "The record with the result of `POST /v1/gears/pitch`.",
            content((RecordBody = "application/json"), (String = "application/x-q-das-dfq")))
    )
)]
async fn create_iteration_pitch(headers: HeaderMap, request: RecordRequest) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Dfq, "Pitches")?;
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        let required = RequirementsBody::of(&context.job);
        let built = pitch::build(text, of_job(&context.job)?.as_ref(), Some(&context.measurand), required.as_ref())?;
        Ok(context.gear_record(RecordKind::Pitch, text, built)?.into())
    };
    request.keep_as(format, build).await
}

/// Compute a correction for an iteration
///
/// Computes changes of machine settings from the deviations (µm) at the iteration's nodes, and
/// stores them with the iteration. The sensitivity is a matrix, or the motions of a form or
/// generating grinder; these need flank, axes and gear. The correction is compared with the next
/// iteration of the job.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/correction", operation_id = "create_iteration_correction",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = CorrectionRequestBody, description = "Sensitivity, limits and uncertainty of the settings."),
    responses(
        (status = 201, description = "The changes and their predicted effect.", body = CorrectionBody),
        (status = 409, description = "The units of the iteration are implausible (`implausible_unit`), or the first \
            request with this idempotency key is still running.")
    )
)]
async fn create_iteration_correction(request: RecordRequest) -> Result<Response, Problem> {
    let basis = async |state: CallerState, job, number| correct::basis_of_iteration(state.context(), job, number).await;
    request.keep_of(basis, corrected).await
}

/// Computes the correction that a request asks for.
pub fn corrected(text: &[u8], basis: &Basis, room: Room) -> Result<NewRecord, Problem> {
    let (draft, shown) = basis.correct(text, room)?;
    Ok(NewRecord { draft, shown: Some(shown) })
}

/// Get the latest correction of an iteration
///
/// Its prediction is compared with the next iteration of the same flank and tooth, for the gear
/// that the job had at the time of the correction. The comparison uses the entered changes
/// (`applied`) if there are any, else the proposed ones. `not_compared` gives the reason if it is
/// not possible. Values for each node and the fits of the settings are returned with `include`.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/correction", operation_id = "get_iteration_correction",
    tag = "iterations",
    params(
        ("include" = Option<Vec<StoredIncludeName>>, Query, style = Form, explode = false, description = "Additional \
            parts of the response: names separated by commas."),
        ("outside_limits" = Option<OutsideLimitsName>, Query, description = "For CSV: `allowed` if predicted figures \
            may be outside the limits of the job.")
    ),
    responses(
        (status = 409, description = "For CSV: predicted figures are outside their limits \
            (`predicted_outside_limits`)."),
        (status = 200, description = "The correction, with prediction and measurement once there is a next iteration. \
            CSV has a line for each setting, for the control of the machine: the change rounded to its increment, \
            also in words, and its purpose, with the names of OPC UA for Geometrical Measuring Systems.",
                content((CorrectionBody = "application/json"), (String = "text/csv")))
    )
)]
async fn get_iteration_correction(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    QueryOf(query): QueryOf<CorrectionQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (format, form) = query.form(&headers)?;
    Ok(format.response(correct::of_iteration(state.context(), job, number, form).await?))
}
