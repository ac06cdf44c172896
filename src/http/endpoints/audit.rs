//! The audit: its entries, its seals, and their verification.

use axum::Json;

use super::prelude::*;
use crate::api::jobs::audit::{EntryBody, SealBody, VerdictBody};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(list_audit)).routes(routes!(verify_audit)).routes(routes!(list_audit_seals))
}

/// A job, if only its audit is wanted.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct JobQuery {
    /// Id of a job; without it the whole tenant.
    #[param(value_type = Option<Uuid>)]
    job: Option<String>,
}

/// A page of the audit.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct AuditQuery {
    /// Id of a job, which may have been deleted; without it the whole tenant.
    #[param(value_type = Option<Uuid>)]
    job: Option<String>,
    /// Most items on a page.
    #[param(value_type = Option<u32>, minimum = 1, maximum = 200, default = 50)]
    limit: Option<String>,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
}

fn read_job(job: Option<String>) -> Result<Option<Uuid>, Problem> {
    let read = |id: String| id.parse().map_err(|_| Problem::invalid(Faults::one("/job", "expected the id of a job")));
    job.map(read).transpose()
}

/// List audit entries
///
/// Each change of the tenant, of its keys and of its jobs has one entry, oldest first. Entries of a
/// deleted job are kept.
#[utoipa::path(
    get, path = "/v1/audit", operation_id = "list_audit", tag = "audit",
    params(AuditQuery),
    responses((status = 200, description = "A page of entries.", body = PageBody<EntryBody>))
)]
async fn list_audit(
    state: CallerState,
    QueryOf(query): QueryOf<AuditQuery>,
) -> Result<Json<PageBody<EntryBody>>, Problem> {
    let page = PageQuery { limit: query.limit, cursor: query.cursor }.check(List::Audit)?;
    Ok(Json(PageBody::new(state.jobs.audit(read_job(query.job)?, page).await?, List::Audit)))
}

/// Verify the audit of a job or tenant
///
/// Computes the digest of every row, entry, link and seal again, and lists every difference from
/// what was written. Entries of the last seconds are not sealed yet: `unsealed` of them are
/// verified against their rows only.
#[utoipa::path(
    get, path = "/v1/audit/verify", operation_id = "verify_audit", tag = "audit",
    params(JobQuery),
    responses((status = 200, description = "The result of the verification.", body = VerdictBody))
)]
async fn verify_audit(state: CallerState, QueryOf(query): QueryOf<JobQuery>) -> Result<Json<VerdictBody>, Problem> {
    Ok(Json(state.jobs.verify_audit(read_job(query.job)?).await?.into()))
}

/// List the seals of the audit
///
/// Seals come oldest first. Every few seconds a server links the new entries of each tenant into
/// its chain and seals the end of the chain. Keep copies of the seals where no administrator of the
/// database can change them: they reveal a rewritten chain.
#[utoipa::path(
    get, path = "/v1/audit/seals", operation_id = "list_audit_seals", tag = "audit",
    params(PageQuery),
    responses((status = 200, description = "A page of seals.", body = PageBody<SealBody>))
)]
async fn list_audit_seals(
    state: CallerState,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<Json<PageBody<SealBody>>, Problem> {
    Ok(Json(PageBody::new(state.jobs.seals(query.check(List::Seals)?).await?, List::Seals)))
}
