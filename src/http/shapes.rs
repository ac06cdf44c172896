//! `…/iterations/{number}/shapes`: curves and surfaces kept with an iteration, made of its nodes or of others.

use std::sync::Arc;

use axum::{extract::State, response::Response};
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    body::Payload,
    extract::{PathOf, QueryOf},
    fits::json,
    idempotency::{IdempotencyKey, once},
    paging::PageQuery,
    state::AppState,
};
use crate::{
    api::{
        problem::Problem,
        shapes::{
            curve_request::{self, KeptCurveRequest},
            kept::{self, ShapeBody, ShapePageBody},
            surface_request::{self, SurfaceRequest},
        },
    },
    estimation::{Nodes, Plans},
    jobs::{Answer, Shape, ShapeDraft, ShapeKind, Stored},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_iteration_curve))
        .routes(routes!(create_iteration_surface))
        .routes(routes!(list_iteration_shapes))
        .routes(routes!(get_iteration_shape))
}

/// Builds a curve, by default of the iteration's own nodes, and keeps it with the iteration.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/curves", operation_id = "create_iteration_curve", tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response again.", max_length = 255)
    ),
    request_body(content = KeptCurveRequest, description = "A method, and points where the iteration's own are not meant."),
    responses(
        (status = 201, description = "The curve, kept.", body = ShapeBody, headers(("Location" = String, description = "Where the curve is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn create_iteration_curve(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], nodes: &Nodes, _: &Plans| {
        kept::draft(ShapeKind::Curve, text, curve_request::build(text, Some(nodes))?)
    };
    keep(state, (job, number), "curves", key, payload, build).await
}

/// Builds a surface, by default of the iteration's own nodes, and keeps it with the iteration.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/iterations/{number}/surfaces", operation_id = "create_iteration_surface", tag = "iterations",
    params(
        ("job_id" = Uuid, Path),
        ("number" = u32, Path),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body answers the first response again.", max_length = 255)
    ),
    request_body(content = SurfaceRequest, description = "A method, and nodes where the iteration's own are not meant."),
    responses(
        (status = 201, description = "The surface, kept.", body = ShapeBody, headers(("Location" = String, description = "Where the surface is."))),
        (status = 409, description = "The first request with this idempotency key is still running.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn create_iteration_surface(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    key: IdempotencyKey,
    payload: Payload,
) -> Result<Response, Problem> {
    let build = |text: &[u8], nodes: &Nodes, plans: &Plans| {
        kept::draft(ShapeKind::Surface, text, surface_request::build(text, Some(nodes), plans)?)
    };
    keep(state, (job, number), "surfaces", key, payload, build).await
}

async fn keep(
    state: AppState,
    (job, number): (Uuid, u32),
    route: &'static str,
    key: IdempotencyKey,
    payload: Payload,
    build: impl FnOnce(&[u8], &Nodes, &Plans) -> Result<ShapeDraft, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let place = format!("/v1/jobs/{job}/iterations/{number}");
    once(state, key, format!("POST {place}/{route}"), payload, move |state, payload, known| async move {
        let nodes = state.jobs.nodes(job, number).await?;
        let (limit, plans) = (state.settings.body_limit, state.plans.clone());
        let draft = state.pool.run(move || build(&payload.into_json(limit)?, &nodes, &plans)).await??;
        let answer = move |shape: &Shape, _: Stored| created(&place, shape);
        let keyed = known.map(|known| known.answered_by(answer.clone()));
        let (shape, stored): (Arc<Shape>, Stored) = state.jobs.add_shape(job, number, draft, keyed).await?;
        Ok(answer(&shape, stored))
    })
    .await
}

fn created(place: &str, shape: &Shape) -> Answer {
    Answer { status: 201, location: Some(format!("{place}/shapes/{}", shape.id)), etag: None, body: kept::shape(shape) }
}

/// Lists the curves and surfaces of an iteration, oldest first.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/shapes", operation_id = "list_iteration_shapes", tag = "iterations",
    params(("job_id" = Uuid, Path), ("number" = u32, Path), PageQuery),
    responses(
        (status = 200, description = "Some shapes, and where the next page begins.", body = ShapePageBody),
        (status = 422, description = "The limit or the cursor is not one.", body = Problem, content_type = "application/problem+json")
    )
)]
async fn list_iteration_shapes(
    State(state): State<AppState>,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<ShapePageBody>, Problem> {
    let page = state.jobs.shapes(job, number, query.check()?).await?;
    Ok(axum::Json(page.into()))
}

/// A curve or surface of an iteration: what was asked and what was answered.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/shapes/{shape_id}", operation_id = "get_iteration_shape", tag = "iterations",
    params(("job_id" = Uuid, Path), ("number" = u32, Path), ("shape_id" = Uuid, Path)),
    responses((status = 200, description = "The shape.", body = ShapeBody))
)]
async fn get_iteration_shape(
    State(state): State<AppState>,
    PathOf((job, number, id)): PathOf<(Uuid, u32, Uuid)>,
) -> Result<Response, Problem> {
    Ok(json(kept::shape(&state.jobs.shape(job, number, id).await?)))
}
