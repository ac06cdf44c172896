//! POSTs that store: done once for a key.
//!
//! A client that goes away while its answer is computed takes its request along, and the key is
//! free again: asked once more, the work is done anew. What the store has been given is stored all
//! the same, and the key stays claimed until it is.

use std::sync::Arc;

use axum::{
    extract::FromRequestParts,
    http::{HeaderName, HeaderValue, StatusCode, header, request::Parts},
    response::{IntoResponse, Response},
};
use utoipa::IntoParams;

use super::{
    body::{BodyDigest, Payload},
    caller_state::CallerState,
    multipart,
    state::AppState,
};
use crate::{
    api::problem::{Problem, ProblemCode},
    jobs::{Answer, KeyClaim, KeyHeld, Keyed, KeyedRequest, Lease, RepositoryError, Stored},
};

/// Says that an answer is given again.
pub static REPLAYED: HeaderName = HeaderName::from_static("idempotency-replayed");
/// Carries the key.
pub static KEY: HeaderName = HeaderName::from_static("idempotency-key");
/// Longest key taken.
const LONGEST: usize = 255;

/// The request's `Idempotency-Key`.
#[derive(IntoParams)]
#[into_params(names("Idempotency-Key"), parameter_in = Header)]
pub struct IdempotencyKey(
    /// Repeating the request with the same key and body returns the first answer.
    #[param(min_length = 1, max_length = 255, pattern = "^[!-~]+$")]
    Option<String>,
);

impl FromRequestParts<AppState> for IdempotencyKey {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _state: &AppState) -> Result<Self, Problem> {
        let mut values = parts.headers.get_all(&KEY).iter();
        let Some(value) = values.next() else { return Ok(IdempotencyKey(None)) };
        if values.next().is_some() {
            return Err(Problem::new(
                ProblemCode::MalformedRequest,
                "Idempotency-Key occurs twice; send one, since one key names one request.",
            ));
        }
        match value.to_str() {
            Ok(key) if (1..=LONGEST).contains(&key.trim().len()) => Ok(IdempotencyKey(Some(key.trim().to_owned()))),
            _ => Err(Problem::new(
                ProblemCode::MalformedRequest,
                format!("Idempotency-Key takes 1 to {LONGEST} visible ASCII characters, such as a UUID."),
            )),
        }
    }
}

impl IdempotencyKey {
    /// The key, where there is one.
    pub fn given(self) -> Option<String> {
        self.0
    }
}

/// A key claimed for a request whose body is still to be read.
pub struct ClaimedKey {
    key: String,
    scope: String,
    /// Noted when the body was read.
    digest: BodyDigest,
    claim: KeyClaim,
    /// The task whose request it is, if it is one.
    lease: Option<Lease>,
}

impl ClaimedKey {
    /// The key with the digest of its request. To be asked once the body has been read.
    pub fn request(self) -> KeyedRequest {
        let ClaimedKey { key, scope, digest, claim, lease } = self;
        // a body that was never read is like none that could come again
        let request_sha256 = digest.get().copied().unwrap_or_default();
        KeyedRequest { key, scope, request_sha256, lease, claim: Some(Arc::new(claim)) }
    }

    /// What is kept under the key: the answer that `answer` writes.
    pub fn answered_by<T>(self, answer: impl Fn(&T, Stored) -> Answer + Send + Sync + 'static) -> Keyed<T> {
        self.request().answered_by(answer)
    }
}

/// Does the work of a POST. With a key whose first answer is kept, that answer is given again; with
/// a key whose first request still runs, or was another one, the request is refused.
pub async fn idempotent<W, F>(
    state: CallerState,
    key: IdempotencyKey,
    scope: String,
    payload: Payload,
    work: W,
) -> Result<Response, Problem>
where
    W: FnOnce(CallerState, Payload, Option<ClaimedKey>) -> F,
    F: Future<Output = Result<Answer, Problem>>,
{
    let IdempotencyKey(Some(key)) = key else { return work(state, payload, None).await.map(respond) };
    let claim = claimed(&state, &key, &scope).await?;
    if let Some(kept) = state.jobs.answer(&key, &scope).await? {
        let limit = state.settings.body_limit;
        let again = state.pool.run(move || multipart::digest(payload, limit)).await??;
        return replayed(kept, &again);
    }
    let (payload, digest) = payload.digested();
    let claimed =
        ClaimedKey { key: key.clone(), scope: scope.clone(), digest: digest.clone(), claim, lease: state.lease };
    match work(state.clone(), payload, Some(claimed)).await {
        // Another server stored the answer to this key while this one worked.
        Err(problem) if problem.is(ProblemCode::IdempotencyKeyInUse) => {
            match (state.jobs.answer(&key, &scope).await?, digest.get()) {
                (Some(kept), Some(own)) => replayed(kept, own),
                _ => Err(problem),
            }
        }
        outcome => outcome.map(respond),
    }
}

/// Takes the key. An operation that was cancelled may not have come to its end here yet; it has the
/// key no longer, since nothing is stored for it any more.
async fn claimed(state: &CallerState, key: &str, scope: &str) -> Result<KeyClaim, Problem> {
    let tenant = state.jobs.tenant();
    let in_use = |_held: KeyHeld| {
        let detail = "The first request with this Idempotency-Key is still running; ask again for its answer.";
        Problem::new(ProblemCode::IdempotencyKeyInUse, detail).retry_after(1)
    };
    match state.keys.claim(tenant, key, scope, state.lease) {
        Ok(claim) => Ok(claim),
        Err(KeyHeld { lease: Some(lease) }) if is_over(state, lease).await? => {
            state.keys.take_over(tenant, key, scope, state.lease, lease).map_err(in_use)
        }
        Err(held) => Err(in_use(held)),
    }
}

/// Whether an operation has come to its end, or is forgotten.
async fn is_over(state: &CallerState, lease: Lease) -> Result<bool, Problem> {
    match state.jobs.task(lease.task).await {
        Ok(task) => Ok(task.state.is_end()),
        Err(RepositoryError::NotFound(_)) => Ok(true),
        Err(error) => Err(error.into()),
    }
}

/// The first answer again, if the request is the first one again.
fn replayed((first, answer): ([u8; 32], Answer), again: &[u8; 32]) -> Result<Response, Problem> {
    if *again != first {
        return Err(reused());
    }
    let mut response = respond(answer);
    response.headers_mut().insert(&REPLAYED, HeaderValue::from_static("true"));
    Ok(response)
}

/// What is said of a key that was used for another request.
pub fn reused() -> Problem {
    let detail = "This Idempotency-Key was used for a request with another body; take a new key for a new request.";
    Problem::new(ProblemCode::IdempotencyKeyReused, detail)
}

/// An answer as a response.
pub fn respond(answer: Answer) -> Response {
    let status = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::OK);
    let mut response = (status, answer.body).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    for (name, value) in [(header::LOCATION, answer.location), (header::ETAG, answer.etag)] {
        if let Some(value) = value.and_then(|value| HeaderValue::from_str(&value).ok()) {
            headers.insert(name, value);
        }
    }
    response
}
