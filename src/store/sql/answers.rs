//! Answers kept under idempotency keys, read and forgotten.

use jiff::Timestamp;

use super::{
    db::Db,
    error::Outcome,
    row::AnswerRow,
    upkeep,
    write::{Tx, Write},
};
use crate::jobs::{Answer, Caller};

pub async fn answer(db: &mut Db, caller: &Caller, key: &String, scope: &String) -> Outcome<Option<([u8; 32], Answer)>> {
    let sql = "SELECT k.request_sha256, k.status, k.location, k.etag, k.body, f.result, k.body_end
               FROM idempotency_keys k LEFT JOIN fits f ON f.job = k.job AND f.number = k.number AND f.position = k.fit
               WHERE k.tenant = $1 AND k.key = $2 AND k.scope = $3";
    let row: Option<AnswerRow> = db.maybe(sql, args![&caller.tenant, key, scope]).await?;
    Ok(row.map(Into::into))
}

/// Forgets kept answers from before a time, the oldest first, at most so many; returns how many.
pub struct ForgetAnswers {
    pub before: Timestamp,
    pub most: u32,
}

impl Write for ForgetAnswers {
    type Reply = u64;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<u64> {
        let db = tx.db();
        if !upkeep::alone(db).await? {
            return Ok(0);
        }
        let sql = "DELETE FROM idempotency_keys WHERE (tenant, key, scope) IN
                   (SELECT tenant, key, scope FROM idempotency_keys WHERE created_at < $1
                    ORDER BY created_at LIMIT $2)";
        Ok(db.run(sql, args![self.before, self.most]).await?)
    }
}
