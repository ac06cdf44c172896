//! `/v1/keys` and `/v1/whoami`: keys of the caller's tenant, and who the caller is.

use jiff::SignedDuration;

use super::prelude::*;
use crate::{
    api::{
        callers::{
            key::{KeyBody, KeyPatchBody, NewKeyBody, RotationBody},
            whoami::{ProofName, WhoamiBody},
        },
        warning::WarningBody,
    },
    http::layers::auth::{Principal, Proof},
    jobs::{ApiKey, KeyId, Page, PageRequest, Role, Scope, Scopes, Secret, TenantKeys},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_key, list_keys))
        .routes(routes!(get_key, update_key, revoke_key))
        .routes(routes!(rotate_key))
        .routes(routes!(whoami))
}

/// Create a key
///
/// The key belongs to the caller's tenant. Its scopes must be among those of the caller's key,
/// except that a key with the role `admin` makes keys of every role of its tenant. A key of the
/// kind `certificate` has no secret: clients with a certificate of its name need no other key.
///
/// A server that does not require keys yet must first get a secret with the role `admin`. Restarted
/// with `--auth auto`, it requires a key for every request, as the response's `warnings` say.
#[utoipa::path(
    post, path = "/v1/keys", operation_id = "create_key", tag = "keys",
    params(IdempotencyKey),
    request_body(content = NewKeyBody, description = "Name, kind, scopes and lifetime of the key."),
    responses(
        (status = 201, description = "The key with its secret in `key`. A repeated response to the same \
            `Idempotency-Key` has no secret.", body = KeyBody),
        (status = 403, description = "The caller lacks a scope: `admin`, or one that the new key would allow."),
        (status = 409, description = "Another certificate key has this name, the first key is not an administrator's, \
            or the first request with this idempotency key is still running.")
    )
)]
async fn create_key(post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let keys = state.tenant_keys();
        let body = read_small::<NewKeyBody>(&state, payload).await?;
        let draft = body.draft(keys.now()).map_err(Problem::invalid)?;
        check_grant(&state.principal, draft.scopes)?;
        let is_first = state.callers.await_first_key().await?;
        if is_first && (draft.role != Some(Role::Admin) || draft.san.is_some()) {
            return Err(first_key_must_be_admin());
        }
        let created = move |key: &ApiKey, secret: Option<&Secret>| created(key, secret, is_first);
        let keyed = key.map(|key| key.answered_by(move |key: &ApiKey, _| created(key, None)));
        let (made, secret) = keys.create(draft, keyed).await?;
        if is_first {
            tracing::warn!(key = %made.id, "{FIRST_KEY}");
        }
        Ok(created(&made, secret.as_ref()))
    })
    .await
}

/// Warning about the consequences of the first key.
const FIRST_KEY: &str = "this is the first key: after a restart (with --auth auto) every request under /v1 needs a \
    key. Keep this one, which can create others";

/// 409: with any other first key no caller could create keys once they are required.
pub(super) fn first_key_must_be_admin() -> Problem {
    let detail = "There is no key yet, and after the first one the next start requires keys: create a secret with the \
        role `admin` first (POST /v1/keys with \"role\": \"admin\"), and keep it.";
    Problem::new(ProblemCode::FirstKeyMustBeAdmin, detail)
}

fn created(key: &ApiKey, secret: Option<&Secret>, is_first: bool) -> Answer {
    let first = || WarningBody::new("first_key", FIRST_KEY.to_owned());
    let body = KeyBody { warnings: is_first.then(first).into_iter().collect(), ..KeyBody::of(key, secret) };
    Answer::created(format!("/v1/keys/{}", key.id), etag(key.version), text_of(&body).into_bytes())
}

/// Refuses to grant what the one who grants has not.
fn check_grant(maker: &Principal, wanted: Scopes) -> Result<(), Problem> {
    let grants = if maker.role == Some(Role::Admin) { Scopes::OF_TENANT } else { maker.scopes };
    match wanted.iter().find(|scope| !grants.contains(*scope)) {
        None => Ok(()),
        Some(scope) => Err(Problem::lacking_scope(format!(
            "The key allows `{}`, which this caller lacks: it can neither grant nor revoke it.",
            scope.name()
        ))),
    }
}

/// List keys
///
/// Lists the keys of the caller's tenant, newest first, ended ones included. `next_cursor` of one
/// page is the `cursor` of the next; the last page has none.
#[utoipa::path(
    get, path = "/v1/keys", operation_id = "list_keys", tag = "keys",
    params(PageQuery),
    responses((status = 200, description = "A page of keys.", body = PageBody<KeyBody>))
)]
async fn list_keys(
    state: CallerState,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<KeyBody>>, Problem> {
    let page = state.tenant_keys().keys(query.check(List::Keys)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Keys)))
}

/// Get a key
///
/// The response has no secret. The header `ETag` has the version of the key, for a conditional
/// `PATCH`.
#[utoipa::path(
    get, path = "/v1/keys/{key_id}", operation_id = "get_key", tag = "keys",
    responses((status = 200, description = "The key.", body = KeyBody))
)]
async fn get_key(state: CallerState, PathOf(id): PathOf<String>) -> Result<Response, Problem> {
    Ok(present(&state.tenant_keys().key(key_id(&id)?).await?))
}

/// Update a key
///
/// Changes the name or the expiry; omitted fields stay unchanged. The scopes of a key cannot be
/// changed: create another key. An expired key cannot be changed or renewed.
#[utoipa::path(
    patch, path = "/v1/keys/{key_id}", operation_id = "update_key", tag = "keys",
    params(IfMatch),
    request_body(content = KeyPatchBody, description = "The fields to change."),
    responses(
        (status = 200, description = "The key after the change.", body = KeyBody),
        (status = 403, description = "The caller lacks a scope: `admin`, or one that the key allows."),
        (status = 409, description = "The key has expired or is revoked, or it was replaced and would expire later \
            than now.")
    )
)]
async fn update_key(
    state: CallerState,
    PathOf(id): PathOf<String>,
    IfMatch(precondition): IfMatch,
    JsonOf(body): JsonOf<KeyPatchBody>,
) -> Result<Response, Problem> {
    let (keys, id) = (state.tenant_keys(), key_id(&id)?);
    let patch = body.patch(keys.now()).map_err(Problem::invalid)?;
    check_grant(&state.principal, keys.key(id).await?.scopes)?;
    Ok(present(&keys.patch(id, patch, precondition).await?))
}

/// Revoke a key
///
/// Every server refuses it within five seconds, and connections opened with it end within thirty.
/// The key is kept as revoked.
#[utoipa::path(
    delete, path = "/v1/keys/{key_id}", operation_id = "revoke_key", tag = "keys",
    responses(
        (status = 204, description = "The key is revoked."),
        (status = 403, description = "The caller lacks a scope: `admin`, or one that the key allows."),
        (status = 409, description = "It is the caller's own key, and no other key of the tenant allows `admin`.")
    )
)]
async fn revoke_key(state: CallerState, PathOf(id): PathOf<String>) -> Result<StatusCode, Problem> {
    let (keys, id) = (state.tenant_keys(), key_id(&id)?);
    check_grant(&state.principal, keys.key(id).await?.scopes)?;
    let own = matches!(&state.principal.proof, Proof::Key(known) if known.key.id == id);
    if own && !has_another_admin(&keys, id).await? {
        let detail = "This key is the last one of its tenant that allows `admin`; create another one first.";
        return Err(Problem::new(ProblemCode::Conflict, detail));
    }
    keys.revoke(id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Whether the tenant has another valid key that allows `admin`.
async fn has_another_admin(keys: &TenantKeys, id: KeyId) -> Result<bool, Problem> {
    let now = keys.now();
    let mut page = PageRequest { limit: 200, after: None };
    loop {
        let Page { items, next } = keys.keys(page).await?;
        if items.iter().any(|key| key.id != id && key.scopes.contains(Scope::Admin) && key.is_valid(now)) {
            return Ok(true);
        }
        match next {
            Some(after) => page.after = Some(after),
            None => return Ok(false),
        }
    }
}

/// Rotate a key
///
/// The new key has an id of its own, and the same name, scopes and lifetime. The old key stays
/// valid for `overlap_seconds` and cannot be rotated again. If the new key is lost, rotate the new
/// key; its id is `replaced_by` of the old one.
#[utoipa::path(
    post, path = "/v1/keys/{key_id}/rotate", operation_id = "rotate_key", tag = "keys",
    params(IdempotencyKey),
    request_body(content = RotationBody, description = "Time for which the old key stays valid."),
    responses(
        (status = 201, description = "The new key with its secret in `key`. A repeated response to the same \
            `Idempotency-Key` has no secret.", body = KeyBody),
        (status = 403, description = "The caller lacks a scope: `admin`, or one that the key allows."),
        (status = 409, description = "The key has expired, is revoked, was rotated before or is of the kind \
            `certificate`, or the first request with this idempotency key is still running.")
    )
)]
async fn rotate_key(PathOf(id): PathOf<String>, post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let keys = state.tenant_keys();
        let old = keys.key(key_id(&id)?).await?;
        let overlap = read_small::<RotationBody>(&state, payload).await?.overlap_seconds;
        check_grant(&state.principal, old.scopes)?;
        let keyed = key.map(|key| key.answered_by(|key: &ApiKey, _| created(key, None, false)));
        let (made, secret) = keys.rotate(&old, SignedDuration::from_secs(overlap.into()), keyed).await?;
        Ok(created(&made, secret.as_ref(), false))
    })
    .await
}

/// Get the caller
///
/// Returns tenant, actor and scopes: for programs that show the scopes of their key, and to find
/// out whose key this is.
#[utoipa::path(
    get, path = "/v1/whoami", operation_id = "whoami", tag = "keys",
    responses((status = 200, description = "The caller.", body = WhoamiBody))
)]
async fn whoami(state: CallerState) -> axum::Json<WhoamiBody> {
    let Principal { caller, scopes, role, proof } = &state.principal;
    let mut body = WhoamiBody::of(caller, *role, *scopes);
    match proof {
        Proof::None => {}
        Proof::Listed => body.kind = Some(ProofName::Secret),
        Proof::Key(known) => body.take_key(&known.key),
        Proof::Token(token) => body.take_token(token.expires_at),
    }
    axum::Json(body)
}

/// The id in a path; one of another form is an id that does not exist.
fn key_id(segment: &str) -> Result<KeyId, Problem> {
    KeyId::named(segment).ok_or_else(|| Problem::new(ProblemCode::NotFound, "There is no such key."))
}

fn present(key: &ApiKey) -> Response {
    let mut response = axum::Json(KeyBody::of(key, None)).into_response();
    set_etag(response.headers_mut(), key.version);
    // no cache may keep permissions
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}
