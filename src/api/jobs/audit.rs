//! The audit in answers.

use std::{collections::BTreeMap, fmt::Write as _};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::jobs::{
    List, Page,
    audit::{Entry, Seal, Verdict, What, time_text},
};

/// A change: its time, the caller, and digests of the stored rows. SHA-256 digests have 64
/// lower-case hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditEntry)]
pub struct EntryBody {
    /// 1, 2, 3 … within the chain, without gaps.
    #[schema(minimum = 1)]
    pub number: u64,
    /// UUIDv7; of an entry with which an older job begins, UUIDv8.
    pub id: Uuid,
    /// Time of the request, always with six decimals.
    #[schema(value_type = String, format = DateTime)]
    pub at: String,
    /// Name of the caller's key, or `anonymous`. Absent after a purge of the job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<String>,
    /// Kind of change, such as `iteration.add`.
    pub action: String,
    /// Path of the changed resource.
    pub target: String,
    /// `x-request-id` of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// The address that the request came from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peer: Option<String>,
    /// SHA-256 of each stored row, by kind of row; rows of iterations are digested with the
    /// `_salt`.
    pub contents: BTreeMap<String, String>,
    /// `stored`, `changed`, `deleted`, `purged`, or `found` where nothing was changed.
    pub outcome: String,
    /// `sha256` of the entry before it; of the first, a digest of the tenant and the job.
    pub previous: String,
    /// SHA-256 of the rest.
    pub sha256: String,
}

/// Some entries of a chain, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditPage)]
pub struct AuditPageBody {
    /// The entries of this page.
    pub items: Vec<EntryBody>,
    /// Cursor of the next page; absent on the last one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// Last entries of a tenant's chains that have grown since the seal before. Digits are lower-case
/// hexadecimal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditSeal)]
pub struct SealBody {
    /// The tenant of the chains.
    pub tenant: String,
    /// 1, 2, 3 … within the tenant, without gaps.
    #[schema(minimum = 1)]
    pub number: u64,
    /// When it was made, always with six decimals.
    #[schema(value_type = String, format = DateTime)]
    pub at: String,
    /// Number of chains that have grown.
    #[schema(minimum = 1)]
    pub heads: u64,
    /// Root of the Merkle tree (RFC 6962) of their last entries.
    pub root: String,
    /// `sha256` of the seal before it; of the first, a digest of the tenant.
    pub previous: String,
    /// SHA-256 of all before.
    pub sha256: String,
    /// Ed25519 signature of the 32 bytes of `sha256`. Absent where the server has no key for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signature: Option<String>,
    /// The key that the signature is checked by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub public_key: Option<String>,
}

/// Some seals, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditSealPage)]
pub struct SealPageBody {
    /// The seals of this page.
    pub items: Vec<SealBody>,
    /// Cursor of the next page; absent on the last one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// Kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = AuditFault)]
pub enum WhatName {
    /// The entry itself, or it is missing.
    Entry,
    /// Its link to the one before it.
    Link,
    /// A row that it has a digest of; or, one behind the last entry, a row that no entry tells of.
    Content,
    /// A seal has another digest of it.
    Seal,
}

/// Result of verifying a chain and the rows it has digests of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditVerdict)]
pub struct VerdictBody {
    /// True if nothing was changed.
    pub intact: bool,
    /// If intact: number of entries in the chain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entries: Option<u64>,
    /// If intact: `sha256` of the last entry. Absent for a job that is older than the audit and has
    /// not been changed since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head: Option<String>,
    /// If not intact: number of the first entry at fault.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1)]
    pub number: Option<u64>,
    /// If not intact: kind of fault.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub what: Option<WhatName>,
}

/// Bytes in hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

impl From<Entry> for EntryBody {
    fn from(entry: Entry) -> Self {
        EntryBody {
            number: entry.number,
            id: entry.id,
            at: time_text(entry.at),
            actor: (!entry.is_nameless()).then(|| entry.actor.to_string()),
            action: entry.action.to_string(),
            target: entry.target,
            request_id: entry.request_id.map(|id| id.to_string()),
            peer: entry.peer.map(|peer| peer.to_string()),
            contents: entry.contents.iter().map(|(name, digest)| (name.to_owned(), hex(digest))).collect(),
            outcome: entry.outcome.to_string(),
            previous: hex(&entry.previous),
            sha256: hex(&entry.sha256),
        }
    }
}

impl From<Page<Entry>> for AuditPageBody {
    fn from(page: Page<Entry>) -> Self {
        AuditPageBody {
            items: page.items.into_iter().map(Into::into).collect(),
            next_cursor: page.next.map(|next| next.encode(List::Audit)),
        }
    }
}

impl From<&Seal> for SealBody {
    fn from(seal: &Seal) -> Self {
        SealBody {
            tenant: seal.tenant.as_str().to_owned(),
            number: seal.number,
            at: time_text(seal.at),
            heads: seal.heads,
            root: hex(&seal.root),
            previous: hex(&seal.previous),
            sha256: hex(&seal.sha256),
            signature: seal.signed.map(|signed| hex(&signed.signature)),
            public_key: seal.signed.map(|signed| hex(&signed.public_key)),
        }
    }
}

impl From<Page<Seal>> for SealPageBody {
    fn from(page: Page<Seal>) -> Self {
        SealPageBody {
            items: page.items.iter().map(Into::into).collect(),
            next_cursor: page.next.map(|next| next.encode(List::Seals)),
        }
    }
}

impl From<What> for WhatName {
    fn from(what: What) -> Self {
        match what {
            What::Entry => WhatName::Entry,
            What::Link => WhatName::Link,
            What::Content => WhatName::Content,
            What::Seal => WhatName::Seal,
        }
    }
}

impl From<Verdict> for VerdictBody {
    fn from(verdict: Verdict) -> Self {
        let none = VerdictBody { intact: false, entries: None, head: None, number: None, what: None };
        match verdict {
            Verdict::Intact { entries, head } => {
                VerdictBody { intact: true, entries: Some(entries), head: head.map(|head| hex(&head)), ..none }
            }
            Verdict::Broken { number, what } => VerdictBody { number: Some(number), what: Some(what.into()), ..none },
        }
    }
}
