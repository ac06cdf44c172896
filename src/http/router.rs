//! Every endpoint group in one place. Groups are built by `utoipa-axum`, so what is served is what is documented.

use axum::Router;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::{fits, meta, observe, state::AppState};
use crate::api::problem::{Problem, ProblemCode};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "flankfit",
        description = "Robust parametric estimation of tooth-flank surfaces: coefficients with standard errors and \
                       bias bounds, eigen diagnostics, and every choice of λ* side by side.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(Problem)),
    tags(
        (name = "fits", description = "Fits of node sets; nothing is stored."),
        (name = "operation", description = "Health, metrics and this document.")
    )
)]
struct Contract;

/// The documented groups. A new group is one more `merge` here.
fn groups() -> OpenApiRouter<AppState> {
    OpenApiRouter::with_openapi(Contract::openapi()).merge(fits::group()).merge(meta::group())
}

/// The OpenAPI document of what is served.
pub fn openapi() -> utoipa::openapi::OpenApi {
    groups().into_openapi()
}

/// The service: documented groups, documentation, fallbacks and the layer around every request.
pub fn router(state: AppState) -> Router {
    let (documented, _) = groups().split_for_parts();
    documented
        .merge(meta::undocumented(&state))
        .fallback(|| async { Problem::new(ProblemCode::NotFound, "No such path; /docs lists what there is.") })
        .method_not_allowed_fallback(|| async {
            Problem::new(ProblemCode::MethodNotAllowed, "The header `allow` names the methods of this path.")
        })
        .layer(axum::middleware::from_fn_with_state(state.clone(), observe::observe))
        .with_state(state)
}
