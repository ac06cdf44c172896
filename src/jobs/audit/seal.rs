//! Seals: how far the chain of a tenant had come at some moment, signed.

use std::sync::Arc;

use jiff::Timestamp;

use super::{
    entry::Link,
    layout::{Fields, Sha256Digest},
    signing::{Signed, SigningKey},
};
use crate::jobs::callers::Tenant;

/// Beginning of the seals of a tenant.
const GENESIS: &str = "flankfit seals 2";

/// A seal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seal {
    pub tenant: Tenant,
    /// 1, 2, 3 … within the tenant.
    pub number: u64,
    pub at: Timestamp,
    /// The last entry of the chain.
    pub last: Link,
    /// Digest of the seal before it.
    pub previous: Sha256Digest,
    pub sha256: Sha256Digest,
    pub signed: Option<Signed>,
}

impl Seal {
    /// Returns what the first seal has as the digest of the one before it.
    pub fn genesis(tenant: &Tenant) -> Sha256Digest {
        Fields::default().text(GENESIS).text(tenant.as_str()).digest()
    }

    /// Makes the next seal of a tenant.
    pub fn next(tenant: &Tenant, before: Option<&Seal>, last: Link, at: Timestamp, key: Option<&SigningKey>) -> Self {
        let mut seal = Seal {
            tenant: tenant.clone(),
            number: before.map_or(0, |seal| seal.number) + 1,
            at,
            last,
            previous: before.map_or_else(|| Seal::genesis(tenant), |seal| seal.sha256),
            sha256: [0; 32],
            signed: None,
        };
        seal.sha256 = seal.digest();
        seal.signed = key.map(|key| key.sign(&seal.sha256));
        seal
    }

    /// Returns the digest of everything but the signature, which is of it.
    pub fn digest(&self) -> Sha256Digest {
        Fields::default()
            .bytes(&self.previous)
            .text(self.tenant.as_str())
            .number(self.number)
            .time(self.at)
            .number(self.last.number)
            .bytes(&self.last.sha256)
            .digest()
    }

    /// Returns whether digest and signature are as they were made, by this key if there is one.
    pub fn is_sound(&self, key: Option<[u8; 32]>) -> bool {
        let signed = self.signed.is_none_or(|signed| signed.is_of(&self.sha256));
        let by_key = key.is_none_or(|key| self.signed.is_some_and(|signed| signed.public_key == key));
        self.sha256 == self.digest() && signed && by_key
    }
}

/// Result of a turn of the sealer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sealed {
    pub seals: Vec<Seal>,
    /// True if further entries wait.
    pub more: bool,
    /// Entries that could not be sealed, each with the reason.
    pub failed: Vec<String>,
}

/// How seals are made.
#[derive(Clone)]
pub struct Sealing {
    pub at: Timestamp,
    /// Signs the seals; without it they are not signed.
    pub key: Option<Arc<SigningKey>>,
}
