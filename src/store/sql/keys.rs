//! The idempotency keys of a transaction.
//!
//! It claims them all in its beginning, so that of two transactions with the same key the second
//! waits for the end of the first. A claim is a row without an answer; before the transaction ends
//! it gets one, or it is deleted because its request was refused.
//!
//! The answer to a new iteration or fit contains the result of that fit, which is stored anyway:
//! the row names the fit, and has the parts of the answer before and after its result.

use std::collections::HashMap;

use super::prelude::*;

/// A key by its tenant, its text and its scope.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct OwnedKey {
    tenant: String,
    key: String,
    scope: String,
}

impl OwnedKey {
    pub fn of(tenant: &Tenant, receipt: &Receipt) -> Self {
        let request = &receipt.request;
        OwnedKey { tenant: tenant.as_str().to_owned(), key: request.key.clone(), scope: request.scope.clone() }
    }

    fn values(&self) -> Vec<Value<'_>> {
        vec![(&self.tenant).into(), (&self.key).into(), (&self.scope).into()]
    }
}

/// The keys of a transaction.
#[derive(Default)]
pub struct Keys {
    /// Those that were free, with the responses to keep.
    claimed: HashMap<OwnedKey, Option<Kept>>,
}

/// An answer on its way into the database.
struct Kept {
    request_sha256: [u8; 32],
    answer: Answer,
    /// The job or stream that it is about.
    about: Option<Uuid>,
    /// The fit whose result it contains, and the part after the result.
    fit: Option<(FitPlace, Vec<u8>)>,
    now: Timestamp,
}

/// A fit by the key of its row.
#[derive(Clone, Copy)]
pub struct FitPlace {
    pub job: Uuid,
    pub number: u32,
    pub position: i64,
}

/// A stored fit that an answer describes.
pub struct StoredFit<'a> {
    pub place: FitPlace,
    pub result: &'a str,
}

impl Keys {
    /// Claims those of the keys that are free, in ascending order. Those of an earlier transaction
    /// are forgotten.
    pub async fn claim(&mut self, db: &mut Db, mut wanted: Vec<&OwnedKey>) -> Result<(), sqlx::Error> {
        wanted.sort_unstable();
        wanted.dedup();
        let rows: Vec<Vec<Value<'_>>> = wanted.into_iter().map(OwnedKey::values).collect();
        let free: Vec<(String, String, String)> = db
            .all_rows(
                "INSERT INTO idempotency_keys (tenant, key, scope) SELECT * FROM",
                rows,
                "WHERE column1 IS NOT NULL ON CONFLICT DO NOTHING RETURNING tenant, key, scope",
            )
            .await?;
        let free = free.into_iter().map(|(tenant, key, scope)| (OwnedKey { tenant, key, scope }, None));
        self.claimed = free.collect();
        Ok(())
    }

    /// Returns whether no answer is kept under a key that was to be claimed.
    pub fn is_free(&self, key: &OwnedKey) -> bool {
        matches!(self.claimed.get(key), Some(None))
    }

    /// Refuses a request whose key has an answer already (its client asked twice, and the other
    /// request was first).
    pub fn refuse_taken(&self, key: Option<&OwnedKey>) -> Result<(), RepositoryError> {
        match key {
            Some(key) if !self.is_free(key) => Err(RepositoryError::KeyTaken),
            _ => Ok(()),
        }
    }

    /// Keeps the answer in the transaction of the change that it describes.
    pub fn keep(
        &mut self,
        tenant: &Tenant,
        receipt: Option<&Receipt>,
        about: Option<Uuid>,
        stored: Stored,
        fit: Option<StoredFit<'_>>,
        now: Timestamp,
    ) {
        let Some(receipt) = receipt else { return };
        let mut answer = (receipt.answer)(stored);
        let parts = fit.and_then(|fit| {
            let (before, after) = around(&answer.body, fit.result)?;
            Some((before.to_vec(), (fit.place, after.to_vec())))
        });
        let fit = parts.map(|(before, fit)| {
            answer.body = before;
            fit
        });
        let kept = Kept { request_sha256: receipt.request.request_sha256, answer, about, fit, now };
        self.claimed.insert(OwnedKey::of(tenant, receipt), Some(kept));
    }

    /// Forgets the responses of a tenant for which `of` is true, given the job or stream and the
    /// time of each.
    pub fn forget(&mut self, tenant: &Tenant, of: impl Fn(Option<Uuid>, Timestamp) -> bool) {
        for (key, kept) in &mut self.claimed {
            if key.tenant == tenant.as_str() && kept.as_ref().is_some_and(|kept| of(kept.about, kept.now)) {
                *kept = None;
            }
        }
    }

    /// Returns the statements that write the responses and give the other claims back.
    pub fn writing(&self, db: &Db) -> Vec<Ready<'_>> {
        let unused = self.claimed.iter().filter(|(_, kept)| kept.is_none()).map(|(key, _)| key.values());
        let sql = "DELETE FROM idempotency_keys WHERE (tenant, key, scope) IN (SELECT * FROM";
        let mut all = db.of_rows(sql, unused.collect(), ")");
        let answered = self.claimed.iter().filter_map(|(key, kept)| Some((key, kept.as_ref()?)));
        let rows = answered.map(|(key, kept)| {
            let Kept { request_sha256, answer, about, fit, now } = kept;
            let place = fit.as_ref().map(|(place, _)| *place);
            let mut row = key.values();
            row.extend([
                request_sha256.into(),
                answer.status.into(),
                answer.location.as_deref().into(),
                answer.etag.as_deref().into(),
                place.map(|place| place.job).into(),
                place.map(|place| place.number).into(),
                place.map(|place| place.position).into(),
                (*now).into(),
                (&answer.body).into(),
                fit.as_ref().map(|(_, after)| after).into(),
                (*about).into(),
            ]);
            row
        });
        all.extend(db.of_rows(
            "UPDATE idempotency_keys SET request_sha256 = column4, status = column5, location = column6,
                    etag = column7, job = column8, number = column9, fit = column10, created_at = column11,
                    body = column12, body_end = column13, about = column14
             FROM",
            rows.collect(),
            "WHERE tenant = column1 AND key = column2 AND scope = column3",
        ));
        all
    }
}

/// Returns the parts of a body before and after a text; `None` if the body does not contain it.
///
/// Answers end with the result of their fit, but for a few brackets; so it is looked for from the
/// end.
fn around<'a>(body: &'a [u8], text: &str) -> Option<(&'a [u8], &'a [u8])> {
    let last = body.len().checked_sub(text.len())?;
    let at = (0..=last).rev().find(|&at| body[at..].starts_with(text.as_bytes()))?;
    Some((&body[..at], &body[at + text.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_and_the_text_are_the_body() {
        let parts = |body: &'static str, text| around(body.as_bytes(), text);
        assert_eq!(parts("[{1}]", "{1}"), Some((b"[".as_slice(), b"]".as_slice())));
        assert_eq!(parts("{1}", "{1}"), Some((b"".as_slice(), b"".as_slice())));
        // the last of several
        assert_eq!(parts("{1}{1},", "{1}"), Some((b"{1}".as_slice(), b",".as_slice())));
        assert_eq!(parts("[{1}]", "{2}"), None);
        assert_eq!(parts("{", "{1}"), None);
    }
}
