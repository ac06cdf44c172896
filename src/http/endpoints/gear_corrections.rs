//! Corrections of the gear: by all teeth of both flanks that were measured since the last one.

use super::prelude::*;
use super::{gear_records::corrected, records::JobRecordRequest};
use crate::{
    api::gears::correction::{csv::OutsideLimitsName, request::CorrectionRequestBody, stored::CorrectionBody},
    http::layers::include::CorrectionQuery,
    usecases::correct,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_gear_correction, get_gear_correction))
}

/// Compute a correction for a gear
///
/// Uses all teeth of both flanks measured since the last correction, and is stored with the last of
/// these iterations. The deviations of each flank are averaged over the teeth, and both flanks are
/// corrected by the same settings. A tooth that was measured more than once counts by its newest
/// iteration. If nothing was measured after the last correction, the new one uses the same
/// iterations. `teeth` selects teeth.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/correction", operation_id = "create_gear_correction", tag = "jobs",
    params(IdempotencyKey),
    request_body(content = CorrectionRequestBody, description = "Sensitivity, limits and uncertainty of the settings."),
    responses(
        (status = 201, description = "The changes and their predicted effect.", body = CorrectionBody),
        (status = 409, description = "The units of an iteration are implausible (`implausible_unit`), or the first \
            request with this idempotency key is still running.")
    )
)]
async fn create_gear_correction(request: JobRecordRequest) -> Result<Response, Problem> {
    let basis = async |state: CallerState, job| correct::basis_of_gear(state.context(), job).await;
    request.keep_of(basis, corrected).await
}

/// Get the latest correction of a gear
///
/// The next round consists of the measurements after this correction and before the next one. Its
/// means are compared with the prediction for the entered changes; the errors of both include the
/// scatter of the teeth. With `Accept: text/csv` the response has a line for each setting, for the
/// control of the machine.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/correction", operation_id = "get_gear_correction", tag = "jobs",
    params(
        ("include" = Option<Vec<StoredIncludeName>>, Query, style = Form, explode = false, description = "Additional \
            parts of the response: names separated by commas."),
        ("outside_limits" = Option<OutsideLimitsName>, Query, description = "For CSV: `allowed` if predicted figures \
            may be outside the limits of the job.")
    ),
    responses(
        (status = 200, description = "The correction with its request, and the response of the machine once there is \
            one. CSV has a line for each setting, with the names of OPC UA for Geometrical Measuring Systems.",
                content((CorrectionBody = "application/json"), (String = "text/csv"))),
        (status = 409, description = "For CSV: predicted figures are outside their limits \
            (`predicted_outside_limits`).")
    )
)]
async fn get_gear_correction(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<CorrectionQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (format, form) = query.form(&headers)?;
    Ok(format.response(correct::of_gear(state.context(), job, form).await?))
}
