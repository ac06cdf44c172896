//! `/v1/jobs/{job_id}/iterations`: nodes measured, their first fit, what was decided.

use super::prelude::*;
use crate::{
    api::{
        fits::{nodes_text, spec::nodes::NodesBody},
        gears::design_at_nodes::{self, DesignAtNodesBody},
        jobs::{
            iteration_requests::{IterationForm, IterationPatchBody, IterationRequest, Measurement},
            iterations::IterationBody,
            listed_iterations::ListedIterationBody,
        },
        json::writer,
    },
    http::layers::{chunked, compute::read_fit_and},
    jobs::{Iteration, NewIteration},
    usecases::{decide, iterate},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_iteration, list_iterations))
        .routes(routes!(get_iteration, update_iteration))
        .routes(routes!(get_iteration_nodes))
        .routes(routes!(get_iteration_design))
}

/// Create an iteration from nodes
///
/// Fits the nodes and stores both in one transaction as the job's next iteration. The fit is the
/// chosen one until another is chosen. A request that is repeated with the same `Idempotency-Key`
/// gets the first response and stores nothing.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations", operation_id = "create_iteration", tag = "iterations",
    params(IdempotencyKey),
    request_body(
        content((IterationRequest = "application/json"), (IterationForm = "multipart/form-data")),
        description = "Nodes, the model to fit, and details of the measurement."
    ),
    responses(
        (status = 201, description = "The iteration with its first fit, which is chosen until another one is.",
            body = NewIterationBody)
    )
)]
async fn create_iteration(PathOf(job): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(move |state, payload, key| async move {
        let of = state.jobs.known_job(job).await?;
        let plans = state.plans.clone();
        let work = move |nodes, spec, measurement: Measurement, mapping| {
            iterate::measured(nodes, spec, measurement, mapping, &of, &plans)
        };
        let measured = read_fit_and(&state, payload, work).await?;
        let keyed = key.map(|key| key.answered_by(created));
        let (iteration, stored) = iterate::add(state.context(), job, measured, keyed).await?;
        Ok(created(&iteration, stored))
    })
    .await
}

/// A new iteration as it is answered.
pub fn created(iteration: &NewIteration, stored: Stored) -> Answer {
    Answer::created(
        format!("/v1/jobs/{}/iterations/{}", iteration.job_id, stored.number),
        etag(stored.version),
        NewIterationBody::text(iteration, stored),
    )
}

/// List the iterations of a job
///
/// Iterations come by number in pages, each with the results of its chosen fit. Slopes, crownings
/// and twist are included if the axes place the nodes on a flank of the job's gear.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations", operation_id = "list_iterations", tag = "iterations",
    params(PageQuery),
    responses((status = 200, description = "A page of iterations.", body = PageBody<ListedIterationBody>))
)]
async fn list_iterations(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<ListedIterationBody>>, Problem> {
    let page = state.jobs.iterations(job, query.check(List::Iterations)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Iterations)))
}

/// Get an iteration
///
/// The response lists the last hundred fits with their results. `GET …/fits` lists all of them,
/// `GET …/fits/{fit_id}` has each in full.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}", operation_id = "get_iteration", tag = "iterations",
    responses((status = 200, description = "The iteration.", body = IterationBody))
)]
async fn get_iteration(state: CallerState, PathOf((job, number)): PathOf<(Uuid, u32)>) -> Result<Response, Problem> {
    Ok(present(&state.jobs.iteration(job, number).await?))
}

/// Update an iteration or decide on the gear
///
/// Changes flank, tooth, axes or units of the nodes, or records a decision. The job's trace keeps
/// every decision with its reason, and every change with the previous values. If a change gives the
/// chosen fit other gear figures, the fit is stored again with these figures and chosen.
#[utoipa::path(
    patch, path = "/v1/jobs/{job_id}/iterations/{number}", operation_id = "update_iteration", tag = "iterations",
    params(IfMatch),
    request_body(content = IterationPatchBody, description = "The decision, or the changes of the nodes' description."),
    responses((status = 200, description = "The iteration after the change.", body = IterationBody))
)]
async fn update_iteration(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    IfMatch(precondition): IfMatch,
    JsonOf(patch): JsonOf<IterationPatchBody>,
) -> Result<Response, Problem> {
    let iteration = state.jobs.iteration(job, number).await?;
    Ok(present(&decide::update(state.context(), iteration, patch, precondition).await?))
}

/// An iteration as it is answered.
pub fn present(iteration: &Iteration) -> Response {
    let mut response = json(IterationBody::text(iteration));
    set_etag(response.headers_mut(), iteration.version);
    response
}

/// Get the nodes of an iteration
///
/// Returns exactly the posted numbers, missing nodes included, as JSON or CSV.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/nodes", operation_id = "get_iteration_nodes", tag = "iterations",
    responses(
        (status = 200, description = "The nodes. They never change.",
            content((NodesBody = "application/json"), (String = "text/csv")))
    )
)]
async fn get_iteration_nodes(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Csv, "Nodes")?;
    let (nodes, permit) = nodes::stored(state.context(), job, number).await?.into_parts();
    let work = move || {
        let mut file = match format {
            Format::Csv => nodes_text::to_csv(Arc::new(nodes)),
            _ => nodes_text::to_json(Arc::new(nodes)),
        };
        (file.next_piece(chunked::PIECE).unwrap_or_default(), file)
    };
    let (first, file) = state.pool.run(work).await?;
    let mut response = format.response(Vec::new());
    *response.body_mut() = chunked::body(state.app, first, file, permit);
    let headers = response.headers_mut();
    // Nodes never change, so each form has one tag.
    headers.insert(header::ETAG, HeaderValue::from_static(if format == Format::Csv { "\"csv\"" } else { "\"json\"" }));
    Ok(response)
}

/// Get the design at the nodes of an iteration
///
/// Returns the deviations of a flank that is made as the `design` in the job's requirements says.
/// Measured deviations minus these are the deviations from the design.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/design", operation_id = "get_iteration_design",
    tag = "iterations",
    responses(
        (status = 200, description = "The design at the nodes.", body = DesignAtNodesBody),
        (status = 409, description = "The job has no design or no gear, the iteration no flank or axes, or the design \
            is impossible on its flank.")
    )
)]
async fn get_iteration_design(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
) -> Result<Response, Problem> {
    let iteration = state.jobs.iteration(job, number).await?;
    let job = state.jobs.job(job).await?;
    let (nodes, _permit) = nodes::stored(state.context(), job.id, number).await?.into_parts();
    let work = move || {
        let found = design_at_nodes::at_nodes(&job, &iteration.measurand, &nodes)?;
        writer::whole(&found).map_err(Problem::not_finite)
    };
    Ok(json(state.pool.run(work).await??))
}
