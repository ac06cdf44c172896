//! `/v1/jobs/{job_id}/streams` and `/v1/streams/{stream_id}`: nodes that arrive while the probe is
//! still moving.

use std::time::Instant;

use super::iterations;
use super::prelude::*;
use crate::{
    api::{
        gears::fit_figures::OfFlank,
        jobs::{fits, iteration_requests::MeasurementDetailsBody, problem::of_measured},
        streams::{
            listed::{self, ListedStreamBody, StreamNodesBody},
            stream::{self, BlockBody, EstimateBody, NewStreamBody, StreamBody},
        },
    },
    http::layers::{compute::read_optional_json, idempotency::ClaimedKey},
    jobs::{KeyedRequest, NewStream, PostedBlock},
    telemetry,
};
use flankfit_engine::estimation::FitSpec;

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_stream, list_streams))
        .routes(routes!(get_stream, delete_stream))
        .routes(routes!(add_stream_nodes, get_stream_nodes))
        .routes(routes!(finish_stream))
}

/// Open a stream
///
/// A stream fits a model to nodes as they arrive. The spec is checked as far as possible without
/// nodes. Blocks of nodes follow, and finally the stream becomes an iteration.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/streams", operation_id = "create_stream", tag = "streams",
    params(IdempotencyKey),
    request_body(content = NewStreamBody, description = "A fit request without nodes, and the forgetting factor."),
    responses((status = 201, description = "The stream, without blocks yet.", body = StreamBody))
)]
async fn create_stream(PathOf(job): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(move |state, payload, key| async move {
        state.jobs.known_job(job).await?;
        let draft = read_json(&state, payload, stream::read_stream).await?;
        let keyed = key.map(|key| key.answered_by(opened));
        let (stream, stored) =
            state.jobs.open_stream(job, draft, keyed).await.map_err(|error| of_measured(error, "/tooth"))?;
        Ok(opened(&stream, stored))
    })
    .await
}

fn opened(stream: &NewStream, stored: Stored) -> Answer {
    Answer::created(format!("/v1/streams/{}", stream.id), etag(stored.version), stream::created(stream))
}

/// List the streams of a job
///
/// Open streams and those that have become an iteration come oldest first in pages, without specs
/// and estimates.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/streams", operation_id = "list_streams", tag = "streams",
    params(PageQuery),
    responses((status = 200, description = "A page of streams.", body = PageBody<ListedStreamBody>))
)]
async fn list_streams(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<ListedStreamBody>>, Problem> {
    let page = state.jobs.streams(job, query.check(List::Streams)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Streams)))
}

/// Which blocks are wanted.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct BlocksQuery {
    /// Number of the last known block; 0 before the first.
    #[param(value_type = Option<u64>, minimum = 0, default = 0)]
    after: Option<String>,
}

/// Memory for blocks that are read at a time, as they are stored, as nodes and as text.
const BLOCKS_IN_MEMORY: usize = 64 << 20;

/// List the blocks of a stream
///
/// Returns the posted nodes of an open stream, block by block after the block number `after`. A
/// page holds up to a few megabytes, and at least one block if there is one. `sequence` is the
/// number of the stream's last block: request the next page until it is reached. The nodes of a
/// finished stream are those of its iteration.
#[utoipa::path(
    get, path = "/v1/streams/{stream_id}/nodes", operation_id = "get_stream_nodes", tag = "streams",
    params(BlocksQuery),
    responses((status = 200, description = "Some blocks.", body = StreamNodesBody))
)]
async fn get_stream_nodes(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    QueryOf(query): QueryOf<BlocksQuery>,
) -> Result<Response, Problem> {
    let after = match query.after.as_deref().map(str::parse::<u64>) {
        None => 0,
        Some(Ok(after)) => after,
        Some(Err(_)) => return Err(Problem::invalid(Faults::one("/after", "it must be a whole number of at least 0"))),
    };
    let permit = state.budget.take(BLOCKS_IN_MEMORY)?;
    let (stream, blocks) = state.jobs.stream_blocks(id, after).await?;
    let text = state.pool.run(move || listed::blocks(&stream, blocks)).await??;
    Ok(with_permit(json(text), permit))
}

/// Get a stream
///
/// Returns the estimate after the last block, or the iteration that the stream has become.
#[utoipa::path(
    get, path = "/v1/streams/{stream_id}", operation_id = "get_stream", tag = "streams",
    responses((status = 200, description = "The stream.", body = StreamBody))
)]
async fn get_stream(state: CallerState, PathOf(id): PathOf<Uuid>) -> Result<Response, Problem> {
    let (stream, estimate) = state.jobs.stream_with_estimate(&state.app, id).await?;
    let input_sha256 = stream.input_sha256;
    let estimate = match estimate {
        Some(estimate) => Some(state.pool.run(move || stream::estimate_text(&estimate, &input_sha256)).await??),
        None => None,
    };
    let mut response = json(stream::stream(&stream, estimate));
    set_etag(response.headers_mut(), stream.version);
    Ok(response)
}

/// Add a block of nodes to a stream
///
/// Returns the estimate of all nodes so far. The client numbers blocks from 1. A block that is sent
/// again with the same nodes gets its first response and does not count again. A block out of order
/// is refused with the expected number.
#[utoipa::path(
    post, path = "/v1/streams/{stream_id}/nodes", operation_id = "add_stream_nodes", tag = "streams",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "Repeating the request with the same key and body \
            returns the first response. (Repeated blocks are also recognised by number and nodes.)",
            min_length = 1, max_length = 255, pattern = "^[!-~]+$")
    ),
    request_body(content = BlockBody, description = "The next block, or one that was sent before."),
    responses(
        (status = 200, description = "The estimate after this block. A block sent again gets its first response.",
            body = EstimateBody, headers(
            ("ETag" = String, description = "Version of the stream after this block.")
        )),
        (status = 409, description = "Another block is expected next, the block was sent before with other nodes, or \
            the stream is finished.")
    )
)]
async fn add_stream_nodes(PathOf(id): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(move |state, payload, key| async move {
        let block = read_json(&state, payload, stream::read_block).await?;
        add_block(&state, id, block, key.map(ClaimedKey::request)).await
    })
    .await
}

/// Adds a block that came as a request or as a message.
pub async fn add_block(
    state: &CallerState,
    id: Uuid,
    block: PostedBlock,
    key: Option<KeyedRequest>,
) -> Result<Answer, Problem> {
    let begun = Instant::now();
    let answer = state.jobs.add_block(&state.app, id, block, key).await;
    metrics::histogram!(telemetry::BLOCK_SECONDS).record(begun.elapsed().as_secs_f64());
    answer
}

/// Finish a stream
///
/// The stream becomes an iteration of its job: all nodes are fitted at once with full weight. The
/// forgetting factor applies to the estimates of an open stream only. The response is that of `POST
/// /v1/jobs/{job_id}/iterations`.
#[utoipa::path(
    post, path = "/v1/streams/{stream_id}/finish", operation_id = "finish_stream", tag = "streams",
    params(IdempotencyKey),
    request_body(content = Option<MeasurementDetailsBody>, description = "Details of the measurement; the body may be \
        empty."),
    responses(
        (status = 201, description = "The iteration, as if its nodes had been posted together.",
            body = NewIterationBody),
        (status = 409, description = "The stream is already finished or has no nodes, or the first request with this \
            idempotency key is still running.")
    )
)]
async fn finish_stream(PathOf(id): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(move |state, payload, key| async move {
        let body: MeasurementDetailsBody = read_optional_json(&state, payload).await?;
        let plans = state.plans.clone();
        let stream = state.jobs.stream(id).await?;
        let job = state.jobs.known_job(stream.job_id).await?;
        let on = OfFlank::of(&job, &stream.measurand);
        let fit = move |nodes: &Nodes, spec: &FitSpec| fits::compute_on(nodes, spec, &plans, on.as_ref());
        let keyed = key.map(|key| key.answered_by(iterations::created));
        let (iteration, stored) = state.jobs.finish_stream(&state.app, id, body.into(), fit, keyed).await?;
        Ok(iterations::created(&iteration, stored))
    })
    .await
}

/// Delete a stream
///
/// The nodes of an open stream are lost. The iteration of a finished stream is kept.
#[utoipa::path(
    delete, path = "/v1/streams/{stream_id}", operation_id = "delete_stream", tag = "streams",
    params(IfMatch),
    responses((status = 204, description = "The stream is deleted."))
)]
async fn delete_stream(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    IfMatch(precondition): IfMatch,
) -> Result<StatusCode, Problem> {
    state.jobs.delete_stream(id, precondition).await?;
    Ok(StatusCode::NO_CONTENT)
}
