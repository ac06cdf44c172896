//! Seals of the audit.

use std::collections::BTreeMap;

use jiff::{Timestamp, ToSpan as _};
use uuid::Uuid;

use crate::{
    jobs::{
        Cursor, Page, Tenant,
        audit::{Seal, SealedHead, Sealing, Sha256Digest, Signed},
    },
    store::sql::columns::{Digest, Integer, Moment},
};

/// The columns of [`SealRow`].
macro_rules! seal_columns {
    () => {
        "tenant, number, at, heads, root, previous, sha256, signature, public_key"
    };
}
pub(in crate::store) use seal_columns;

row! {
    pub struct SealRow {
        tenant: Tenant,
        number: Integer<u64>,
        at: Moment,
        heads: Integer<u64>,
        root: Digest,
        previous: Digest,
        sha256: Digest,
        signature: Option<Vec<u8>>,
        public_key: Option<Vec<u8>>,
    }
}

/// The bytes of a column; zeros where it has not got as many.
fn exactly<const N: usize>(bytes: Option<Vec<u8>>) -> [u8; N] {
    bytes.and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
}

impl From<SealRow> for Seal {
    fn from(row: SealRow) -> Self {
        let is_signed = row.signature.is_some() || row.public_key.is_some();
        let signed = Signed { public_key: exactly(row.public_key), signature: exactly(row.signature) };
        Seal {
            tenant: row.tenant,
            number: row.number.0,
            at: row.at.0,
            heads: row.heads.0,
            root: row.root.0,
            previous: row.previous.0,
            sha256: row.sha256.0,
            signed: is_signed.then_some(signed),
        }
    }
}

/// A page of so many seals. One row more than that tells whether there is a next page.
pub fn page_of_seals(rows: Vec<SealRow>, limit: u32) -> Page<Seal> {
    Page::of(rows.into_iter().map(Seal::from).collect(), limit, |seal| Cursor::after_number(seal.number))
}

row! {
    pub struct SealedHeadRow {
        chain: Uuid,
        number: Integer<u64>,
        sha256: Digest,
    }
}

impl From<SealedHeadRow> for SealedHead {
    fn from(SealedHeadRow { chain, number, sha256 }: SealedHeadRow) -> Self {
        SealedHead { chain, number: number.0, sha256: sha256.0 }
    }
}

row! {
    /// The last entry of a chain that grew.
    pub struct GrownRow {
        @head: SealedHeadRow,
        tenant: Tenant,
    }
}

/// Chains that grew, by their tenants.
pub fn grown(rows: Vec<GrownRow>) -> BTreeMap<Tenant, Vec<SealedHead>> {
    let mut grown: BTreeMap<Tenant, Vec<SealedHead>> = BTreeMap::new();
    for GrownRow { tenant, head } in rows {
        grown.entry(tenant).or_default().push(head.into());
    }
    grown
}

row! {
    /// The last seal of a tenant.
    pub struct LastSealRow {
        number: Integer<u64>,
        sha256: Digest,
    }
}

impl From<LastSealRow> for (u64, Sha256Digest) {
    fn from(row: LastSealRow) -> Self {
        (row.number.0, row.sha256.0)
    }
}

row! {
    /// The seal of any tenant that was made last.
    pub struct NewestSealRow {
        at: Moment,
        /// How far the audit was looked at for it.
        pub upto: i64,
    }
}

impl NewestSealRow {
    /// Whether it is enough.
    pub fn suffices(&self, sealing: &Sealing) -> bool {
        self.at.0 > sealing.unless_since
    }

    /// The time of those behind it, which are younger whatever clock gives it.
    pub fn behind(&self, at: Timestamp) -> Timestamp {
        let next = self.at.0.checked_add(1.microsecond()).unwrap_or(Timestamp::MAX);
        at.max(next)
    }
}
