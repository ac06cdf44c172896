//! The caller.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::names::names_of;
use crate::{
    api::json::text::Moment,
    jobs::{ApiKey, Caller, Role, Scope, Scopes},
};

/// The caller, as the server identifies it.
#[skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Whoami)]
pub struct WhoamiBody {
    /// Tenant of the caller; absent for a caller of no tenant.
    pub tenant: Option<String>,
    /// Name of the caller: `key-` and the id of the key, or the beginning of the key's digest if
    /// the server's settings contain it; for a token its subject; `anonymous` where no key is
    /// required.
    pub actor: String,
    /// Kind of credential; absent where no key is required.
    pub kind: Option<ProofName>,
    /// Absent where scopes were listed one by one or a token has several roles, and where no key is
    /// required.
    pub role: Option<Role>,
    /// Scopes of the caller.
    pub scopes: Vec<Scope>,
    /// The key's id, where the database has it.
    pub key_id: Option<String>,
    /// The key's name.
    pub key_name: Option<String>,
    /// Time when the key or the token expires.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Moment>,
}

/// Kind of credential.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Proof)]
pub enum ProofName {
    /// A key that is sent.
    Secret,
    /// A client's certificate.
    Certificate,
    /// A token of the identity provider.
    Token,
}

impl WhoamiBody {
    pub fn of(caller: &Caller, role: Option<Role>, scopes: Scopes) -> Self {
        WhoamiBody {
            tenant: (!caller.tenant.is_root()).then(|| caller.tenant.as_str().to_owned()),
            actor: caller.actor.as_ref().to_owned(),
            kind: None,
            role,
            scopes: names_of(scopes),
            key_id: None,
            key_name: None,
            expires_at: None,
        }
    }

    /// It is a key of the database that lets them in.
    pub fn take_key(&mut self, key: &ApiKey) {
        self.kind = Some(if key.san.is_some() { ProofName::Certificate } else { ProofName::Secret });
        self.key_id = Some(key.id.to_string());
        self.key_name = Some(key.name.clone());
        self.expires_at = key.expires_at.map(Moment);
    }

    /// It is a token.
    pub fn take_token(&mut self, expires_at: Timestamp) {
        self.kind = Some(ProofName::Token);
        self.expires_at = Some(Moment(expires_at));
    }
}
