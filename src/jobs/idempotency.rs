//! Idempotency keys: a client that lost an answer may ask again without storing twice.
//!
//! An answer is kept under (tenant, key, scope) in the same transaction as its subject, with a
//! digest of its request; so the key works across restarts and never vouches for something that was
//! not stored. Which keys are being worked on right now is kept in memory only: after a crash
//! nothing is being worked on.

use std::{
    collections::HashSet,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use jiff::SignedDuration;

use super::{callers::Tenant, outcome::Stored};

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

impl Answer {
    pub fn ok(body: Vec<u8>) -> Self {
        Answer { status: 200, location: None, etag: None, body }
    }

    /// The response about a new thing at an address, with the tag of its version.
    pub fn created(location: String, etag: String, body: Vec<u8>) -> Self {
        Answer { status: 201, location: Some(location), etag: Some(etag), body }
    }
}

/// A request that came with a key.
#[derive(Clone, Debug)]
pub struct KeyedRequest {
    pub key: String,
    /// Method and path.
    pub scope: String,
    pub request_sha256: [u8; 32],
    /// Given back when the write has ended, one way or the other: until then the key is being
    /// worked on, also when the client has left meanwhile.
    pub claim: Option<Arc<KeyClaim>>,
}

impl KeyedRequest {
    /// Keeps, under the key, the response that `answer` writes.
    pub fn answered_by<T>(self, answer: impl Fn(&T, Stored) -> Answer + Send + Sync + 'static) -> Keyed<T> {
        Keyed { request: self, answer: Box::new(answer) }
    }
}

/// Receipt of a keyed request.
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
    keys: Arc<Mutex<HashSet<Entry>>>,
}

/// A key taken; given back when dropped.
#[derive(Debug)]
pub struct KeyClaim {
    running: RunningKeys,
    entry: Entry,
}

impl RunningKeys {
    fn lock(&self) -> MutexGuard<'_, HashSet<Entry>> {
        self.keys.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a key; `None` while its first request is still running.
    pub fn claim(&self, tenant: &Tenant, key: &str, scope: &str) -> Option<KeyClaim> {
        let entry = (tenant.clone(), key.to_owned(), scope.to_owned());
        self.lock().insert(entry.clone()).then(|| KeyClaim { running: self.clone(), entry })
    }
}

impl Drop for KeyClaim {
    fn drop(&mut self) {
        self.running.lock().remove(&self.entry);
    }
}
