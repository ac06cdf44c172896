//! Every endpoint group in one place. Groups are built by `utoipa-axum`, so what is served is what
//! is documented.

use axum::{Router, middleware};
use tower::{ServiceBuilder, util::option_layer};
use tower_http::{CompressionLevel, compression::CompressionLayer};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::{
    openapi::{self, Contract, scopes},
    state::AppState,
};
use crate::{
    api::problem::{Problem, ProblemCode},
    http::{
        endpoints::{
            applied, audit, curves, dashboard, events, fits, gear_corrections, gear_records, gears, imports,
            iterations, job_fits, jobs, keys, life, meta, nodes, previews, records, shapes, simulations, stream_socket,
            streams, studies, surfaces, tenants, trace,
        },
        layers::{
            conditional, cors, headers, observe,
            operations::{self, Operations},
            unsent,
        },
    },
};

/// The documented groups.
pub fn groups() -> OpenApiRouter<AppState> {
    versioned().merge(meta::health()).merge(meta::operation())
}

/// The groups of the versioned interface. A new group is one more `merge` here.
fn versioned() -> OpenApiRouter<AppState> {
    let mut all = OpenApiRouter::with_openapi(Contract::openapi())
        .merge(fits::group())
        .merge(studies::group())
        .merge(curves::group())
        .merge(surfaces::group())
        .merge(jobs::group())
        .merge(iterations::group())
        .merge(job_fits::group())
        .merge(previews::group())
        .merge(gears::group())
        .merge(gear_records::group())
        .merge(gear_corrections::group())
        .merge(applied::group())
        .merge(imports::group())
        .merge(nodes::group())
        .merge(shapes::group())
        .merge(records::group())
        .merge(simulations::group())
        .merge(trace::group())
        .merge(audit::group())
        .merge(events::group())
        .merge(streams::group())
        .merge(stream_socket::group())
        .merge(life::group())
        .merge(keys::group())
        .merge(tenants::group());
    scopes::declare(all.get_openapi_mut());
    openapi::progress::declare(all.get_openapi_mut());
    all
}

/// The service: documented groups, documentation, fallbacks and the layers around every request.
pub fn router(state: AppState) -> Router {
    let served = versioned().merge(meta::health());
    let served = if state.settings.ops_bind.is_some() { served } else { served.merge(meta::operation()) };
    let beside = meta::undocumented(&state).fallback(dashboard::not_found);
    complete(served, beside, state)
}

/// Builds the router of the listener for operation.
pub fn operation_router(state: AppState) -> Router {
    complete(meta::health().merge(meta::operation()), Router::new().fallback(async || dashboard::no_path()), state)
}

fn complete(served: OpenApiRouter<AppState>, beside: Router<AppState>, state: AppState) -> Router {
    let (documented, document) = served.split_for_parts();
    // One pile: a router boxes every layer that it is given by itself. The first is the outermost.
    let layers = ServiceBuilder::new()
        .layer(middleware::from_fn(observe::identify))
        .layer(option_layer(cors::layer(&state.settings.cors_origins)))
        .map_request(headers::offered_encodings)
        // Answers are digits: the fastest level halves them, higher ones cost ten times as much for
        // little.
        .layer(CompressionLayer::new().quality(CompressionLevel::Fastest))
        .layer(middleware::from_fn_with_state(state.clone(), observe::observe))
        .layer(middleware::from_fn_with_state(state.clone(), unsent::charge))
        .layer(middleware::from_fn(conditional::not_modified))
        .layer(middleware::from_fn_with_state((Operations::of(&document), state.clone()), operations::check));
    documented
        .merge(beside)
        .method_not_allowed_fallback(|| async {
            Problem::new(ProblemCode::MethodNotAllowed, "The header `allow` names the methods of this path.")
        })
        .layer(layers)
        .with_state(state)
}
