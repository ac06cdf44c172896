//! `POST /v1/fits`: compute, store nothing.

use super::prelude::*;
use crate::{
    api::{
        fits::{
            answer::FitResultBody,
            service,
            spec::request::{FitForm, FitRequest},
        },
        measurand::axes::MeasurandBody,
    },
    http::layers::compute::read_fit_and,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_fit))
}

/// Fit a model to nodes
///
/// Returns coefficients with standard errors and bias bounds, the spectrum of the Fisher
/// information matrix, the choice of every criterion for λ*, and near dependencies of columns.
/// Without `regularization`, λ* is chosen by `min_mse`. Nothing is stored.
#[utoipa::path(
    post, path = "/v1/fits", operation_id = "create_fit", tag = "fits",
    request_body(
        content((FitRequest = "application/json"), (FitForm = "multipart/form-data")),
        description = "Nodes and what to fit to them."
    ),
    responses((status = 200, description = "The estimate with its diagnostics.", body = FitResultBody))
)]
async fn create_fit(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let plans = state.plans.clone();
    let work = move |nodes, spec, measurand: MeasurandBody, _| {
        measurand.checked(Some(&nodes)).map_err(Problem::invalid)?;
        service::fit(&nodes, &spec, &plans)
    };
    Ok(json_held(read_fit_and(&state, payload, work).await?))
}

/// The same with the permit for what it takes.
pub fn json_held(held: WithPermit<Vec<u8>>) -> Response {
    let (text, permit) = held.into_parts();
    with_permit(json(text), permit)
}

/// A response that holds finished JSON.
pub fn json(text: Vec<u8>) -> Response {
    let mut response = text.into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    response
}
