//! `…/iterations/{number}/fits`: further fits of stored nodes, the choice among them, and replays.

use super::iterations::present;
use super::prelude::*;
use crate::{
    api::{
        fits::spec::include::IncludeName,
        gears::fit_figures::OfFlank,
        jobs::{
            fits::{ReplayBody, ReplayRequest},
            iteration_requests::{ChosenFitBody, RefitRequest},
            iterations::{FitSummaryBody, IterationBody, IterationFitBody},
        },
    },
    http::layers::{compute::read_optional_json, include::IncludeQuery},
    jobs::NewFit,
    usecases::fit,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_iteration_fit, list_iteration_fits))
        .routes(routes!(get_iteration_fit))
        .routes(routes!(choose_fit))
        .routes(routes!(replay_fit))
}

/// Fit the nodes of an iteration again
///
/// Uses another λ* or model. The fit is not used until it is chosen. All fits of the iteration are
/// kept for comparison.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/fits", operation_id = "create_iteration_fit",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = RefitRequest, description = "A fit request without nodes."),
    responses((status = 201, description = "The fit.", body = IterationFitBody))
)]
async fn create_iteration_fit(PathOf((job, number)): PathOf<(Uuid, u32)>, post: Post) -> Result<Response, Problem> {
    let place = format!("/v1/jobs/{job}/iterations/{number}");
    post.once(move |state, payload, key| async move {
        let nodes = nodes::stored(state.context(), job, number).await?;
        let measurand = state.jobs.measurand(job, number).await?;
        let own = state.jobs.known_job(job).await?;
        let on = OfFlank::of(&own, &measurand);
        let plans = state.plans.clone();
        let refit = read_json(&state, payload, move |text| fit::refitted(text, nodes, on.as_ref(), &plans)).await?;
        let answer = move |fit: &NewFit, stored: Stored| created(&place, fit, stored);
        let keyed = key.map(|key| key.answered_by(answer.clone()));
        let (fit, stored) = fit::add(state.context(), (job, number), refit, keyed).await?;
        Ok(answer(&fit, stored))
    })
    .await
}

fn created(place: &str, fit: &NewFit, stored: Stored) -> Answer {
    Answer::created(format!("{place}/fits/{}", fit.id), etag(stored.version), IterationFitBody::of(fit, false).text())
}

/// List the fits of an iteration
///
/// Fits come in the order in which they were made, with their main results. `GET …/fits/{fit_id}`
/// returns each in full.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/fits", operation_id = "list_iteration_fits", tag = "iterations",
    params(PageQuery),
    responses((status = 200, description = "A page of fits.", body = PageBody<FitSummaryBody>))
)]
async fn list_iteration_fits(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<FitSummaryBody>>, Problem> {
    let page = state.jobs.fits(job, number, query.check(List::Fits)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Fits)))
}

/// Get a fit
///
/// Returns the stored response byte for byte. The parts that `include` names are computed from the
/// stored nodes and added. `spec` can be changed and sent back as a refit.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}", operation_id = "get_iteration_fit",
    tag = "iterations",
    params(
        ("include" = Option<Vec<IncludeName>>, Query, style = Form, explode = false, description = "Additional parts \
            of the response: names separated by commas.")
    ),
    responses(
        (status = 200, description = "The fit. It never changes except for `chosen`.",
            body = IterationFitBody, headers(("ETag" = String,
                description = "Changes only when this fit is chosen or another one is chosen instead. Absent with \
                    `include`."))),
        (status = 422, description = "`include` has an unknown name.")
    )
)]
async fn get_iteration_fit(
    state: CallerState,
    PathOf((job, number, fit)): PathOf<(Uuid, u32, Uuid)>,
    QueryOf(query): QueryOf<IncludeQuery>,
) -> Result<Response, Problem> {
    let names: Vec<IncludeName> = query.names()?;
    let stored = state.jobs.fit(job, number, fit).await?;
    if names.is_empty() {
        let mut response = json(IterationFitBody::stored(&stored, &stored.result).text());
        // nothing else of it can change
        let tag = if stored.chosen { "\"chosen\"" } else { "\"not-chosen\"" };
        response.headers_mut().insert(header::ETAG, HeaderValue::from_static(tag));
        return Ok(response);
    }
    Ok(json(fit::with_include(state.context(), (job, number), stored, names).await?))
}

/// Choose a fit of an iteration
///
/// Each choice is a new row in the trace; no fit is overwritten or deleted.
#[utoipa::path(
    put, path = "/v1/jobs/{job_id}/iterations/{number}/chosen-fit", operation_id = "choose_fit", tag = "iterations",
    params(IfMatch),
    request_body(content = ChosenFitBody, description = "The chosen fit."),
    responses((status = 200, description = "The iteration with its new choice.", body = IterationBody))
)]
async fn choose_fit(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    IfMatch(precondition): IfMatch,
    JsonOf(chosen): JsonOf<ChosenFitBody>,
) -> Result<Response, Problem> {
    let reason = chosen.reason.map(String::from);
    let iteration = state.jobs.choose_fit(job, number, chosen.fit_id, reason, precondition).await?;
    Ok(present(&iteration))
}

/// Replay a fit
///
/// Computes the fit again from the stored nodes and compares the results bit by bit. This shows
/// that a result can be reproduced, with this or a later version of the program. The body is empty
/// or `{}`. Nothing is stored.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}/replay", operation_id = "replay_fit",
    tag = "iterations",
    responses((status = 200, description = "The comparison of the two results.", body = ReplayBody))
)]
async fn replay_fit(
    state: CallerState,
    PathOf((job, number, fit)): PathOf<(Uuid, u32, Uuid)>,
    payload: Payload,
) -> Result<axum::Json<ReplayBody>, Problem> {
    let ReplayRequest {} = read_optional_json(&state, payload).await?;
    Ok(axum::Json(fit::replay(state.context(), (job, number), fit).await?))
}
