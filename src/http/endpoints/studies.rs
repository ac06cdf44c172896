//! `POST /v1/studies/randomization`: numerical experiments; nothing is stored.

use super::prelude::*;
use crate::api::studies::{
    request::RandomizationRequest,
    result::{self, RandomizationResult},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(study_randomization))
}

/// Compare randomisation of a measurement matrix with regularisation
///
/// Random matrices perturb the measurement matrix at several levels. The response has medians and
/// quartiles of errors and condition numbers. The same seed gives the same result for any number of
/// threads. Nothing is stored.
#[utoipa::path(
    post, path = "/v1/studies/randomization", operation_id = "study_randomization", tag = "studies",
    request_body(content = RandomizationRequest, description = "The matrix to randomise, and the levels."),
    responses(
        (status = 200, description = "Medians and quartiles by level, and the references.", body = RandomizationResult)
    )
)]
async fn study_randomization(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let answer = read_json(&state, payload, |text| result::answer(text)?.to_json().map_err(Problem::internal)).await?;
    Ok(json(answer))
}
