//! Who asks.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::names::{RoleName, ScopeName, names_of};
use crate::{
    api::json::text::Moment,
    jobs::{ApiKey, Caller, Role, Scopes},
};

/// Who asks, as the server sees them.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Whoami)]
pub struct WhoamiBody {
    /// Whose jobs they see; absent of a caller of no tenant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tenant: Option<String>,
    /// The name under which they act: `key-` and the id of the key, or the beginning of its digest
    /// where the server's settings name it; `anonymous` where no key is asked for.
    pub actor: String,
    /// Absent where scopes were named one by one, and where no key is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<RoleName>,
    /// What they may ask for.
    pub scopes: Vec<ScopeName>,
    /// The key's id, where the database has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key_id: Option<String>,
    /// The key's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key_name: Option<String>,
    /// When the key ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Moment>,
}

impl WhoamiBody {
    pub fn of(caller: &Caller, role: Option<Role>, scopes: Scopes, key: Option<&ApiKey>) -> Self {
        WhoamiBody {
            tenant: (!caller.tenant.is_root()).then(|| caller.tenant.as_str().to_owned()),
            actor: caller.actor.as_ref().to_owned(),
            role: role.map(RoleName::from),
            scopes: names_of(scopes),
            key_id: key.map(|key| key.id.to_string()),
            key_name: key.map(|key| key.name.clone()),
            expires_at: key.and_then(|key| key.expires_at).map(Moment),
        }
    }
}
