//! `…/iterations/{number}/curves` and `…/surfaces`: shapes kept with an iteration, made of its
//! nodes or of others.

use axum::response::Response;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::records::{RecordContext, RecordRequest};
use crate::{
    api::{
        curves::{self, request::IterationCurveRequest},
        jobs::records::{self, RecordBody},
        problem::{Problem, Room},
        surfaces::{self, request::SurfaceRequest},
    },
    http::{layers::idempotency::IdempotencyKey, state::AppState},
    jobs::RecordKind,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_iteration_curve)).routes(routes!(create_iteration_surface))
}

/// Add a curve to an iteration
///
/// As `POST /v1/curves`, by default from the iteration's own nodes. The result is stored with the
/// iteration as a record.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/curves", operation_id = "create_iteration_curve",
    tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        IdempotencyKey
    ),
    request_body(content = IterationCurveRequest, description = "A method, and points if the iteration's own are not \
        used."),
    responses(
        (status = 201, description = "The record with the curve.", body = RecordBody,
            headers(("Location" = String, description = "Address of the curve.")))
    )
)]
async fn create_iteration_curve(request: RecordRequest) -> Result<Response, Problem> {
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        Ok(records::draft(RecordKind::Curve, text, curves::build(text, Some(&context.nodes))?)?.into())
    };
    request.keep("curves", build).await
}

/// Add a surface to an iteration
///
/// As `POST /v1/surfaces`, by default from the iteration's own nodes. The result is stored with the
/// iteration as a record.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/surfaces", operation_id = "create_iteration_surface",
    tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        IdempotencyKey
    ),
    request_body(content = SurfaceRequest,
        description = "A method, and nodes if the iteration's own are not used."),
    responses(
        (status = 201, description = "The record with the surface.", body = RecordBody,
            headers(("Location" = String, description = "Address of the surface.")))
    )
)]
async fn create_iteration_surface(request: RecordRequest) -> Result<Response, Problem> {
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        Ok(records::draft(RecordKind::Surface, text, surfaces::build(text, Some(&context.nodes), &context.plans)?)?
            .into())
    };
    request.keep("surfaces", build).await
}
