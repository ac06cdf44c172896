//! Idempotency keys: a client that lost an answer may ask again without storing twice.
//!
//! An answer is kept under (tenant, key, scope) in the same transaction as what it tells of, with a
//! digest of its request; so the key works across restarts and never vouches for something that was
//! not stored. Which keys are being worked on right now is kept in memory only: after a crash
//! nothing is being worked on.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use jiff::SignedDuration;

use super::{callers::Tenant, outcome::Stored, tasks::Lease};

/// How long an answer is kept.
pub const ANSWERS_KEPT: SignedDuration = SignedDuration::from_hours(30 * 24);

/// An answer as it is given again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    pub status: u16,
    pub location: Option<String>,
    pub etag: Option<String>,
    pub body: Vec<u8>,
}

/// A request that came with a key.
#[derive(Clone, Debug)]
pub struct KeyedRequest {
    pub key: String,
    /// Method and path.
    pub scope: String,
    pub request_sha256: [u8; 32],
    /// The task that asks for it, if it is one: the write is refused when another does the task by
    /// now, and ends it.
    pub lease: Option<Lease>,
    /// Given back when the write has ended, one way or the other: until then the key is being
    /// worked on, also when the client has left meanwhile.
    pub claim: Option<Arc<KeyClaim>>,
}

impl KeyedRequest {
    /// What is kept under the key: the answer that `answer` writes.
    pub fn answered_by<T>(self, answer: impl Fn(&T, Stored) -> Answer + Send + Sync + 'static) -> Keyed<T> {
        Keyed { request: self, answer: Box::new(answer) }
    }
}

/// What is kept of a keyed request.
pub struct Receipt {
    pub request: KeyedRequest,
    /// Writes the answer, once the store knows what only it can know. Runs inside the transaction,
    /// perhaps twice (a transaction may have to be repeated): pure and quick.
    pub answer: Box<dyn Fn(Stored) -> Answer + Send + Sync>,
}

impl std::fmt::Debug for Receipt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Receipt").field("request", &self.request).finish_non_exhaustive()
    }
}

/// Writes the answer to what was stored.
pub type AnswerWriter<T> = Box<dyn Fn(&T, Stored) -> Answer + Send + Sync>;

/// A keyed request, before what it stores has ids: the receipt's answer is written from `T`.
pub struct Keyed<T> {
    pub request: KeyedRequest,
    pub answer: AnswerWriter<T>,
}

impl<T: Send + Sync + 'static> Keyed<T> {
    pub(super) fn receipt(self, of: Arc<T>) -> Receipt {
        let Keyed { request, answer } = self;
        Receipt { request, answer: Box::new(move |stored| answer(&of, stored)) }
    }
}

type Entry = (Tenant, String, String);

/// The keys being worked on.
#[derive(Clone, Debug, Default)]
pub struct RunningKeys {
    keys: Arc<Mutex<Claims>>,
}

#[derive(Debug, Default)]
struct Claims {
    held: HashMap<Entry, Claim>,
    /// Number of the claims so far.
    count: u64,
}

/// Who has a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Claim {
    number: u64,
    lease: Option<Lease>,
}

/// A key taken; given back when dropped.
#[derive(Debug)]
pub struct KeyClaim {
    running: RunningKeys,
    entry: Entry,
    number: u64,
}

/// A key that somebody else has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyHeld {
    /// The lease under which it is worked for, if it is a task that has it: once that does not hold
    /// any more, nothing can come of that work.
    pub lease: Option<Lease>,
}

impl RunningKeys {
    fn lock(&self) -> MutexGuard<'_, Claims> {
        self.keys.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a key, for a task if it is one that works, unless its first request is still running.
    pub fn claim(&self, tenant: &Tenant, key: &str, scope: &str, lease: Option<Lease>) -> Result<KeyClaim, KeyHeld> {
        self.take(tenant, key, scope, lease, None)
    }

    /// Takes a key from the task that has it under a lease which does not hold any more.
    pub fn take_over(
        &self,
        tenant: &Tenant,
        key: &str,
        scope: &str,
        lease: Option<Lease>,
        from: Lease,
    ) -> Result<KeyClaim, KeyHeld> {
        self.take(tenant, key, scope, lease, Some(from))
    }

    fn take(
        &self,
        tenant: &Tenant,
        key: &str,
        scope: &str,
        lease: Option<Lease>,
        from: Option<Lease>,
    ) -> Result<KeyClaim, KeyHeld> {
        let entry = (tenant.clone(), key.to_owned(), scope.to_owned());
        let mut claims = self.lock();
        match claims.held.get(&entry) {
            Some(held) if held.lease.is_none() || held.lease != from => return Err(KeyHeld { lease: held.lease }),
            _ => {}
        }
        claims.count += 1;
        let number = claims.count;
        claims.held.insert(entry.clone(), Claim { number, lease });
        Ok(KeyClaim { running: self.clone(), entry, number })
    }
}

impl Drop for KeyClaim {
    fn drop(&mut self) {
        let mut claims = self.running.lock();
        // unless another has taken it over
        if claims.held.get(&self.entry).is_some_and(|held| held.number == self.number) {
            claims.held.remove(&self.entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use uuid::Uuid;

    use super::*;

    #[test]
    fn a_key_is_taken_once_by_each_tenant_and_given_back() {
        let running = RunningKeys::default();
        let (own, other) = (Tenant::default(), Tenant::named("other").unwrap());
        let claim = running.claim(&own, "k", "POST /v1/jobs", None);
        assert!(claim.is_ok());
        assert_eq!(running.claim(&own, "k", "POST /v1/jobs", None).err(), Some(KeyHeld { lease: None }));
        assert!(running.claim(&own, "k", "POST /v1/other", None).is_ok());
        assert!(running.claim(&other, "k", "POST /v1/jobs", None).is_ok());
        drop(claim);
        assert!(running.claim(&own, "k", "POST /v1/jobs", None).is_ok());
    }

    #[test]
    fn a_task_loses_its_key_with_its_lease() {
        let (running, own) = (RunningKeys::default(), Tenant::default());
        let lease = |id| Lease { task: Uuid::from_u128(1), id: Uuid::from_u128(id) };
        let first = running.claim(&own, "k", "s", Some(lease(1))).unwrap();
        assert_eq!(running.claim(&own, "k", "s", None).err(), Some(KeyHeld { lease: Some(lease(1)) }));
        assert!(running.take_over(&own, "k", "s", None, lease(2)).is_err(), "another lease");
        let second = running.take_over(&own, "k", "s", None, lease(1)).unwrap();
        // what the first gives back is not the second's
        drop(first);
        assert_eq!(running.claim(&own, "k", "s", None).err(), Some(KeyHeld { lease: None }));
        assert!(running.take_over(&own, "k", "s", None, lease(1)).is_err(), "who has no lease keeps it");
        drop(second);
        assert!(running.claim(&own, "k", "s", None).is_ok());
    }
}
