//! Names of roles, scopes and kinds of keys on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::jobs::{Role, Scope, Scopes};

/// A role: scopes that go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Role)]
pub enum RoleName {
    Reader,
    Operator,
    Engineer,
    Auditor,
    Admin,
    Root,
}

/// Scope that an operation requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Scope)]
pub enum ScopeName {
    Read,
    Compute,
    Measure,
    Judge,
    Audit,
    Admin,
    Tenants,
}

/// Proof of a key: a secret that is sent, or a client certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = KeyKind)]
pub enum KeyKindName {
    #[default]
    Secret,
    Certificate,
}

impl From<RoleName> for Role {
    fn from(name: RoleName) -> Self {
        match name {
            RoleName::Reader => Role::Reader,
            RoleName::Operator => Role::Operator,
            RoleName::Engineer => Role::Engineer,
            RoleName::Auditor => Role::Auditor,
            RoleName::Admin => Role::Admin,
            RoleName::Root => Role::Root,
        }
    }
}

impl From<Role> for RoleName {
    fn from(role: Role) -> Self {
        match role {
            Role::Reader => RoleName::Reader,
            Role::Operator => RoleName::Operator,
            Role::Engineer => RoleName::Engineer,
            Role::Auditor => RoleName::Auditor,
            Role::Admin => RoleName::Admin,
            Role::Root => RoleName::Root,
        }
    }
}

impl From<ScopeName> for Scope {
    fn from(name: ScopeName) -> Self {
        match name {
            ScopeName::Read => Scope::Read,
            ScopeName::Compute => Scope::Compute,
            ScopeName::Measure => Scope::Measure,
            ScopeName::Judge => Scope::Judge,
            ScopeName::Audit => Scope::Audit,
            ScopeName::Admin => Scope::Admin,
            ScopeName::Tenants => Scope::Tenants,
        }
    }
}

impl From<Scope> for ScopeName {
    fn from(scope: Scope) -> Self {
        match scope {
            Scope::Read => ScopeName::Read,
            Scope::Compute => ScopeName::Compute,
            Scope::Measure => ScopeName::Measure,
            Scope::Judge => ScopeName::Judge,
            Scope::Audit => ScopeName::Audit,
            Scope::Admin => ScopeName::Admin,
            Scope::Tenants => ScopeName::Tenants,
        }
    }
}

/// The names of a set.
pub fn names_of(scopes: Scopes) -> Vec<ScopeName> {
    scopes.iter().map(ScopeName::from).collect()
}
