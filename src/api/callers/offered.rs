//! Roles and scopes as they are offered to who makes a key of a tenant: those that are of no tenant
//! are known, and refused with a reason elsewhere, but not among what is named to choose from.

use std::fmt;

use serde::{
    Deserialize, Deserializer,
    de::{EnumAccess, Error, VariantAccess as _, Visitor},
};

use utoipa::openapi::schema::{Array, ArrayBuilder, Object, ObjectBuilder, Type};

use super::names::{RoleName, ScopeName};
use crate::{
    api::json::wording::one_of,
    jobs::{Role, Scope},
};

const ROLES: &[&str] =
    &[Role::Reader.name(), Role::Operator.name(), Role::Engineer.name(), Role::Auditor.name(), Role::Admin.name()];

const SCOPES: &[&str] = &[
    Scope::Read.name(),
    Scope::Compute.name(),
    Scope::Measure.name(),
    Scope::Judge.name(),
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

/// A role, where there is one.
pub fn role<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<RoleName>, D::Error> {
    let offered = Offered { names: ROLES, named: Role::named };
    deserializer.deserialize_enum("Role", ROLES, offered).map(|role| Some(role.into()))
}

/// Scopes, where there are some.
pub fn scopes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<ScopeName>>, D::Error> {
    let scopes = Vec::<OneScope>::deserialize(deserializer)?;
    Ok(Some(scopes.into_iter().map(|OneScope(scope)| scope).collect()))
}

#[derive(Deserialize)]
#[serde(transparent)]
struct OneScope(#[serde(deserialize_with = "scope")] ScopeName);

fn scope<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ScopeName, D::Error> {
    let offered = Offered { names: SCOPES, named: Scope::named };
    deserializer.deserialize_enum("Scope", SCOPES, offered).map(ScopeName::from)
}

struct Offered<T> {
    names: &'static [&'static str],
    /// Knows those of no tenant, too.
    named: fn(&str) -> Option<T>,
}

impl<'de, T> Visitor<'de> for Offered<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&one_of(self.names))
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<T, A::Error> {
        let (name, rest): (String, _) = data.variant()?;
        rest.unit_variant()?;
        (self.named)(&name).ok_or_else(|| A::Error::unknown_variant(&name, self.names))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{api::json::reader::read, jobs::Scopes};

    #[derive(Debug, Deserialize)]
    struct Body {
        #[serde(default, deserialize_with = "role")]
        role: Option<RoleName>,
        #[serde(default, deserialize_with = "scopes")]
        scopes: Option<Vec<ScopeName>>,
    }

    fn said(text: &str) -> (String, String) {
        let fault = read::<Body>(text.as_bytes(), None).unwrap_err().into_fault();
        (fault.pointer, fault.detail)
    }

    #[test]
    fn what_is_of_no_tenant_is_not_offered() {
        let roles = "one of `reader`, `operator`, `engineer`, `auditor`, `admin`";
        let scopes = "one of `read`, `compute`, `measure`, `judge`, `audit`, `admin`";
        for (text, pointer, detail) in [
            (r#"{"role":"engi"}"#, "/role", format!("`engi` is not known; expected {roles}")),
            (r#"{"role":5}"#, "/role", format!("expected {roles} in quotes, found a number")),
            (r#"{"scopes":["read","reed"]}"#, "/scopes/1", format!("`reed` is not known; expected {scopes}")),
            (r#"{"scopes":[true]}"#, "/scopes/0", format!("expected {scopes} in quotes, found a boolean")),
        ] {
            assert_eq!(said(text), (pointer.to_owned(), detail), "{text}");
        }
        let known: Body = read(br#"{"role":"root","scopes":["tenants"]}"#, None).unwrap();
        assert_eq!((known.role, known.scopes), (Some(RoleName::Root), Some(vec![ScopeName::Tenants])));
    }

    /// Everything else is offered.
    #[test]
    fn what_a_tenant_can_have_is_offered() {
        let roles = Role::ALL.map(Role::name);
        assert_eq!(roles.iter().filter(|role| **role != "root").copied().collect::<Vec<_>>(), ROLES);
        assert_eq!(Scopes::OF_TENANT.iter().map(Scope::name).collect::<Vec<_>>(), SCOPES);
    }
}
