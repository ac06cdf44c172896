//! Keys as they are written and read.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    names::{KeyKindName, names_of},
    offered,
};
use crate::{
    api::{
        faults::Faults,
        json::text::{Moment, ShortText},
        warning::WarningBody,
    },
    jobs::{ApiKey, KeyDraft, KeyPatch, Role, San, Scope, Scopes, Secret},
};

/// A key to make.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewKey, example = json!({"name": "grinder 3", "role": "operator", "expires_at": "2030-01-01T00:00:00Z"}))]
pub struct NewKeyBody {
    /// Name of the key's holder, a person or a program.
    #[schema(value_type = String, min_length = 1, max_length = 200)]
    pub name: ShortText,
    /// Set of scopes. Either this or `scopes`.
    #[serde(default)]
    #[schema(schema_with = offered::role_schema)]
    pub role: Option<Role>,
    /// Scopes of the key. Either this or `role`.
    #[serde(default)]
    #[schema(schema_with = offered::scopes_schema)]
    pub scopes: Option<Vec<Scope>>,
    /// Time when it ends; without it the key does not expire.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Moment>,
    /// Kind of the key; by default a secret.
    #[serde(default)]
    #[schema(required = false)]
    pub kind: KeyKindName,
    /// For a certificate: a subject alternative name, either a host name (DNS) or a URI.
    #[schema(min_length = 1, max_length = 253)]
    pub san: Option<String>,
}

/// Changes of a key. Fields that are left out stay unchanged.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = KeyPatch, example = json!({"name": "grinder 4"}))]
pub struct KeyPatchBody {
    /// The new name.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub name: Option<ShortText>,
    /// The new end, later than now; for a replaced key no later than its current end. (To end a key
    /// now, delete it.)
    #[schema(value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Moment>,
}

/// Another secret for the holder of a key.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = KeyRotation, example = json!({"overlap_seconds": 86400}))]
pub struct RotationBody {
    /// Seconds for which the old key stays valid, so that the new one can be distributed; 0 ends it
    /// at once; at most 30 days.
    #[schema(maximum = 2592000)]
    pub overlap_seconds: u32,
}

/// A key.
#[skip_serializing_none]
#[derive(Clone, Serialize, Deserialize, ToSchema)]
#[schema(as = Key)]
pub struct KeyBody {
    /// 16 hexadecimal digits, not secret: the part of the key after `ffk_`.
    pub id: String,
    /// Tenant of the key; absent for a key of no tenant.
    pub tenant: Option<String>,
    /// Name of the key's holder, a person or a program.
    pub name: String,
    /// Absent if scopes were given one by one.
    pub role: Option<Role>,
    /// Scopes of the key.
    pub scopes: Vec<Scope>,
    pub kind: KeyKindName,
    /// For a certificate: its subject alternative name.
    pub san: Option<String>,
    /// Time when the key was made.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub created_at: Moment,
    /// Time when it ends or ended.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Moment>,
    /// Time of the last accepted request, within a minute; absent before the first.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub last_used_at: Option<Moment>,
    /// Time when it was revoked.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub revoked_at: Option<Moment>,
    /// The key that replaced it in a rotation.
    pub replaced_by: Option<String>,
    /// The key itself, only in the response to the request that made it. It cannot be retrieved
    /// later.
    pub key: Option<String>,
    /// Consequences of making the key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningBody>,
}

/// Message for an end that has passed.
const IN_THE_FUTURE: &str = "the end must be later than now";

impl NewKeyBody {
    /// The key that is asked for, at this time.
    pub fn draft(self, now: Timestamp) -> Result<KeyDraft, Faults> {
        let mut faults = Faults::default();
        let role = self.role;
        let scopes = match (role, &self.scopes) {
            (Some(role), None) => role.scopes(),
            (None, Some(named)) => {
                let named: Vec<Scope> = named.to_vec();
                if named.is_empty() {
                    faults.push("/scopes", "name at least one scope");
                }
                Scopes::of(&named)
            }
            (Some(_), Some(_)) => {
                faults.push("/scopes", "give either `role` or `scopes`, not both");
                Scopes::default()
            }
            (None, None) => {
                faults.push("/role", "give `role` or `scopes`");
                Scopes::default()
            }
        };
        let san = match (self.kind, self.san) {
            (KeyKindName::Secret, None) => None,
            (KeyKindName::Certificate, Some(name)) => {
                let san = San::named(&name);
                if san.is_none() {
                    let form =
                        "not the name of a host such as press7.plant.example, nor a URI such as spiffe://plant/7";
                    faults.push("/san", form);
                }
                san
            }
            (KeyKindName::Secret, Some(_)) => {
                faults.push("/san", "a secret has no subject name; send `\"kind\": \"certificate\"`, or omit it");
                None
            }
            (KeyKindName::Certificate, None) => {
                faults.push("/san", "give a host name or a URI from the subject alternative names of the certificate");
                None
            }
        };
        let expires_at = self.expires_at.map(|Moment(end)| end);
        if expires_at.is_some_and(|end| end <= now) {
            faults.push("/expires_at", IN_THE_FUTURE);
        }
        faults.into_result(KeyDraft { name: self.name.into(), role, scopes, expires_at, san })
    }
}

impl KeyPatchBody {
    /// The change that is asked for, at this time.
    pub fn patch(self, now: Timestamp) -> Result<KeyPatch, Faults> {
        let expires_at = self.expires_at.map(|Moment(end)| end);
        if expires_at.is_some_and(|end| end <= now) {
            return Err(Faults::one("/expires_at", IN_THE_FUTURE));
        }
        Ok(KeyPatch { name: self.name.map(String::from), expires_at })
    }
}

impl KeyBody {
    /// Converts a key, with its secret if the caller may see it.
    pub fn of(key: &ApiKey, secret: Option<&Secret>) -> Self {
        KeyBody {
            id: key.id.to_string(),
            tenant: (!key.tenant.is_root()).then(|| key.tenant.as_str().to_owned()),
            name: key.name.clone(),
            role: key.role,
            scopes: names_of(key.scopes),
            kind: if key.san.is_some() { KeyKindName::Certificate } else { KeyKindName::Secret },
            san: key.san.as_ref().map(|san| san.as_str().to_owned()),
            created_at: Moment(key.created_at),
            expires_at: key.expires_at.map(Moment),
            last_used_at: key.last_used_at.map(Moment),
            revoked_at: key.revoked_at.map(Moment),
            replaced_by: key.replaced_by.map(|by| by.to_string()),
            key: secret.map(|secret| secret.expose().to_owned()),
            warnings: Vec::new(),
        }
    }
}

impl From<ApiKey> for KeyBody {
    fn from(key: ApiKey) -> Self {
        KeyBody::of(&key, None)
    }
}
