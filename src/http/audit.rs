//! The audit: its entries, and their verification.

use axum::Json;
use utoipa_axum::{router::OpenApiRouter, routes};
use uuid::Uuid;

use super::{
    caller_state::CallerState,
    extract::{PathOf, QueryOf},
    paging::PageQuery,
    state::AppState,
};
use crate::{
    api::{
        jobs::audit::{AuditPageBody, SealPageBody, VerdictBody},
        problem::Problem,
    },
    jobs::{List, audit::Chain},
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(list_job_audit))
        .routes(routes!(verify_job_audit))
        .routes(routes!(list_audit))
        .routes(routes!(list_audit_seals))
}

/// Every change of a job, oldest first.
///
/// Each entry has the digest of the one before it, so a changed or missing entry is detected. The
/// entries of a deleted job are kept. A job that is older than the audit begins with a digest of
/// its state at its first change.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/audit", operation_id = "list_job_audit", tag = "audit",
    params(("job_id" = Uuid, Path), PageQuery),
    responses((status = 200, description = "Some entries, and where the next page begins.", body = AuditPageBody))
)]
async fn list_job_audit(
    state: CallerState,
    PathOf(job): PathOf<Uuid>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<Json<AuditPageBody>, Problem> {
    Ok(Json(state.jobs.audit(Chain::Job(job), query.check(List::Audit)?).await?.into()))
}

/// Verifies the audit entries of a job and the rows they have digests of.
///
/// Reads the whole job and computes the digest of every entry and every row again. The answer names
/// the first entry at fault.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/audit/verify", operation_id = "verify_job_audit", tag = "audit",
    params(("job_id" = Uuid, Path)),
    responses((status = 200, description = "The result of the verification.", body = VerdictBody))
)]
async fn verify_job_audit(state: CallerState, PathOf(job): PathOf<Uuid>) -> Result<Json<VerdictBody>, Problem> {
    Ok(Json(state.jobs.verify_audit(Chain::Job(job)).await?.into()))
}

/// Changes of the tenant that are of no job, oldest first.
///
/// The chain of a tenant has the changes of its keys and of the tenant itself; changes of jobs are
/// in the chains of the jobs.
#[utoipa::path(
    get, path = "/v1/audit", operation_id = "list_audit", tag = "audit",
    params(PageQuery),
    responses((status = 200, description = "Some entries, and where the next page begins.", body = AuditPageBody))
)]
async fn list_audit(state: CallerState, QueryOf(query): QueryOf<PageQuery>) -> Result<Json<AuditPageBody>, Problem> {
    Ok(Json(state.jobs.audit(Chain::Tenant, query.check(List::Audit)?).await?.into()))
}

/// The tenant's seals, oldest first.
///
/// About once a minute a server seals the last entries of the chains that have grown since the seal
/// before. Keep copies of the seals where no administrator of the database can change them: they
/// reveal a rewritten chain.
#[utoipa::path(
    get, path = "/v1/audit/seals", operation_id = "list_audit_seals", tag = "audit",
    params(PageQuery),
    responses((status = 200, description = "Some seals, and where the next page begins.", body = SealPageBody))
)]
async fn list_audit_seals(
    state: CallerState,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<Json<SealPageBody>, Problem> {
    Ok(Json(state.jobs.seals(query.check(List::Seals)?).await?.into()))
}
