//! Preparation of requests that need something for themselves alone: a job with content is not
//! deleted, and a purge needs a job of its own; drawn ones would always be refused.

use super::{
    fixture::{Service, example},
    request::Request,
    rng::Rng,
};

/// In so many of 100; the others go out as they were drawn.
const PREPARED: usize = 60;

/// Makes what the request needs, now and then, and has it name that. A service that is too busy
/// for it gets the request as it is.
pub async fn prepare(service: &Service, request: &mut Request, rng: &mut Rng) {
    let _made = match request.operation.as_str() {
        "delete_job" if rng.percent(PREPARED) => empty_job(service, request).await,
        "purge_job" if rng.percent(PREPARED) => purgeable_job(service, request).await,
        _ => None,
    };
}

/// Headers and body of a successful response.
async fn made(
    service: &Service,
    path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> Option<(axum::http::HeaderMap, Vec<u8>)> {
    let (status, headers, answer) = service.ask("POST", path, headers, body).await;
    (200..300).contains(&status).then_some((headers, answer))
}

/// Deletes a job without content, at its present version if requested.
async fn empty_job(service: &Service, request: &mut Request) -> Option<()> {
    let (headers, _) = made(service, "/v1/jobs", &[], &example("create_job")).await?;
    request.target = headers.get("location")?.to_str().ok()?.to_owned();
    let tag = headers.get("etag")?.as_bytes();
    for (_, value) in request.headers.iter_mut().filter(|(name, _)| name == "if-match") {
        *value = tag.to_vec();
    }
    Some(())
}

/// Purges a job of its own.
async fn purgeable_job(service: &Service, request: &mut Request) -> Option<()> {
    let (headers, _) = made(service, "/v1/jobs", &[], &example("create_job")).await?;
    let job = headers.get("location")?.to_str().ok()?.to_owned();
    made(service, &format!("{job}/iterations"), &[], &example("create_iteration")).await?;
    request.target = format!("{job}/purge");
    Some(())
}
