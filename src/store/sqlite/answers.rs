//! Answers kept under idempotency keys.
//!
//! The answer to a new iteration or fit has the result of that fit in it, which is stored anyway:
//! of such an answer the fit is named, and what stands around its result is kept.

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};

use super::{tasks, time};
use crate::{
    jobs::{Answer, Caller, Receipt, RepositoryError, Stored, Tenant},
    store::shared::{AnswerRow, ForgetAnswers, GetAnswer, Outcome, Read, Run, around},
};

/// Whether an answer is kept under the key of a receipt.
pub async fn is_taken(db: &mut SqliteConnection, tenant: &Tenant, receipt: &Receipt) -> Result<bool, sqlx::Error> {
    let row = sqlx::query("SELECT 1 FROM idempotency_keys WHERE tenant = ? AND key = ? AND scope = ?")
        .bind(tenant.as_str())
        .bind(receipt.request.key.as_str())
        .bind(receipt.request.scope.as_str())
        .fetch_optional(db)
        .await?;
    Ok(row.is_some())
}

/// Refuses a request whose key has an answer already (its client asked twice, and the other one was
/// first), and one of a task that another does by now.
pub async fn refuse_taken(db: &mut SqliteConnection, tenant: &Tenant, receipt: Option<&Receipt>) -> Outcome<()> {
    match receipt {
        Some(receipt) if !tasks::holds(db, receipt).await? => Err(RepositoryError::LeaseLost.into()),
        Some(receipt) if is_taken(db, tenant, receipt).await? => Err(RepositoryError::KeyTaken.into()),
        _ => Ok(()),
    }
}

/// A fit that was stored with what an answer tells of.
pub struct StoredFit<'a> {
    pub seq: i64,
    pub result: &'a str,
}

/// Keeps the answer in the transaction of what it tells of, and ends the task that asked for it.
pub async fn keep(
    db: &mut SqliteConnection,
    tenant: &Tenant,
    receipt: Option<&Receipt>,
    stored: Stored,
    now: Timestamp,
    fit: Option<StoredFit<'_>>,
) -> Outcome<()> {
    let Some(receipt) = receipt else { return Ok(()) };
    let Answer { status, location, etag, body } = (receipt.answer)(stored);
    let around = fit.and_then(|fit| Some((fit.seq, around(&body, fit.result)?)));
    let (fit, body, body_end) = match around {
        Some((fit, (before, after))) => (Some(fit), before, Some(after)),
        None => (None, body.as_slice(), None),
    };
    sqlx::query(
        "INSERT INTO idempotency_keys
             (tenant, key, scope, request_sha256, status, location, etag, body, fit, body_end, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(tenant.as_str())
    .bind(receipt.request.key.as_str())
    .bind(receipt.request.scope.as_str())
    .bind(receipt.request.request_sha256.as_slice())
    .bind(i64::from(status))
    .bind(location)
    .bind(etag)
    .bind(body)
    .bind(fit)
    .bind(body_end)
    .bind(time::to_text(now))
    .execute(&mut *db)
    .await?;
    match receipt.request.lease {
        Some(lease) => tasks::end_kept(db, lease, status, now).await,
        None => Ok(()),
    }
}

impl Read<SqlitePool> for GetAnswer {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<([u8; 32], Answer)>> {
        let row: Option<AnswerRow> = sqlx::query_as(
            "SELECT k.request_sha256 AS request_sha256, k.status AS status, k.location AS location, k.etag AS etag,
                    k.body AS body, coalesce(f.frame, f.result) AS result, k.body_end AS body_end
             FROM idempotency_keys k LEFT JOIN fits f ON f.seq = k.fit
             WHERE k.tenant = ? AND k.key = ? AND k.scope = ?",
        )
        .bind(caller.tenant.as_str())
        .bind(self.key.as_str())
        .bind(self.scope.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Run<SqliteConnection> for ForgetAnswers {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<u64> {
        let forgotten = sqlx::query(
            "DELETE FROM idempotency_keys WHERE seq IN
             (SELECT seq FROM idempotency_keys WHERE created_at < ? ORDER BY created_at LIMIT ?)",
        )
        .bind(time::to_text(self.before))
        .bind(i64::from(self.most))
        .execute(db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}
