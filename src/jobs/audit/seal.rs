//! Seals: what the chains of a tenant ended with at some moment.

use std::{collections::BTreeMap, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    layout::{Fields, Sha256Digest},
    merkle,
    signing::{Signed, SigningKey},
};
use crate::jobs::callers::Tenant;

/// What the seals of a tenant begin with.
const GENESIS: &str = "flankfit seals 1";

/// The last entry of a chain when it was sealed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SealedHead {
    /// The key of the chain.
    pub chain: Uuid,
    pub number: u64,
    pub sha256: Sha256Digest,
}

impl SealedHead {
    /// The digest of its leaf: 16 bytes of the chain's id, 8 of the number, 32 of the digest.
    fn leaf(&self) -> Sha256Digest {
        let mut data = [0; 56];
        data[..16].copy_from_slice(self.chain.as_bytes());
        data[16..24].copy_from_slice(&self.number.to_be_bytes());
        data[24..].copy_from_slice(&self.sha256);
        merkle::leaf(&data)
    }
}

/// The root of heads, which are in the order of their chains.
pub fn root_of(heads: &[SealedHead]) -> Sha256Digest {
    merkle::root(&heads.iter().map(SealedHead::leaf).collect::<Vec<_>>())
}

/// A seal without its heads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seal {
    pub tenant: Tenant,
    /// 1, 2, 3 … within the tenant.
    pub number: u64,
    pub at: Timestamp,
    /// Chains that grew since the seal before it.
    pub heads: u64,
    /// Root of the Merkle tree of these.
    pub root: Sha256Digest,
    /// Digest of the seal before it.
    pub previous: Sha256Digest,
    pub sha256: Sha256Digest,
    pub signed: Option<Signed>,
}

impl Seal {
    /// What stands where the first seal has the digest of the one before it.
    pub fn genesis(tenant: &Tenant) -> Sha256Digest {
        Fields::default().text(GENESIS).text(tenant.as_str()).digest()
    }

    /// The digest of everything but the signature, which is of it.
    pub fn digest(&self) -> Sha256Digest {
        Fields::default()
            .bytes(&self.previous)
            .text(self.tenant.as_str())
            .number(self.number)
            .time(self.at)
            .number(self.heads)
            .bytes(&self.root)
            .digest()
    }

    /// Whether digest and signature are as they were made.
    pub fn is_sound(&self) -> bool {
        self.sha256 == self.digest() && self.signed.is_none_or(|signed| signed.is_of(&self.sha256))
    }
}

/// A seal with its heads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WholeSeal {
    pub seal: Seal,
    /// In the order of their chains.
    pub heads: Vec<SealedHead>,
}

impl WholeSeal {
    /// The next seal of a tenant, behind the one of that number and digest.
    pub fn next(
        tenant: Tenant,
        last: Option<(u64, Sha256Digest)>,
        mut heads: Vec<SealedHead>,
        at: Timestamp,
        key: Option<&SigningKey>,
    ) -> Self {
        heads.sort_unstable();
        let (number, previous) = last.unwrap_or_else(|| (0, Seal::genesis(&tenant)));
        let mut seal = Seal {
            tenant,
            number: number + 1,
            at,
            heads: heads.len() as u64,
            root: root_of(&heads),
            previous,
            sha256: [0; 32],
            signed: None,
        };
        seal.sha256 = seal.digest();
        seal.signed = key.map(|key| key.sign(&seal.sha256));
        WholeSeal { seal, heads }
    }

    /// Whether the heads are those that it was made of, in their order.
    pub fn has_its_heads(&self) -> bool {
        self.seal.heads == self.heads.len() as u64
            && self.heads.is_sorted_by(|one, next| one.chain < next.chain)
            && self.seal.root == root_of(&self.heads)
    }

    /// Whether all of it is as it was made.
    pub fn is_sound(&self) -> bool {
        self.has_its_heads() && self.seal.is_sound()
    }
}

/// What is to be sealed, and how.
#[derive(Clone)]
pub struct Sealing {
    pub at: Timestamp,
    /// Signs the seals; without it they are not signed.
    pub key: Option<Arc<SigningKey>>,
    /// A seal that was made since then, by whichever process, is enough.
    pub unless_since: Timestamp,
}

/// What of the audit is in no seal yet, by numbers of a store that ascend as it stores entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unsealed {
    /// Entries that are stored from now on have this number at least.
    pub next: i64,
    /// The number of the oldest entry that no seal holds.
    pub oldest: Option<i64>,
}

/// The next seals of tenants whose chains grew: the last seal of each, and the new heads.
pub fn seals(
    last: &BTreeMap<Tenant, (u64, Sha256Digest)>,
    grown: BTreeMap<Tenant, Vec<SealedHead>>,
    sealing: &Sealing,
) -> Vec<WholeSeal> {
    let next = |(tenant, heads): (Tenant, Vec<SealedHead>)| {
        let last = last.get(&tenant).copied();
        WholeSeal::next(tenant, last, heads, sealing.at, sealing.key.as_deref())
    };
    grown.into_iter().map(next).collect()
}
