//! The idempotency keys of a transaction.
//!
//! It claims them all in its beginning, so that of two with the same key the second waits for the
//! end of the first. A claim is a row without an answer; before the transaction ends it gets one,
//! or it is deleted because its request was refused.
//!
//! The answer to a new iteration or fit has the result of that fit in it, which is stored anyway:
//! of such an answer the fit is named, and what stands around its result is kept.

use std::collections::{HashMap, HashSet};

use jiff::Timestamp;
use sqlx::PgConnection;
use uuid::Uuid;

use super::{leases, time::stamp};
use crate::{
    jobs::{Answer, Lease, Receipt, RepositoryError, Stored, Tenant},
    store::shared::{Key, Outcome, around, key_of},
};

/// A key by its tenant, its text and its scope.
pub type OwnedKey = (String, String, String);

/// The keys of a transaction.
#[derive(Default)]
pub struct Keys {
    /// Those that were free, with the answers that are to be kept.
    claimed: HashMap<OwnedKey, Option<Kept>>,
    /// The leases that hold, of those under which tasks ask for something.
    held: HashSet<Lease>,
    /// Tasks that end with what is stored for them, with the status of their answer.
    ended: Vec<(Lease, u16, Timestamp)>,
}

/// An answer on its way into the database.
struct Kept {
    request_sha256: [u8; 32],
    answer: Answer,
    /// Where the result stands that the answer has in it, and what stands after it.
    fit: Option<(FitPlace, Vec<u8>)>,
    now: Timestamp,
}

/// A fit by the key of its row.
#[derive(Clone, Copy)]
pub struct FitPlace {
    pub job: Uuid,
    pub number: i64,
    pub position: i64,
}

/// A fit that was stored with what an answer tells of.
pub struct StoredFit<'a> {
    pub place: FitPlace,
    pub result: &'a str,
}

pub fn owned((tenant, key, scope): Key<'_>) -> OwnedKey {
    (tenant.to_owned(), key.to_owned(), scope.to_owned())
}

/// The three columns of keys.
fn columns<'a>(keys: impl Iterator<Item = &'a OwnedKey>) -> (Vec<&'a str>, Vec<&'a str>, Vec<&'a str>) {
    let (mut tenants, mut texts, mut scopes) = (Vec::new(), Vec::new(), Vec::new());
    for (tenant, key, scope) in keys {
        tenants.push(tenant.as_str());
        texts.push(key.as_str());
        scopes.push(scope.as_str());
    }
    (tenants, texts, scopes)
}

impl Keys {
    /// Claims those of the keys that are free. Those of an earlier transaction are forgotten.
    pub async fn claim(&mut self, db: &mut PgConnection, mut wanted: Vec<OwnedKey>) -> Result<(), sqlx::Error> {
        self.claimed.clear();
        if wanted.is_empty() {
            return Ok(());
        }
        wanted.sort_unstable();
        wanted.dedup();
        let (tenants, texts, scopes) = columns(wanted.iter());
        let free: Vec<OwnedKey> = sqlx::query_as(
            "INSERT INTO idempotency_keys (tenant, key, scope) SELECT * FROM unnest($1::text[], $2::text[], $3::text[])
             ON CONFLICT DO NOTHING RETURNING tenant, key, scope",
        )
        .bind(tenants)
        .bind(texts)
        .bind(scopes)
        .fetch_all(db)
        .await?;
        self.claimed = free.into_iter().map(|key| (key, None)).collect();
        Ok(())
    }

    /// Locks the tasks that ask for something. Those of an earlier transaction are forgotten.
    pub async fn hold(&mut self, db: &mut PgConnection, leases: &[Lease]) -> Result<(), sqlx::Error> {
        self.ended.clear();
        self.held = leases::hold(db, leases).await?;
        Ok(())
    }

    /// Refuses a task that another does by now, or that was cancelled.
    pub fn refuse_lost(&self, lease: Option<Lease>) -> Result<(), RepositoryError> {
        match lease {
            Some(lease) if !self.held.contains(&lease) => Err(RepositoryError::LeaseLost),
            _ => Ok(()),
        }
    }

    /// Whether no answer is kept under a key that was to be claimed.
    pub fn is_free(&self, key: Key<'_>) -> bool {
        matches!(self.claimed.get(&owned(key)), Some(None))
    }

    /// Refuses a request whose key has an answer already (its client asked twice, and the other one
    /// was first), and one of a task that another does by now.
    pub fn refuse_taken(&self, tenant: &Tenant, receipt: Option<&Receipt>) -> Outcome<()> {
        self.refuse_lost(receipt.and_then(|receipt| receipt.request.lease))?;
        match receipt {
            Some(receipt) if !self.is_free(key_of(tenant, receipt)) => Err(RepositoryError::KeyTaken.into()),
            _ => Ok(()),
        }
    }

    /// Keeps the answer in the transaction of what it tells of, and ends the task that asked for
    /// it.
    pub fn keep(
        &mut self,
        tenant: &Tenant,
        receipt: Option<&Receipt>,
        stored: Stored,
        now: Timestamp,
        fit: Option<StoredFit<'_>>,
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
        self.ended.extend(receipt.request.lease.map(|lease| (lease, answer.status, now)));
        let kept = Kept { request_sha256: receipt.request.request_sha256, answer, fit, now };
        self.claimed.insert(owned(key_of(tenant, receipt)), Some(kept));
    }

    /// Writes the answers down and gives the other claims back.
    pub async fn write(&mut self, db: &mut PgConnection) -> Result<(), sqlx::Error> {
        leases::end_kept(db, &std::mem::take(&mut self.ended)).await?;
        let claimed = std::mem::take(&mut self.claimed);
        let (answered, unused): (Vec<_>, Vec<_>) = claimed.into_iter().partition(|(_, kept)| kept.is_some());
        if !unused.is_empty() {
            let (tenants, texts, scopes) = columns(unused.iter().map(|(key, _)| key));
            sqlx::query(
                "DELETE FROM idempotency_keys k USING unnest($1::text[], $2::text[], $3::text[]) AS u (tenant, key, scope)
                 WHERE k.tenant = u.tenant AND k.key = u.key AND k.scope = u.scope",
            )
            .bind(tenants)
            .bind(texts)
            .bind(scopes)
            .execute(&mut *db)
            .await?;
        }
        match answered.is_empty() {
            true => Ok(()),
            false => write_answers(db, &answered).await,
        }
    }
}

async fn write_answers(db: &mut PgConnection, answered: &[(OwnedKey, Option<Kept>)]) -> Result<(), sqlx::Error> {
    let (tenants, texts, scopes) = columns(answered.iter().map(|(key, _)| key));
    let kept: Vec<&Kept> = answered.iter().filter_map(|(_, kept)| kept.as_ref()).collect();
    let place = |kept: &&Kept| kept.fit.as_ref().map(|(place, _)| *place);
    sqlx::query(
        "UPDATE idempotency_keys k SET request_sha256 = a.request_sha256, status = a.status, location = a.location,
                etag = a.etag, body = a.body, job = a.job, number = a.number, fit = a.fit, body_end = a.body_end,
                created_at = a.created_at
         FROM unnest($1::text[], $2::text[], $3::text[], $4::bytea[], $5::bigint[], $6::text[], $7::text[], $8::bytea[],
                     $9::uuid[], $10::bigint[], $11::bigint[], $12::bytea[], $13::timestamptz[])
              AS a (tenant, key, scope, request_sha256, status, location, etag, body, job, number, fit, body_end,
                    created_at)
         WHERE k.tenant = a.tenant AND k.key = a.key AND k.scope = a.scope",
    )
    .bind(tenants)
    .bind(texts)
    .bind(scopes)
    .bind(kept.iter().map(|kept| kept.request_sha256.as_slice()).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| i64::from(kept.answer.status)).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| kept.answer.location.as_deref()).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| kept.answer.etag.as_deref()).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| kept.answer.body.as_slice()).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| place(kept).map(|place| place.job)).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| place(kept).map(|place| place.number)).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| place(kept).map(|place| place.position)).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| kept.fit.as_ref().map(|(_, after)| after.as_slice())).collect::<Vec<_>>())
    .bind(kept.iter().map(|kept| stamp(kept.now)).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}
