//! Keys and tenants.

use crate::jobs::{ApiKey, KnownKey, NewKey, Plant};

/// The columns of an [`ApiKey`].
macro_rules! key_columns {
    () => {
        "k.id AS id, k.tenant AS tenant, k.name AS name, k.role AS role, k.scopes AS scopes, k.san AS san, \
         k.version AS version, k.created_at AS created_at, k.expires_at AS expires_at, \
         k.last_used_at AS last_used_at, k.revoked_at AS revoked_at, k.replaced_by AS replaced_by"
    };
}
pub(in crate::store::sql) use key_columns;

/// The columns of a [`Plant`].
macro_rules! plant_columns {
    () => {
        "id, name, description, suspended, version, created_at, updated_at"
    };
}
pub(in crate::store::sql) use plant_columns;

from_row! {
    ApiKey {
        id, tenant, name, role, scopes, san, version, created_at, expires_at, last_used_at, revoked_at, replaced_by,
    }
    NewKey { @key, sha256 }
    KnownKey { @key, sha256, suspended }
    Plant { id, name, description, suspended, version, created_at, updated_at }
}
