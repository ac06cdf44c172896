//! Scopes that go together, by the work of those who have them.

use super::scope::{
    Scope::{Admin, Audit, Compute, Judge, Measure, Read, Tenants},
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

impl Role {
    pub const ALL: [Role; 6] = [Role::Reader, Role::Operator, Role::Engineer, Role::Auditor, Role::Admin, Role::Root];

    pub const fn name(self) -> &'static str {
        match self {
            Role::Reader => "reader",
            Role::Operator => "operator",
            Role::Engineer => "engineer",
            Role::Auditor => "auditor",
            Role::Admin => "admin",
            Role::Root => "root",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }

    pub const fn scopes(self) -> Scopes {
        match self {
            Role::Reader => Scopes::of(&[Read, Compute]),
            Role::Operator => Scopes::of(&[Read, Compute, Measure]),
            Role::Engineer => Scopes::of(&[Read, Compute, Measure, Judge]),
            Role::Auditor => Scopes::of(&[Read, Audit]),
            Role::Admin => Scopes::of(&[Read, Audit, Admin]),
            Role::Root => Scopes::of(&[Tenants]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_have_the_scopes_of_the_table() {
        let scopes = |role: Role| role.scopes().to_string();
        let table = Role::ALL.map(|role| (role.name(), scopes(role)));
        let expected = [
            ("reader", "read compute"),
            ("operator", "read compute measure"),
            ("engineer", "read compute measure judge"),
            ("auditor", "read audit"),
            ("admin", "read audit admin"),
            ("root", "tenants"),
        ];
        assert_eq!(table, expected.map(|(role, scopes)| (role, scopes.to_owned())));
        assert!(Role::ALL.into_iter().all(|role| Role::named(role.name()) == Some(role)));
        assert_eq!(Role::named("god"), None);
    }
}
