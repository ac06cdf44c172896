//! Roles and scopes that a key of a tenant can have.

use utoipa::openapi::schema::{Array, ArrayBuilder, Object, ObjectBuilder, Type};

use crate::jobs::{Role, Scope};

const ROLES: &[&str] =
    &[Role::Reader.name(), Role::Operator.name(), Role::Engineer.name(), Role::Auditor.name(), Role::Admin.name()];

const SCOPES: &[&str] = &[
    Scope::Read.name(),
    Scope::Compute.name(),
    Scope::Measure.name(),
    Scope::Decide.name(),
    Scope::Audit.name(),
    Scope::Admin.name(),
];

/// How the interface's document describes such a role.
pub fn role_schema() -> Object {
    let what = "Role of the key: a set of scopes. Either this or `scopes`.";
    one_of_names(ROLES).description(Some(what)).build()
}

/// How it describes such scopes.
pub fn scopes_schema() -> Array {
    let what = "Scopes of the key. Either this or `role`.";
    let scopes = ArrayBuilder::new().items(one_of_names(SCOPES)).min_items(Some(1)).max_items(Some(16));
    scopes.description(Some(what)).build()
}

fn one_of_names(names: &[&str]) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::Scopes;

    /// Everything else is offered.
    #[test]
    fn roles_and_scopes_of_tenants_are_listed() {
        let roles = Role::ALL.map(Role::name);
        assert_eq!(roles.iter().filter(|role| **role != "root").copied().collect::<Vec<_>>(), ROLES);
        assert_eq!(Scopes::OF_TENANT.iter().map(Scope::name).collect::<Vec<_>>(), SCOPES);
    }
}
