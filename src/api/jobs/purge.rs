//! Purges as they are asked for and answered.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, de::Error};
use utoipa::ToSchema;
use uuid::Uuid;

use super::audit::hex;
use crate::{
    api::json::text::{LongText, Moment},
    jobs::NewPurge,
};

/// Reason and archive digest of the purge.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PurgeRequest, example = json!({
    "reason": "The operator asked for \
        it", "archive_sha256": "4355a46b19d348dc2f57c046f8ef63d4538ebb936000f3c9ee954a27460dd865"
}))]
pub struct PurgeRequestBody {
    /// Reason of the purge. It is stored and returned with later requests for the removed data: do
    /// not name persons here.
    #[schema(value_type = String, min_length = 1, max_length = 4000)]
    pub reason: LongText,
    /// `archive-sha256` of the archive that is kept: 64 hexadecimal digits. It must be that of the
    /// job as it is now.
    #[schema(value_type = String, min_length = 64, max_length = 64)]
    pub archive_sha256: ArchiveDigest,
}

/// SHA-256 of an archive, checked where it is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArchiveDigest(pub [u8; 32]);

impl<'de> Deserialize<'de> for ArchiveDigest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = Cow::<'_, str>::deserialize(deserializer)?;
        digest(&text).map(ArchiveDigest).ok_or_else(|| {
            D::Error::custom("expected SHA-256 in 64 hexadecimal digits: `archive-sha256` of the job's archive")
        })
    }
}

fn digest(text: &str) -> Option<[u8; 32]> {
    let digit = |digit: u8| char::from(digit).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    let bytes: Option<Vec<u8>> = pairs.iter().map(|[high, low]| Some(digit(*high)? << 4 | digit(*low)?)).collect();
    bytes.filter(|_| rest.is_empty())?.try_into().ok()
}

/// That a job was purged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Purge)]
pub struct PurgeBody {
    /// The job; its row, numbers and audit are kept.
    pub job_id: Uuid,
    /// When.
    #[schema(value_type = String, format = DateTime)]
    pub purged_at: Moment,
    /// Why, as it was posted.
    pub reason: String,
    /// SHA-256 of the archive with the removed data, in 64 lower-case hexadecimal digits.
    pub archive_sha256: String,
}

impl From<&NewPurge> for PurgeBody {
    fn from(NewPurge { job, purge, .. }: &NewPurge) -> Self {
        PurgeBody {
            job_id: *job,
            purged_at: Moment(purge.at),
            reason: purge.reason.clone(),
            archive_sha256: hex(&purge.archive_sha256),
        }
    }
}

/// SHA-256 as it stands in a header.
pub fn told(sha256: &[u8; 32]) -> String {
    hex(sha256)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::json::{error::ReadError, value::read_json};

    #[test]
    fn every_fault_is_told() {
        let Err(ReadError::Invalid(faults)) =
            read_json::<PurgeRequestBody>(br#"{"reason":"","archive_sha256":"0","why":"x"}"#)
        else {
            panic!("it is refused");
        };
        let mut pointers: Vec<&str> = faults.list().iter().map(|fault| fault.pointer.as_str()).collect();
        pointers.sort_unstable();
        assert_eq!(pointers, ["/archive_sha256", "/reason", "/why"]);
    }

    #[test]
    fn a_digest_is_64_hexadecimal_digits() {
        let all = "00fF".repeat(16);
        assert_eq!(digest(&all).map(|bytes| told(&bytes)), Some(all.to_lowercase()));
        for wrong in ["", "00", &"0".repeat(63), &"0".repeat(66), &"g".repeat(64), &"é".repeat(32)] {
            assert_eq!(digest(wrong), None, "{wrong}");
        }
    }
}
