//! Entries and seals of the audit, and purges.

use jiff::Timestamp;
use sqlx::{FromRow, postgres::PgRow, sqlite::SqliteRow};

use crate::jobs::{
    RepositoryError,
    audit::{Entry, Link, ListedEntry, Seal, Signed},
};
use crate::store::sql::error::damaged;

/// The columns of an [`Entry`].
macro_rules! entry_columns {
    () => {
        "a.id, a.tenant, a.job, a.at, a.actor, a.action, a.subject, a.request_id, a.peer, a.contents, a.salt, a.who"
    };
}
pub(in crate::store::sql) use entry_columns;

/// The columns of a [`Seal`].
macro_rules! seal_columns {
    () => {
        "tenant, number, at, last_entry, last_sha256, previous, sha256, signature, public_key"
    };
}
pub(in crate::store::sql) use seal_columns;

from_row! {
    Entry { id, tenant, job, at, actor, action, subject, request_id, peer, contents, salt, who }
    Link { number, sha256 }
}

row! {
    struct Place {
        number: Option<u64>,
        sha256: Option<[u8; 32]>,
    }
}

row! {
    struct SealRow {
        tenant: crate::jobs::Tenant,
        number: u64,
        at: Timestamp,
        last_entry: u64,
        last_sha256: [u8; 32],
        previous: [u8; 32],
        sha256: [u8; 32],
        signature: Option<Vec<u8>>,
        public_key: Option<Vec<u8>>,
    }
}

/// Returns the bytes of a column; bytes that are no part of a valid signature where there are not
/// as many. (Zeros would be: a key of zeros has a small order, and some signatures by it hold.)
fn exactly<const N: usize>(bytes: Option<Vec<u8>>) -> [u8; N] {
    bytes.and_then(|bytes| bytes.try_into().ok()).unwrap_or([0xff; N])
}

impl From<SealRow> for Seal {
    fn from(row: SealRow) -> Self {
        let is_signed = row.signature.is_some() || row.public_key.is_some();
        let signed = Signed { public_key: exactly(row.public_key), signature: exactly(row.signature) };
        Seal {
            tenant: row.tenant,
            number: row.number,
            at: row.at,
            last: Link { number: row.last_entry, sha256: row.last_sha256 },
            previous: row.previous,
            sha256: row.sha256,
            signed: is_signed.then_some(signed),
        }
    }
}

macro_rules! of_parts {
    ($($Row:ty),*) => {
        $(impl<'r> FromRow<'r, $Row> for Seal {
            fn from_row(row: &'r $Row) -> Result<Self, sqlx::Error> {
                SealRow::from_row(row).map(Seal::from)
            }
        }

        impl<'r> FromRow<'r, $Row> for ListedEntry {
            fn from_row(row: &'r $Row) -> Result<Self, sqlx::Error> {
                let Place { number, sha256 } = Place::from_row(row)?;
                let place = number.zip(sha256).map(|(number, sha256)| Link { number, sha256 });
                Ok(ListedEntry { entry: Entry::from_row(row)?, place })
            }
        })*
    };
}

of_parts!(SqliteRow, PgRow);

row! {
    /// The purge of a job, where a write looks the job up.
    pub struct JobPurge {
        purged_at: Option<Timestamp>,
        purge_reason: Option<String>,
    }
}

impl JobPurge {
    /// A purged job takes nothing more.
    pub fn refuse(&self) -> Result<(), RepositoryError> {
        match self.purged_at {
            None => Ok(()),
            Some(at) => Err(RepositoryError::Purged { at, reason: self.purge_reason.clone().unwrap_or_default() }),
        }
    }

    /// Returns the refusal of something that was removed. Where there is no purge, it was lost
    /// otherwise.
    pub fn refusal(purge: Option<Self>) -> RepositoryError {
        purge
            .and_then(|purge| purge.refuse().err())
            .unwrap_or_else(|| RepositoryError::Failed(damaged("a row of a job", "empty, but the job was not purged")))
    }
}
