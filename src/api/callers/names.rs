//! Names of roles, scopes and kinds of keys on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::jobs::{Scope, Scopes};

/// Proof of a key: a secret that is sent, or a client certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = KeyKind)]
pub enum KeyKindName {
    #[default]
    Secret,
    Certificate,
}

/// The names of a set.
pub fn names_of(scopes: Scopes) -> Vec<Scope> {
    scopes.iter().collect()
}
