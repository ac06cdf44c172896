//! Keys and tenants.

use uuid::Uuid;

use crate::{
    jobs::{ApiKey, KeyId, KnownKey, NewKey, Plant, Role, San, Scopes, Tenant},
    store::sql::columns::{Digest, Integer, Moment},
};

/// The columns of [`KeyRow`].
macro_rules! key_columns {
    () => {
        "k.id AS id, k.tenant AS tenant, k.name AS name, k.role AS role, k.scopes AS scopes, k.san AS san, \
         k.version AS version, k.created_at AS created_at, k.expires_at AS expires_at, \
         k.last_used_at AS last_used_at, k.revoked_at AS revoked_at, k.replaced_by AS replaced_by"
    };
}
pub(in crate::store) use key_columns;

row! {
    pub struct KeyRow {
        id: KeyId,
        tenant: Tenant,
        name: String,
        role: Option<Role>,
        scopes: Scopes,
        san: Option<San>,
        version: Integer<u64>,
        created_at: Moment,
        expires_at: Option<Moment>,
        last_used_at: Option<Moment>,
        revoked_at: Option<Moment>,
        replaced_by: Option<KeyId>,
    }
}

impl From<KeyRow> for ApiKey {
    fn from(row: KeyRow) -> Self {
        ApiKey {
            id: row.id,
            tenant: row.tenant,
            name: row.name,
            role: row.role,
            scopes: row.scopes,
            san: row.san,
            version: row.version.0,
            created_at: row.created_at.0,
            expires_at: row.expires_at.map(|time| time.0),
            last_used_at: row.last_used_at.map(|time| time.0),
            revoked_at: row.revoked_at.map(|time| time.0),
            replaced_by: row.replaced_by,
        }
    }
}

row! {
    /// A key with the digest of its secret.
    pub struct KeptKeyRow {
        @key: KeyRow,
        sha256: Option<Digest>,
    }
}

impl From<KeptKeyRow> for NewKey {
    fn from(row: KeptKeyRow) -> Self {
        NewKey { key: row.key.into(), sha256: row.sha256.map(|Digest(digest)| digest) }
    }
}

row! {
    pub struct KnownKeyRow {
        @key: KeyRow,
        sha256: Option<Digest>,
        suspended: bool,
    }
}

impl From<KnownKeyRow> for KnownKey {
    fn from(row: KnownKeyRow) -> Self {
        let sha256 = row.sha256.map(|Digest(digest)| digest);
        KnownKey { key: row.key.into(), sha256, suspended: row.suspended }
    }
}

/// The columns of [`PlantRow`].
macro_rules! plant_columns {
    () => {
        "id, name, description, suspended, version, created_at, updated_at"
    };
}
pub(in crate::store) use plant_columns;

row! {
    pub struct PlantRow {
        id: Uuid,
        name: Tenant,
        description: Option<String>,
        suspended: bool,
        version: Integer<u64>,
        created_at: Moment,
        updated_at: Moment,
    }
}

impl From<PlantRow> for Plant {
    fn from(row: PlantRow) -> Self {
        Plant {
            id: row.id,
            name: row.name,
            description: row.description,
            suspended: row.suspended,
            version: row.version.0,
            created_at: row.created_at.0,
            updated_at: row.updated_at.0,
        }
    }
}
