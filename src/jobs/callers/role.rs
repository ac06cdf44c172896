//! Scopes that go together, by the work of those who have them.

use super::scope::{
    Scope::{Admin, Audit, Compute, Decide, Measure, Read, Tenants},
    Scopes,
};

/// A role: scopes that go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    Reader,
    Operator,
    Engineer,
    Auditor,
    Admin,
    /// Administers tenants; belongs to none.
    Root,
}

names! {
    Role {
        Reader "reader", Operator "operator", Engineer "engineer", Auditor "auditor", Admin "admin", Root "root",
    }
}

impl Role {
    pub const fn scopes(self) -> Scopes {
        match self {
            Role::Reader => Scopes::of(&[Read, Compute]),
            Role::Operator => Scopes::of(&[Read, Compute, Measure]),
            Role::Engineer => Scopes::of(&[Read, Compute, Measure, Decide]),
            Role::Auditor => Scopes::of(&[Read, Audit]),
            Role::Admin => Scopes::of(&[Read, Audit, Admin]),
            Role::Root => Scopes::of(&[Tenants]),
        }
    }
}
