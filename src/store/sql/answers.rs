//! Answers kept under idempotency keys, read and forgotten.

use super::{prelude::*, upkeep};

row! {
    /// An answer kept under an idempotency key: whole, or around the result of a fit.
    struct AnswerRow {
        request_sha256: [u8; 32],
        status: u16,
        location: Option<String>,
        etag: Option<String>,
        body: Vec<u8>,
        result: Option<Arc<str>>,
        body_end: Option<Vec<u8>>,
    }
}

impl From<AnswerRow> for ([u8; 32], Answer) {
    fn from(row: AnswerRow) -> Self {
        let AnswerRow { request_sha256, status, location, etag, mut body, result, body_end } = row;
        body.extend(result.iter().flat_map(|result| result.as_bytes()));
        body.extend(body_end.unwrap_or_default());
        (request_sha256, Answer { status, location, etag, body })
    }
}

pub async fn answer(db: &mut Db, caller: &Caller, key: &String, scope: &String) -> Outcome<Option<([u8; 32], Answer)>> {
    let sql = "SELECT k.request_sha256, k.status, k.location, k.etag, k.body, f.result, k.body_end
               FROM idempotency_keys k LEFT JOIN fits f ON f.job = k.job AND f.number = k.number AND f.position = k.fit
               WHERE k.tenant = $1 AND k.key = $2 AND k.scope = $3";
    let row: Option<AnswerRow> = db.maybe(sql, args![&caller.tenant, key, scope]).await?;
    Ok(row.map(Into::into))
}

/// Forgets kept responses from before a time, the oldest first, at most so many; returns how many.
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
