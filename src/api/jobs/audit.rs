//! The audit in responses.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::jobs::{
    audit::{Difference, Entry, Kind, Link, ListedEntry, Seal, Verdict, time_text},
    rows::to_hex,
};

/// Greatest number of changes that a response lists.
const MOST_DIFFERENCES: usize = 100;

/// A change: its time, the caller, and digests of the stored rows. SHA-256 digests have 64
/// lower-case hexadecimal digits.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditEntry)]
pub struct EntryBody {
    /// UUIDv7.
    pub id: Uuid,
    /// The job that was changed; absent for a change of a key or of the tenant.
    pub job_id: Option<Uuid>,
    /// Time of the request, always with six decimals.
    #[schema(value_type = String, format = DateTime)]
    pub at: String,
    /// Name of the caller's key, or `anonymous`. Absent after a purge of the job.
    pub actor: Option<String>,
    /// Kind of change, such as `iteration.add`.
    pub action: String,
    /// Path of the changed resource.
    pub subject: String,
    /// `x-request-id` of the request.
    pub request_id: Option<String>,
    /// The address that the request came from.
    pub peer: Option<String>,
    /// SHA-256 of the salt and each stored row, by the name of the row, such as `decisions/3/1`.
    pub contents: BTreeMap<String, String>,
    /// Random bytes that these digests begin with. Absent after a purge of the job.
    pub salt: Option<String>,
    /// SHA-256 of salt and actor.
    pub who: String,
    /// Place in the chain of the tenant: 1, 2, 3 … without gaps. Absent before it is sealed.
    #[schema(minimum = 1)]
    pub number: Option<u64>,
    /// SHA-256 of this digest of the previous entry, the number and the entry. Absent before it is
    /// sealed.
    pub sha256: Option<String>,
}

/// The end of a tenant's chain at some time. Digits are lower-case hexadecimal.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditSeal)]
pub struct SealBody {
    /// The tenant of the chain.
    pub tenant: String,
    /// 1, 2, 3 … within the tenant, without gaps.
    #[schema(minimum = 1)]
    pub number: u64,
    /// Time when it was made, always with six decimals.
    #[schema(value_type = String, format = DateTime)]
    pub at: String,
    /// `number` of the last entry of the chain.
    #[schema(minimum = 1)]
    pub last_entry: u64,
    /// `sha256` of this entry.
    pub last_sha256: String,
    /// `sha256` of the seal before it; of the first, a digest of the tenant.
    pub previous: String,
    /// SHA-256 of all fields above.
    pub sha256: String,
    /// Ed25519 signature of the 32 bytes of `sha256`. Absent if the server has no signing key.
    pub signature: Option<String>,
    /// Public key that verifies the signature.
    pub public_key: Option<String>,
}

/// Something that differs from what was written.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditDifference)]
pub struct DifferenceBody {
    /// The job, if there is one.
    pub job_id: Option<Uuid>,
    /// The name of the row, such as `decisions/3/1`; `entry` or `seal` and its number in the chain.
    pub place: String,
    /// Kind of the difference.
    pub kind: Kind,
}

/// Result of a verification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditVerdict)]
pub struct VerdictBody {
    /// True if nothing was changed.
    pub intact: bool,
    /// Number of entries.
    pub entries: u64,
    /// Number of these that are not sealed yet: they are verified against their rows only.
    pub unsealed: u64,
    /// Differences, at most 100.
    pub differences: Vec<DifferenceBody>,
}

impl From<ListedEntry> for EntryBody {
    fn from(ListedEntry { entry, place }: ListedEntry) -> Self {
        let Entry { id, job, at, actor, action, subject, request_id, peer, contents, salt, who, .. } = entry;
        let text = |text: std::sync::Arc<str>| text.to_string();
        EntryBody {
            id,
            job_id: job,
            at: time_text(at),
            actor: actor.map(text),
            action: action.into_owned(),
            subject,
            request_id: request_id.map(text),
            peer: peer.map(text),
            contents: contents.iter().map(|(name, digest)| (name.to_owned(), to_hex(digest))).collect(),
            salt: salt.as_deref().map(to_hex),
            who: to_hex(&who),
            number: place.map(|Link { number, .. }| number),
            sha256: place.map(|Link { sha256, .. }| to_hex(&sha256)),
        }
    }
}

impl From<&Seal> for SealBody {
    fn from(seal: &Seal) -> Self {
        SealBody {
            tenant: seal.tenant.as_str().to_owned(),
            number: seal.number,
            at: time_text(seal.at),
            last_entry: seal.last.number,
            last_sha256: to_hex(&seal.last.sha256),
            previous: to_hex(&seal.previous),
            sha256: to_hex(&seal.sha256),
            signature: seal.signed.map(|signed| to_hex(&signed.signature)),
            public_key: seal.signed.map(|signed| to_hex(&signed.public_key)),
        }
    }
}

impl From<Seal> for SealBody {
    fn from(seal: Seal) -> Self {
        SealBody::from(&seal)
    }
}

impl From<Verdict> for VerdictBody {
    fn from(Verdict { entries, unsealed, differences, .. }: Verdict) -> Self {
        let difference = |Difference { job, place, kind, .. }| DifferenceBody { job_id: job, place, kind };
        VerdictBody {
            intact: differences.is_empty(),
            entries,
            unsealed,
            differences: differences.into_iter().take(MOST_DIFFERENCES).map(difference).collect(),
        }
    }
}
