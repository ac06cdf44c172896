//! What some requests need to be taken: something that is there for them alone. A job that has
//! something is not deleted, a purge wants a job of its own, and an operation must have
//! been begun; what is drawn would always be refused.

use serde_json::{Value, json};

use super::{
    fixture::{Service, example},
    request::Request,
    rng::Rng,
};

/// In so many of 100; the others go out as they were drawn.
const PREPARED: usize = 60;

/// A study this short ends at once.
const REPETITIONS: u32 = 20;

/// Makes what the request needs, now and then, and has it name that. A service that is too busy
/// for it gets the request as it is.
pub async fn prepare(service: &Service, request: &mut Request, rng: &mut Rng) {
    let _made = match request.operation.as_str() {
        "delete_job" if rng.percent(PREPARED) => empty_job(service, request).await,
        "purge_job" if rng.percent(PREPARED) => purgeable_job(service, request).await,
        "get_operation" | "get_operation_result" | "cancel_operation" if rng.percent(PREPARED) => {
            let ended = rng.percent(70);
            operation(service, request, ended).await
        }
        _ => None,
    };
}

/// The headers and the body of an answer that is what was asked for.
async fn made(
    service: &Service,
    path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> Option<(axum::http::HeaderMap, Vec<u8>)> {
    let (status, headers, answer) = service.ask("POST", path, headers, body).await;
    (200..300).contains(&status).then_some((headers, answer))
}

/// Deletes a job that has nothing, as it is now where it is asked for that.
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

/// Names an operation that was begun, and that may have ended.
async fn operation(service: &Service, request: &mut Request, ended: bool) -> Option<()> {
    let mut study: Value = serde_json::from_str(&example("study_randomization")).ok()?;
    study["repetitions"] = json!(REPETITIONS);
    let later = [("prefer", "respond-async")];
    let (headers, _) = made(service, "/v1/studies/randomization", &later, &study.to_string()).await?;
    let operation = headers.get("location")?.to_str().ok()?.to_owned();
    if ended {
        service.ask("GET", &operation, &[("prefer", "wait=3")], "").await;
    }
    request.target = match request.operation.as_str() {
        "get_operation_result" => format!("{operation}/result"),
        _ => operation,
    };
    Some(())
}
