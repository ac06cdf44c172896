//! `…/iterations/{number}/curves` and `…/surfaces`: shapes kept with an iteration, made of its
//! nodes or of others.

use axum::{extract::State, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    body::Payload,
    extract::PathOf,
    idempotency::IdempotencyKey,
    records::{About, keep},
    state::AppState,
};
use crate::{
    api::{
        curves::{self, request::KeptCurveRequest},
        jobs::records::{self, RecordBody},
        problem::Problem,
        surfaces::{self, request::SurfaceRequest},
    },
    jobs::RecordKind,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_iteration_curve)).routes(routes!(create_iteration_surface))
}

/// Builds a curve, by default of the iteration's own nodes, and keeps it with the iteration.
///
/// As `POST /v1/curves`; the answer stays with the iteration as a record.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/curves", operation_id = "create_iteration_curve",
    tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response \
            again.", min_length = 1, max_length = 255, pattern = "^[!-~]+$")
    ),
    request_body(content = KeptCurveRequest, description = "A method, and points where the iteration's own are not \
        meant."),
    responses(
        (status = 201, description = "The curve, kept.", body = RecordBody,
            headers(("Location" = String, description = "Where the curve is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn create_iteration_curve(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], about: &About| {
        Ok(records::draft(RecordKind::Curve, text, curves::build(text, Some(&about.nodes))?)?.into())
    };
    keep(state, (job, number), "curves", key, payload, build).await
}

/// Builds a surface, by default of the iteration's own nodes, and keeps it with the iteration.
///
/// As `POST /v1/surfaces`; the answer stays with the iteration as a record.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/surfaces", operation_id = "create_iteration_surface",
    tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response \
            again.", min_length = 1, max_length = 255, pattern = "^[!-~]+$")
    ),
    request_body(content = SurfaceRequest,
        description = "A method, and nodes where the iteration's own are not meant."),
    responses(
        (status = 201, description = "The surface, kept.", body = RecordBody,
            headers(("Location" = String, description = "Where the surface is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem,
            content_type = "application/problem+json")
    )
)]
async fn create_iteration_surface(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], about: &About| {
        Ok(records::draft(RecordKind::Surface, text, surfaces::build(text, Some(&about.nodes), &about.plans)?)?.into())
    };
    keep(state, (job, number), "surfaces", key, payload, build).await
}
