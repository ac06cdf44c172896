//! `/v1/tenants`: for those who are of no tenant themselves.

use super::keys::first_key_must_be_admin;
use super::prelude::*;
use crate::{
    api::callers::tenant::{NewTenantBody, TenantBody, TenantPatchBody},
    jobs::{ApiKey, KeyDraft, Plant, PlantDraft, Role, Secret, Tenant},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(create_tenant, list_tenants)).routes(routes!(get_tenant, update_tenant))
}

/// Create a tenant
///
/// The response has its first key, with the role `admin`, which can make the tenant's other keys. A
/// server that does not require keys yet needs an administrator's key (`POST /v1/keys`) before the
/// first tenant.
#[utoipa::path(
    post, path = "/v1/tenants", operation_id = "create_tenant", tag = "tenants",
    params(IdempotencyKey),
    request_body(content = NewTenantBody, description = "The tenant's name."),
    responses(
        (status = 201, description = "The tenant with the secret of its first key in `admin_key`. A repeated response \
            to the same `Idempotency-Key` has no secret.", body = TenantBody),
        (status = 409, description = "There is a tenant of this name, there is no administrator's key yet, or the \
            first request with this idempotency key is still running.")
    )
)]
async fn create_tenant(post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let body = read_small::<NewTenantBody>(&state, payload).await?;
        let draft = PlantDraft::try_from(body).map_err(Problem::invalid)?;
        if state.callers.await_first_key().await? {
            return Err(first_key_must_be_admin());
        }
        let keyed = key.map(|key| key.answered_by(|made: &(Plant, ApiKey), _| created(made, None)));
        let (made, secret) = state.tenant_keys().create_plant(draft, first_key(), keyed).await?;
        Ok(created(&made, secret.as_ref()))
    })
    .await
}

/// The key with which a tenant begins.
fn first_key() -> KeyDraft {
    let role = Role::Admin;
    KeyDraft { name: "first key".into(), role: Some(role), scopes: role.scopes(), expires_at: None, san: None }
}

fn created(made: &(Plant, ApiKey), secret: Option<&Secret>) -> Answer {
    let (plant, _) = made;
    Answer::created(
        format!("/v1/tenants/{}", plant.name.as_str()),
        etag(plant.version),
        text_of(&TenantBody::created(made, secret)).into_bytes(),
    )
}

/// List tenants
///
/// Tenants come newest first. `next_cursor` of one page is the `cursor` of the next; the last page
/// has none.
#[utoipa::path(
    get, path = "/v1/tenants", operation_id = "list_tenants", tag = "tenants",
    params(PageQuery),
    responses((status = 200, description = "A page of tenants.", body = PageBody<TenantBody>))
)]
async fn list_tenants(
    state: CallerState,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<TenantBody>>, Problem> {
    let page = state.tenant_keys().plants(query.check(List::Tenants)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Tenants)))
}

/// Get a tenant
///
/// The header `ETag` has its version, for a conditional `PATCH`.
#[utoipa::path(
    get, path = "/v1/tenants/{tenant}", operation_id = "get_tenant", tag = "tenants",
    responses((status = 200, description = "The tenant.", body = TenantBody))
)]
async fn get_tenant(state: CallerState, PathOf(name): PathOf<String>) -> Result<Response, Problem> {
    Ok(present(&state.tenant_keys().plant(named(&name)?).await?))
}

/// Update a tenant
///
/// Omitted fields stay unchanged. The keys of a suspended tenant are refused; its data is kept, and
/// the tenant can be resumed. (Keys in the server's settings are not affected.)
#[utoipa::path(
    patch, path = "/v1/tenants/{tenant}", operation_id = "update_tenant", tag = "tenants",
    params(IfMatch),
    request_body(content = TenantPatchBody, description = "The fields to change."),
    responses((status = 200, description = "The tenant after the change.", body = TenantBody))
)]
async fn update_tenant(
    state: CallerState,
    PathOf(name): PathOf<String>,
    IfMatch(precondition): IfMatch,
    JsonOf(body): JsonOf<TenantPatchBody>,
) -> Result<Response, Problem> {
    Ok(present(&state.tenant_keys().patch_plant(named(&name)?, body.into(), precondition).await?))
}

/// The tenant in a path; a name of another form is one that does not exist.
fn named(segment: &str) -> Result<Tenant, Problem> {
    Tenant::named(segment).ok_or_else(|| Problem::new(ProblemCode::NotFound, "There is no such tenant."))
}

fn present(plant: &Plant) -> Response {
    let mut response = axum::Json(TenantBody::from(plant)).into_response();
    set_etag(response.headers_mut(), plant.version);
    // no cache may keep permissions
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}
