//! `/v1/surfaces`: surfaces through or near nodes and borders, evaluated, and as files of CAD and
//! FE systems; nothing is stored.

use super::prelude::*;
use crate::{
    api::{
        shapes::export::{self, ExportSurfaceBody},
        surfaces::{
            self,
            closest::{self, ClosestOnSurfaceBody, SurfaceFeetBody},
            evaluate,
            request::SurfaceRequest,
            result::BuiltSurfaceBody,
            sections::{self, SectionsBody, SectionsRequest},
            values::{EvaluateSurfaceBody, SurfaceValuesBody},
        },
    },
    http::layers::compute::read_json_in_room,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_surface))
        .routes(routes!(evaluate_surface))
        .routes(routes!(closest_points_of_surface))
        .routes(routes!(sections_of_surface))
        .routes(routes!(export_surface))
}

/// Build a surface from nodes or boundaries
///
/// Methods are Coons, Gregory, Bézier and B-spline patches of borders, meshes and grids, and least
/// squares near scattered nodes. The response reports the continuity between patches. Its surface
/// can be sent unchanged to the other operations of surfaces. Nothing is stored.
#[utoipa::path(
    post, path = "/v1/surfaces", operation_id = "create_surface", tag = "surfaces",
    request_body(content = SurfaceRequest, description = "The data of the surface and the method."),
    responses(
        (status = 200, description = "The surface, everything needed to build it again, and a report.",
            body = BuiltSurfaceBody)
    )
)]
async fn create_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let plans = state.plans.clone();
    let built = read_json(&state, payload, move |text| surfaces::build(text, None, &plans)).await?;
    Ok(json(built.result))
}

/// Evaluate a surface at parameters
///
/// Returns values and, on request, derivatives, normals, fundamental forms, curvatures and area.
/// The surface comes from an earlier response or is written by hand. It is evaluated at single
/// parameters or on a grid within its domain.
#[utoipa::path(
    post, path = "/v1/surfaces/evaluate", operation_id = "evaluate_surface", tag = "surfaces",
    request_body(content = EvaluateSurfaceBody, description = "A surface and its parameters."),
    responses((status = 200, description = "Values in the order of `at`.", body = SurfaceValuesBody))
)]
async fn evaluate_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json_held(read_json_in_room(&state, payload, evaluate::answer).await?))
}

/// Find the closest points of a surface
///
/// Returns the parameters of the closest points and the distances, positive on the side that the
/// normal points to.
#[utoipa::path(
    post, path = "/v1/surfaces/closest-points", operation_id = "closest_points_of_surface", tag = "surfaces",
    request_body(content = ClosestOnSurfaceBody, description = "A surface and points."),
    responses((status = 200, description = "Closest points in the order of the given ones.", body = SurfaceFeetBody))
)]
async fn closest_points_of_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, closest::answer).await?))
}

/// Cut a surface by parallel planes
///
/// Section curves are cubic B-splines in space or polylines. They are joined across patches, seams
/// and poles. If the plane touches the surface, or the section cannot be determined, the response
/// has a warning. Two families of planes also give a mesh of curves. It can be sent unchanged to
/// `POST /v1/surfaces`, which fills it with patches.
#[utoipa::path(
    post, path = "/v1/surfaces/sections", operation_id = "sections_of_surface", tag = "surfaces",
    request_body(content = SectionsRequest, description = "A surface and planes."),
    responses((status = 200, description = "Sections in the order of the planes.", body = SectionsBody))
)]
async fn sections_of_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json_held(read_json_in_room(&state, payload, sections::answer).await?))
}

/// Export a surface to a file
///
/// Formats are IGES 128 and STEP AP242 for CAD systems, OBJ, STL and VTK for display, and meshes of
/// quadrilaterals for FE systems. CAD formats contain the exact surface, the others facets of it.
#[utoipa::path(
    post, path = "/v1/surfaces/export", operation_id = "export_surface", tag = "surfaces",
    request_body(content = ExportSurfaceBody, description = "A surface and the format of the file."),
    responses(
        (status = 200, description = "The file.", content(
            (String = "model/step"),
            (String = "model/iges"),
            (String = "model/obj"),
            (String = "model/stl"),
            (String = "text/plain"),
            (String = "text/csv")
        ))
    )
)]
async fn export_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let now = state.jobs.now();
    attachment(state, payload, move |text, room| export::surface(text, now, room)).await
}
