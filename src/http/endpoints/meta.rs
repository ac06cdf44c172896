//! Around the contract: health, metrics, the OpenAPI documents and the interactive documentation.

use std::sync::OnceLock;

use super::prelude::*;
use super::{dashboard, docs};
use crate::{
    http::{layers::readiness::Unready, openapi::openapi_json},
    telemetry,
};

/// For supervisors; on every listener.
pub fn health() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_health))
}

/// For load balancers and monitoring; on a listener of their own where there is one.
pub fn operation() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(get_readiness)).routes(routes!(get_metrics))
}

/// Returns the routes that the document does not describe.
pub fn undocumented(state: &AppState) -> Router<AppState> {
    static TAG: OnceLock<Option<HeaderValue>> = OnceLock::new();
    let router = Router::new().route("/openapi.json", get(|| async { document(openapi_json(), &TAG) }));
    let documented = state.settings.docs.then(docs::routes);
    let root = match &state.dashboard {
        Some(files) => Some(dashboard::routes(files)),
        None => state.settings.docs.then(docs::at_root),
    };
    documented.into_iter().chain(root).fold(router, Router::merge)
}

/// The state of the process.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct Health {
    /// Always `ok`; anything else is a problem.
    #[schema(example = "ok")]
    pub status: String,
    /// Engine name and version.
    #[schema(example = "flankfit 0.1.0")]
    pub engine: String,
    /// Longest body of a request in bytes, after decompression.
    pub body_limit_bytes: u64,
    /// True if requests to `/v1/…` need an API key.
    pub key_required: bool,
}

impl Health {
    fn of(state: &AppState) -> Self {
        Health {
            status: "ok".into(),
            engine: crate::api::ENGINE.into(),
            body_limit_bytes: state.settings.body_limit as u64,
            key_required: state.callers.key_required(),
        }
    }
}

/// Check that the process is running
///
/// For a supervisor that restarts the process if it does not respond, and for clients that look up
/// the limits of requests. The store is not checked.
#[utoipa::path(
    get, path = "/healthz", operation_id = "get_health", tag = "operation",
    responses((status = 200, description = "The process is up.", body = Health))
)]
async fn get_health(State(state): State<AppState>) -> axum::Json<Health> {
    axum::Json(Health::of(&state))
}

/// Kind of requests that a process must be ready for.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct ReadinessQuery {
    /// `compute`: for requests that compute and store nothing; only a shutdown counts then. Without
    /// it, everything is checked.
    #[serde(rename = "for")]
    #[param(value_type = Option<Purpose>, inline)]
    purpose: Option<String>,
}

/// Kind of requests the server must be ready for.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum Purpose {
    Compute,
}

/// Check that the server is ready
///
/// For a load balancer. The server is ready if the process is not shutting down, the database
/// responds within a second, and its disk accepts writes. The database is checked at most once a
/// second.
#[utoipa::path(
    get, path = "/readyz", operation_id = "get_readiness", tag = "operation",
    params(ReadinessQuery),
    responses(
        (status = 200, description = "The server is ready.", body = Health),
        (status = 503, description = "The process is shutting down, or nothing can be stored; `detail` gives the \
            reason: the store does not respond or accepts no writes, its schema is missing or of another version, \
            it is a standby, or the clocks are too far apart.")
    )
)]
async fn get_readiness(
    State(state): State<AppState>,
    QueryOf(query): QueryOf<ReadinessQuery>,
) -> Result<axum::Json<Health>, Problem> {
    let purpose = query.purpose.map(|name| serde_json::from_value::<Purpose>(name.into()));
    if let Some(Err(_)) = purpose {
        return Err(Problem::invalid(Faults::one("/for", "expected `compute`; omit it to check everything")));
    }
    if state.shutdown.is_draining() {
        return Err(
            Problem::new(ProblemCode::Draining, "The process is shutting down; use another one.").retry_after(1)
        );
    }
    if purpose.is_some() {
        return Ok(axum::Json(Health::of(&state)));
    }
    match state.readiness.check(&state.jobs).await {
        Ok(()) => Ok(axum::Json(Health::of(&state))),
        Err(Unready { message, cause }) => {
            Err(Problem::new(ProblemCode::StoreUnavailable, message).caused_by(cause).retry_after(1))
        }
    }
}

/// Get metrics
///
/// Metrics of requests, fits, queues, streams and the store in the Prometheus text format. As for
/// `/readyz`, the store is checked at most once a second, for at most a second.
#[utoipa::path(
    get, path = "/metrics", operation_id = "get_metrics", tag = "operation",
    responses(
        (status = 200, description = "Metrics in the Prometheus text format.",
            body = String, content_type = "text/plain")
    )
)]
async fn get_metrics(State(state): State<AppState>) -> impl IntoResponse {
    // where nobody asks for readiness, an alert goes by the figure that this sets
    let _told_by_its_figure = state.readiness.check(&state.jobs).await;
    metrics::gauge!(telemetry::BODY_MEMORY).set(state.budget.held() as f64);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], state.metrics.render())
}

fn document(text: &'static str, tag: &'static OnceLock<Option<HeaderValue>>) -> Response {
    let mut response = Bytes::from_static(text.as_bytes()).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    let tag = tag.get_or_init(|| content_tag(text.as_bytes()));
    headers.extend(tag.clone().map(|tag| (header::ETAG, tag)));
    response
}
