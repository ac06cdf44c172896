//! Entries and seals of the audit.

use std::collections::BTreeMap;

use jiff::{Timestamp, ToSpan as _};

use crate::jobs::{
    Tenant,
    audit::{Entry, Head, Seal, SealedHead, Sealing, Signed},
};

/// The columns of an [`Entry`].
macro_rules! entry_columns {
    () => {
        "number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256"
    };
}
pub(in crate::store::sql) use entry_columns;

/// The columns of a [`SealRow`].
macro_rules! seal_columns {
    () => {
        "tenant, number, at, heads, root, previous, sha256, signature, public_key"
    };
}
pub(in crate::store::sql) use seal_columns;

from_row! {
    Entry { number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256 }
    Head { number, sha256 }
    SealedHead { chain, number, sha256 }
}

row! {
    pub struct SealRow {
        tenant: Tenant,
        number: u64,
        at: Timestamp,
        heads: u64,
        root: [u8; 32],
        previous: [u8; 32],
        sha256: [u8; 32],
        signature: Option<Vec<u8>>,
        public_key: Option<Vec<u8>>,
    }
}

/// Returns the bytes of a column; zeros where there are not as many.
fn exactly<const N: usize>(bytes: Option<Vec<u8>>) -> [u8; N] {
    bytes.and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
}

impl From<SealRow> for Seal {
    fn from(row: SealRow) -> Self {
        let SealRow { tenant, number, at, heads, root, previous, sha256, signature, public_key } = row;
        let is_signed = signature.is_some() || public_key.is_some();
        let signed = Signed { public_key: exactly(public_key), signature: exactly(signature) };
        Seal { tenant, number, at, heads, root, previous, sha256, signed: is_signed.then_some(signed) }
    }
}

row! {
    /// The last entry of a chain that grew.
    pub struct GrownRow {
        @head: SealedHead,
        tenant: Tenant,
    }
}

/// Returns chains that grew, by their tenants.
pub fn grown(rows: Vec<GrownRow>) -> BTreeMap<Tenant, Vec<SealedHead>> {
    let mut grown: BTreeMap<Tenant, Vec<SealedHead>> = BTreeMap::new();
    for GrownRow { tenant, head } in rows {
        grown.entry(tenant).or_default().push(head);
    }
    grown
}

row! {
    /// The seal of any tenant that was made last.
    pub struct NewestSealRow {
        at: Timestamp,
        /// How far the audit was looked at for it.
        pub upto: i64,
    }
}

impl NewestSealRow {
    /// Returns whether it is enough.
    pub fn suffices(&self, sealing: &Sealing) -> bool {
        self.at > sealing.unless_since
    }

    /// Returns the time of the next seals, which are younger whatever the clock says.
    pub fn behind(&self, at: Timestamp) -> Timestamp {
        at.max(self.at.checked_add(1.microsecond()).unwrap_or(Timestamp::MAX))
    }
}
