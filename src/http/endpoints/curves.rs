//! `/v1/curves`: curves through or near points, evaluated, and as files of CAD systems; nothing is
//! stored.

use super::prelude::*;
use crate::api::{
    curves::{
        self,
        closest::{self, ClosestOnCurveBody, CurveFeetBody},
        evaluate::{self, CurveValuesBody, EvaluateCurveBody},
        request::CurveRequest,
        result::BuiltCurveBody,
    },
    shapes::export::{self, ExportCurveBody},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_curve))
        .routes(routes!(evaluate_curve))
        .routes(routes!(closest_points_of_curve))
        .routes(routes!(export_curve))
}

/// Build a curve through or near points
///
/// Curves pass through the points (polynomials, Hermite, splines, B-splines) or near them (least
/// squares, smoothing). The response includes a report on stability. Its curve can be sent
/// unchanged to the other operations of curves. Nothing is stored.
#[utoipa::path(
    post, path = "/v1/curves", operation_id = "create_curve", tag = "curves",
    request_body(content = CurveRequest,
        description = "Points and the method that leads a curve through or near them."),
    responses(
        (status = 200, description = "The curve, everything needed to build it again, and its stability.",
            body = BuiltCurveBody)
    )
)]
async fn create_curve(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let built = read_json(&state, payload, |text| curves::build(text, None)).await?;
    Ok(json(built.result))
}

/// Evaluate a curve at parameters
///
/// Returns values and, on request, derivatives, curvature and arc length. The curve comes from an
/// earlier response or is written by hand. Parameters must lie within its domain.
#[utoipa::path(
    post, path = "/v1/curves/evaluate", operation_id = "evaluate_curve", tag = "curves",
    request_body(content = EvaluateCurveBody, description = "A curve and its parameters."),
    responses((status = 200, description = "Values in the order of `at`.", body = CurveValuesBody))
)]
async fn evaluate_curve(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, evaluate::answer).await?))
}

/// Find the closest points of a curve
///
/// Returns the parameters of the closest points and the distances, which are signed for a plane
/// curve.
#[utoipa::path(
    post, path = "/v1/curves/closest-points", operation_id = "closest_points_of_curve", tag = "curves",
    request_body(content = ClosestOnCurveBody, description = "A curve and points."),
    responses((status = 200, description = "Closest points in the order of the given ones.", body = CurveFeetBody))
)]
async fn closest_points_of_curve(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, closest::answer).await?))
}

/// Export a curve to a file
///
/// Formats are IGES 126 and STEP AP242 for CAD systems, OBJ, VTK and CSV for display. A curve that
/// a format cannot represent is refused, not approximated.
#[utoipa::path(
    post, path = "/v1/curves/export", operation_id = "export_curve", tag = "curves",
    request_body(content = ExportCurveBody, description = "A curve and the format of the file."),
    responses(
        (status = 200, description = "The file.", content(
            (String = "model/step"),
            (String = "model/iges"),
            (String = "model/obj"),
            (String = "text/plain"),
            (String = "text/csv")
        ))
    )
)]
async fn export_curve(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let now = state.jobs.now();
    attachment(state, payload, move |text, room| export::curve(text, now, room)).await
}
