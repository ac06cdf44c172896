//! The one layer around every request: id, time limit, panics, headers, metrics, log line.
//!
//! One function instead of a stack of layers: each request is looked at once on its way in and once
//! on its way out.

use std::{panic::AssertUnwindSafe, sync::OnceLock, time::Instant};

use axum::{
    Extension,
    extract::{MatchedPath, State},
    http::{Uri, Version},
};
use futures_util::FutureExt as _;
use tokio::time::timeout;
use tracing::Instrument as _;
use uuid::Uuid;

use super::prelude::*;
use super::{
    auth::{self, Principal},
    headers, sites,
};
use crate::{
    http::server::{ForChecks, Peer},
    jobs::secret,
    pool,
};

/// The header that carries the id of a request.
pub static REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// The headers that name the span of a request to others.
pub static TRACEPARENT: HeaderName = HeaderName::from_static(telemetry::TRACEPARENT);
pub static TRACESTATE: HeaderName = HeaderName::from_static(telemetry::TRACESTATE);

/// Longest id taken over from a client.
const LONGEST_ID: usize = 128;

/// Paths that balancers and monitoring request all the time. Success is logged at DEBUG only.
const CHECKS: [&str; 3] = ["/healthz", "/readyz", "/metrics"];

/// The id of the request that is being answered (a request extension).
#[derive(Clone, Debug)]
pub struct RequestId(pub HeaderValue);

impl RequestId {
    pub fn as_str(&self) -> &str {
        self.0.to_str().unwrap_or_default()
    }
}

/// Gives every request an id, the caller's own or a new one, and every answer that of its request:
/// also those that layers give before [`observe`], such as preflights.
pub async fn identify(mut request: Request, next: Next) -> Response {
    let id = request.headers().get(&REQUEST_ID).filter(|id| is_sane(id)).cloned().unwrap_or_else(new_id);
    request.extensions_mut().insert(RequestId(id.clone()));
    let mut response = next.run(request).await;
    response.headers_mut().insert(REQUEST_ID.clone(), id);
    response
}

/// The layer, within the span of the request if that is traced.
pub async fn observe(
    State(state): State<AppState>,
    Extension(id): Extension<RequestId>,
    request: Request,
    next: Next,
) -> Response {
    let (span, named) = telemetry::request_span(|| traced(&state, &id, &request));
    let mut response = respond(state, id.0, request, next).instrument(span.clone()).await;
    telemetry::responded(&span, response.status().as_u16());
    if let Some(value) = named.and_then(|named| HeaderValue::try_from(named).ok()) {
        response.headers_mut().insert(TRACEPARENT.clone(), value);
    }
    response
}

/// Returns the attributes of a request's span: nothing that identifies the caller or the data.
fn traced<'a>(state: &AppState, RequestId(id): &'a RequestId, request: &'a Request) -> telemetry::Head<'a> {
    let all = |name: &HeaderName| request.headers().get_all(name).iter().map(|value| value.to_str().ok());
    // of several that would have to be one, none is believed
    let one = |name: &HeaderName| {
        let mut found = all(name);
        found.next().flatten().filter(|_| found.next().is_none())
    };
    let states: Vec<&str> = all(&TRACESTATE).flatten().collect();
    telemetry::Head {
        method: Some(method_name(request.method())).filter(|name| *name != OTHER_METHOD),
        route: request.extensions().get::<MatchedPath>().map(MatchedPath::as_str),
        scheme: if state.settings.tls.certificate.is_some() { "https" } else { "http" },
        host: one(&header::HOST),
        id: id.to_str().unwrap_or_default(),
        above: telemetry::Above {
            traceparent: one(&TRACEPARENT),
            tracestate: Some(states.join(",")).filter(|states| !states.is_empty()),
        },
    }
}

async fn respond(state: AppState, id: HeaderValue, mut request: Request, next: Next) -> Response {
    let begun = Instant::now();
    let method = request.method().clone();
    let path = request.extensions().get::<MatchedPath>().cloned();
    let url = tracing::enabled!(tracing::Level::DEBUG).then(|| masked(request.uri()));

    let peer = request.extensions().get::<Peer>().copied();
    let principal = match names_host(&request).and_then(|()| has_a_place(&request, path.as_ref())) {
        Ok(()) => identify_caller(&state, &mut request, peer).await,
        Err(problem) => Err(problem),
    };
    let actor = principal.as_ref().ok().and_then(Option::as_ref).map(|principal| principal.caller.actor.clone());
    // the log line of a refusal names the caller as well
    let principal = principal.and_then(|found| has_requests_left(&state, found.as_ref(), peer).map(|()| found));
    let answer = async {
        match principal {
            Ok(principal) => {
                let party = principal.as_ref().and_then(Principal::party);
                principal.map(|principal| request.extensions_mut().insert(principal));
                pool::on_behalf_of(party, next.run(request)).await
            }
            Err(problem) => problem.into_response(),
        }
    };
    let mut response = in_time(state.settings.request_timeout, answer).await;

    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        let problem = named(problem, id.to_str().unwrap_or_default());
        let headers = std::mem::take(response.headers_mut());
        response = problem.into_response();
        for (name, value) in &headers {
            if name != header::CONTENT_LENGTH {
                response.headers_mut().insert(name, value.clone());
            }
        }
    }
    headers::protect(&mut response, &method);
    let report = Report { method, path, begun, id, actor, url, span: telemetry::here() };
    match response.extensions_mut().remove::<LateReport>() {
        Some(late) => late.0.set(report).unwrap_or_default(),
        None => report.end(response.status().as_u16()),
    }
    response
}

/// Who calls, where that is asked for.
async fn identify_caller(
    state: &AppState,
    request: &mut Request,
    peer: Option<Peer>,
) -> Result<Option<Principal>, Problem> {
    let (method, path) = (request.method(), request.uri().path());
    sites::check(state, method, request.headers())?;
    let identified = state.callers.identify(method, path, request.headers(), request.extensions()).await;
    auth::forget(request.headers_mut());
    match identified {
        Err(problem) if problem.status == 401 => Err(state.rates.refuse(problem, peer)),
        identified => identified,
    }
}

/// Whether a caller that is counted may make this request as well.
fn has_requests_left(state: &AppState, principal: Option<&Principal>, peer: Option<Peer>) -> Result<(), Problem> {
    let Some(principal) = principal else { return Ok(()) };
    let known = principal.is_known().then_some(&principal.caller);
    state.rates.count(known, peer)
}

/// A request of HTTP/1.1 names one host (RFC 9112, 3.2).
fn names_host(request: &Request) -> Result<(), Problem> {
    let named = request.headers().get_all(header::HOST).iter().count();
    if named == 1 || (named == 0 && request.version() != Version::HTTP_11) {
        return Ok(());
    }
    Err(Problem::new(ProblemCode::MalformedRequest, "A request of HTTP/1.1 needs exactly one header `Host`."))
}

/// If all connections are busy, only checks are answered.
fn has_a_place(request: &Request, path: Option<&MatchedPath>) -> Result<(), Problem> {
    let check = path.is_some_and(|path| CHECKS.contains(&path.as_str()));
    if check || request.extensions().get::<ForChecks>().is_none() {
        return Ok(());
    }
    let detail = "All connections of this server are busy; try again in a moment.";
    Err(Problem::new(ProblemCode::Overloaded, detail).retry_after(1))
}

/// Logs the cause of a problem and gives it the id of its request.
pub fn named(mut problem: Problem, id: &str) -> Problem {
    if let Some(cause) = problem.cause.take() {
        log_cause(id, &problem, &cause);
    }
    problem.request_id = Some(id.to_owned());
    problem
}

/// Logs the internal cause at a level that fits its urgency: a client that leaves is no error of
/// this server.
fn log_cause(request_id: &str, problem: &Problem, cause: &str) {
    let code = &problem.code;
    match problem.status {
        500 => tracing::error!(request_id, %code, cause, "problem"),
        501.. => tracing::warn!(request_id, %code, cause, "problem"),
        _ => tracing::debug!(request_id, %code, cause, "problem"),
    }
}

/// The answer of a handler, or the problem that there is none after so many seconds.
pub async fn in_time(limit: u64, handling: impl Future<Output = Response>) -> Response {
    match timeout(Duration::from_secs(limit), AssertUnwindSafe(handling).catch_unwind()).await {
        Ok(Ok(response)) => response,
        Ok(Err(_panic)) => Problem::internal("a handler panicked").into_response(),
        Err(_elapsed) => too_late(limit).into_response(),
    }
}

/// Returns the problem for a request whose time is over. (Its work was cancelled with it.)
pub fn too_late(limit: u64) -> Problem {
    Problem::new(ProblemCode::RequestTimeout, format!("There was no response within {limit} s.")).retry_after(5)
}

/// Writes metrics and the log line of a request once its answer has ended.
#[derive(Debug)]
struct Report {
    method: Method,
    path: Option<MatchedPath>,
    begun: Instant,
    id: HeaderValue,
    actor: Option<Arc<str>>,
    url: Option<String>,
    span: tracing::Span,
}

/// The report of an answer whose result follows its head (a response extension).
#[derive(Clone, Debug, Default)]
pub struct LateReport(Arc<OnceLock<Report>>);

impl LateReport {
    /// Reports the status of the result.
    pub fn end(&self, status: u16) {
        if let Some(report) = self.0.get() {
            report.end(status);
            telemetry::responded(&report.span, status);
        }
    }
}

impl Report {
    fn end(&self, status: u16) {
        let Report { method, path, begun, id, actor, url, .. } = self;
        let (elapsed, actor) = (begun.elapsed(), actor.as_deref());
        let seconds = elapsed.as_secs_f64();
        let route = path.as_ref().map_or("unmatched", MatchedPath::as_str);
        telemetry::record_answer(method_name(method), route, status, elapsed);
        let id = id.to_str().unwrap_or_default();
        match url {
            Some(url) => {
                tracing::debug!(request_id = id, %method, route, %url, actor, status, seconds, "answered")
            }
            // where DEBUG is not logged
            None if CHECKS.contains(&route) && (200..300).contains(&status) => {}
            None => tracing::info!(request_id = id, %method, route, actor, status, seconds, "answered"),
        }
    }
}

/// Name of all methods that HTTP does not define.
const OTHER_METHOD: &str = "other";

/// Methods are labels, so unknown ones share a name: a client cannot make new time series.
fn method_name(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        Method::HEAD => "HEAD",
        Method::OPTIONS => "OPTIONS",
        _ => OTHER_METHOD,
    }
}

/// Query parameters whose values may be keys, although keys are not read from the query.
const SECRET_PARAMETERS: [&str; 5] = ["key", "x-api-key", "api_key", "access_token", "authorization"];

/// Returns path and query for the log: values of parameters that are named like keys, and anything
/// that looks like a key of the store, are masked.
fn masked(uri: &Uri) -> String {
    const MASK: &str = "***";
    let value = |pair: &str| match pair.split_once('=') {
        Some((name, _)) if SECRET_PARAMETERS.iter().any(|known| name.eq_ignore_ascii_case(known)) => {
            format!("{name}={MASK}")
        }
        _ => pair.to_owned(),
    };
    let query = uri.query().map(|query| query.split('&').map(value).collect::<Vec<_>>().join("&"));
    let url = query.map_or_else(|| uri.path().to_owned(), |query| format!("{}?{query}", uri.path()));
    let mut parts = url.split(secret::PREFIX);
    let mut told = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        told.extend([secret::PREFIX, MASK, rest]);
    }
    told
}

fn is_sane(id: &HeaderValue) -> bool {
    let bytes = id.as_bytes();
    (1..=LONGEST_ID).contains(&bytes.len()) && bytes.iter().all(u8::is_ascii_graphic)
}

#[expect(clippy::disallowed_methods, reason = "the id of a request is stored nowhere")]
fn new_id() -> HeaderValue {
    let mut buffer = Uuid::encode_buffer();
    let text = Uuid::now_v7().hyphenated().encode_lower(&mut buffer);
    HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static("unknown"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_not_logged_with_the_path() {
        let told = |uri: &str| masked(&uri.parse().unwrap());
        assert_eq!(told("/v1/jobs?q=wheel&limit=5"), "/v1/jobs?q=wheel&limit=5");
        assert_eq!(told("/v1/jobs?key=secret&q=a"), "/v1/jobs?key=***&q=a");
        assert_eq!(told("/v1/jobs?X-API-Key=secret"), "/v1/jobs?X-API-Key=***");
        assert_eq!(told("/v1/jobs/ffk_0123_abc-D/x?q=ffk_9&m=1"), "/v1/jobs/ffk_***/x?q=ffk_***&m=1");
        assert_eq!(told("/healthz"), "/healthz");
    }
}
