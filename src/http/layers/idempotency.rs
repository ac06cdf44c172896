//! POSTs that store: done once for a key.
//!
//! A client that goes away while its answer is computed takes its request along, and the key is
//! free again: asked once more, the work is done anew. What the store has been given is stored all
//! the same, and the key stays claimed until it is.

use axum::{
    RequestExt as _,
    extract::{FromRequest, FromRequestParts},
    http::request::Parts,
};
use utoipa::IntoParams;

use super::prelude::*;
use super::{
    body::{BodyDigest, Payload},
    multipart,
};
use crate::{
    http::caller_state::CallerState,
    jobs::{Answer, KeyClaim, Keyed, KeyedRequest, Stored},
};

/// Says that an answer is given again.
pub static REPLAYED: HeaderName = HeaderName::from_static("idempotency-replayed");
/// Carries the key.
static KEY: HeaderName = HeaderName::from_static("idempotency-key");
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
            return Err(Problem::new(ProblemCode::MalformedRequest, "Idempotency-Key occurs twice; send one."));
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

/// A key claimed for a request whose body is still to be read.
pub struct ClaimedKey {
    key: String,
    scope: String,
    /// Noted when the body was read.
    digest: BodyDigest,
    claim: KeyClaim,
}

impl ClaimedKey {
    /// The key with the digest of its request. To be asked once the body has been read.
    pub fn request(self) -> KeyedRequest {
        let ClaimedKey { key, scope, digest, claim } = self;
        // a body that was never read is like none that could come again
        let request_sha256 = digest.get().copied().unwrap_or_default();
        KeyedRequest { key, scope, request_sha256, claim: Some(Arc::new(claim)) }
    }

    /// Stores under the key the response that `answer` writes.
    pub fn answered_by<T>(self, answer: impl Fn(&T, Stored) -> Answer + Send + Sync + 'static) -> Keyed<T> {
        self.request().answered_by(answer)
    }
}

/// A POST that stores.
pub struct Post {
    pub state: CallerState,
    key: IdempotencyKey,
    /// Method and path, for which the key is.
    scope: String,
    payload: Payload,
}

impl FromRequest<AppState> for Post {
    type Rejection = Problem;

    async fn from_request(mut request: Request, state: &AppState) -> Result<Self, Problem> {
        let caller = request.extract_parts_with_state(state).await?;
        let key = request.extract_parts_with_state(state).await?;
        // UUIDs are the same in capitals
        let scope = format!("{} {}", request.method(), request.uri().path().to_ascii_lowercase());
        Ok(Post { state: caller, key, scope, payload: request.extract_with_state(state).await? })
    }
}

impl Post {
    /// Does the work. With a key whose first answer is kept, that answer is given again; with a key
    /// whose first request still runs, or was another one, the request is refused.
    pub async fn once<W, F>(self, work: W) -> Result<Response, Problem>
    where
        W: FnOnce(CallerState, Payload, Option<ClaimedKey>) -> F,
        F: Future<Output = Result<Answer, Problem>>,
    {
        let Post { state, key, scope, payload } = self;
        let IdempotencyKey(Some(key)) = key else { return work(state, payload, None).await.map(respond) };
        let claim = state.keys.claim(state.jobs.tenant(), &key, &scope).ok_or_else(|| {
            let detail =
                "The first request with this Idempotency-Key is still running; send it again for its response.";
            Problem::new(ProblemCode::IdempotencyKeyInUse, detail).retry_after(1)
        })?;
        if let Some(kept) = state.jobs.answer(key.clone(), scope.clone()).await? {
            let limit = state.settings.body_limit;
            let again = state.pool.run(move || multipart::digest(payload, limit)).await??;
            return replayed(kept, &again);
        }
        let (payload, digest) = payload.digested();
        let claimed = ClaimedKey { key: key.clone(), scope: scope.clone(), digest: digest.clone(), claim };
        match work(state.clone(), payload, Some(claimed)).await {
            // Another server stored the answer to this key while this one worked.
            Err(problem) if problem.is(ProblemCode::IdempotencyKeyInUse) => {
                match (state.jobs.answer(key.clone(), scope.clone()).await?, digest.get()) {
                    (Some(kept), Some(own)) => replayed(kept, own),
                    _ => Err(problem),
                }
            }
            outcome => outcome.map(respond),
        }
    }
}

/// The first answer again, if the request is the first one again.
fn replayed((first, answer): ([u8; 32], Answer), again: &[u8; 32]) -> Result<Response, Problem> {
    if *again != first {
        let detail = "This Idempotency-Key was used for a request with another body; use a new key for a new request.";
        return Err(Problem::new(ProblemCode::IdempotencyKeyReused, detail));
    }
    let mut response = respond(answer);
    response.headers_mut().insert(&REPLAYED, HeaderValue::from_static("true"));
    Ok(response)
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
