//! Answers kept under idempotency keys.

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};

use super::time;
use crate::{
    jobs::{Answer, Receipt, RepositoryError, Stored},
    store::shared::{AnswerRow, ForgetAnswers, Outcome, Run},
};

/// Whether an answer is kept under the key of a receipt.
pub async fn is_taken(db: &mut SqliteConnection, receipt: &Receipt) -> Result<bool, sqlx::Error> {
    let row = sqlx::query("SELECT 1 FROM idempotency_keys WHERE key = ? AND scope = ?")
        .bind(receipt.request.key.as_str())
        .bind(receipt.request.scope.as_str())
        .fetch_optional(db)
        .await?;
    Ok(row.is_some())
}

/// Refuses a request whose key has an answer already (its client asked twice, and the other one was
/// first).
pub async fn refuse_taken(db: &mut SqliteConnection, receipt: Option<&Receipt>) -> Outcome<()> {
    match receipt {
        Some(receipt) if is_taken(db, receipt).await? => Err(RepositoryError::KeyTaken.into()),
        _ => Ok(()),
    }
}

/// Keeps the answer in the transaction of what it tells of.
pub async fn keep(db: &mut SqliteConnection, receipt: Option<&Receipt>, stored: Stored, now: Timestamp) -> Outcome<()> {
    let Some(receipt) = receipt else { return Ok(()) };
    let answer = (receipt.answer)(stored);
    sqlx::query(
        "INSERT INTO idempotency_keys (key, scope, request_sha256, status, location, etag, body, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(receipt.request.key.as_str())
    .bind(receipt.request.scope.as_str())
    .bind(receipt.request.request_sha256.as_slice())
    .bind(i64::from(answer.status))
    .bind(answer.location)
    .bind(answer.etag)
    .bind(answer.body)
    .bind(time::to_text(now))
    .execute(&mut *db)
    .await?;
    Ok(())
}

pub async fn answer(db: &SqlitePool, key: &str, scope: &str) -> Outcome<Option<([u8; 32], Answer)>> {
    let row: Option<AnswerRow> = sqlx::query_as(
        "SELECT request_sha256, status, location, etag, body FROM idempotency_keys WHERE key = ? AND scope = ?",
    )
    .bind(key)
    .bind(scope)
    .fetch_optional(db)
    .await?;
    Ok(row.map(Into::into))
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
