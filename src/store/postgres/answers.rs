//! Answers kept under idempotency keys, read and forgotten.

use sqlx::PgPool;

use super::{session::Session, time::stamp, upkeep};
use crate::{
    jobs::{Answer, Caller},
    store::shared::{AnswerRow, ForgetAnswers, GetAnswer, Outcome, Read, Run},
};

impl Read<PgPool> for GetAnswer {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Option<([u8; 32], Answer)>> {
        let row: Option<AnswerRow> = sqlx::query_as(
            "SELECT k.request_sha256, k.status, k.location, k.etag, k.body, f.result, k.body_end
             FROM idempotency_keys k
                  LEFT JOIN fits f ON f.job = k.job AND f.number = k.number AND f.position = k.fit
             WHERE k.tenant = $1 AND k.key = $2 AND k.scope = $3",
        )
        .bind(caller.tenant.as_str())
        .bind(self.key.as_str())
        .bind(self.scope.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Run<Session> for ForgetAnswers {
    /// One process at a time does so.
    async fn run(&self, session: &mut Session) -> Outcome<u64> {
        if !upkeep::alone(&mut session.db).await? {
            return Ok(0);
        }
        let forgotten = sqlx::query(
            "DELETE FROM idempotency_keys k USING
             (SELECT tenant, key, scope FROM idempotency_keys WHERE created_at < $1 ORDER BY created_at LIMIT $2) AS old
             WHERE k.tenant = old.tenant AND k.key = old.key AND k.scope = old.scope",
        )
        .bind(stamp(self.before))
        .bind(i64::from(self.most))
        .execute(&mut session.db)
        .await?;
        Ok(forgotten.rows_affected())
    }
}
