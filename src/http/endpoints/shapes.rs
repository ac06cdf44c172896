//! `…/iterations/{number}/curves` and `…/surfaces`: shapes kept with an iteration, made of its
//! nodes or of others.

use super::prelude::*;
use super::records::{RecordContext, RecordRequest};
use crate::api::{
    curves::{self, request::IterationCurveRequest},
    jobs::records::{self},
    surfaces::{self, request::SurfaceRequest},
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
    params(IdempotencyKey),
    request_body(content = IterationCurveRequest, description = "A method, and points if the iteration's own are not \
        used."),
    responses((status = 201, description = "The record with the curve.", body = RecordBody))
)]
async fn create_iteration_curve(request: RecordRequest) -> Result<Response, Problem> {
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        Ok(records::draft(RecordKind::Curve, text, curves::build(text, Some(&context.nodes))?)?.into())
    };
    request.keep(build).await
}

/// Add a surface to an iteration
///
/// As `POST /v1/surfaces`, by default from the iteration's own nodes. The result is stored with the
/// iteration as a record.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/surfaces", operation_id = "create_iteration_surface",
    tag = "iterations",
    params(IdempotencyKey),
    request_body(content = SurfaceRequest,
        description = "A method, and nodes if the iteration's own are not used."),
    responses((status = 201, description = "The record with the surface.", body = RecordBody))
)]
async fn create_iteration_surface(request: RecordRequest) -> Result<Response, Problem> {
    let build = |text: &[u8], context: &RecordContext, _: Room| {
        Ok(records::draft(RecordKind::Surface, text, surfaces::build(text, Some(&context.nodes), &context.plans)?)?
            .into())
    };
    request.keep(build).await
}
