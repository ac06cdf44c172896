//! Claims of a token.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::error::TokenError;
use crate::jobs::{Role, Scopes, Tenant, actor};

/// Greatest error of the provider's clock.
pub const LEEWAY: SignedDuration = SignedDuration::from_secs(20);

/// Longest subject, as OpenID Connect has it.
const LONGEST_SUBJECT: usize = 255;

/// Whom a token is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    pub tenant: Tenant,
    /// The subject.
    pub actor: Arc<str>,
    /// Role of the token if it names exactly one; with several only their scopes are kept.
    pub role: Option<Role>,
    pub scopes: Scopes,
}

/// Names of the claims with role and tenant.
#[derive(Clone, Debug)]
pub struct Names {
    pub role: String,
    pub tenant: Option<String>,
}

/// See the module's documentation.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub struct Claims(Map<String, Value>);

impl Claims {
    /// A token has one issuer.
    pub fn check_issuer(&self, issuer: &str) -> Result<(), TokenError> {
        if self.text("iss") == Some(issuer) { Ok(()) } else { Err(TokenError::Issuer) }
    }

    /// Time at which the token expires, and at which it begins to be valid, if it has one.
    pub fn times(&self) -> Result<(Timestamp, Option<Timestamp>), TokenError> {
        let moment = |name: &'static str| match self.0.get(name) {
            None => Ok(None),
            Some(value) => {
                let seconds = value.as_f64().filter(|seconds| (0.0..1e11).contains(seconds));
                let moment = seconds.and_then(|seconds| Timestamp::from_second(seconds.floor() as i64).ok());
                moment.map(Some).ok_or(TokenError::Claim(name))
            }
        };
        Ok((moment("exp")?.ok_or(TokenError::Claim("exp"))?, moment("nbf")?))
    }

    pub fn holder(&self, names: &Names) -> Result<Holder, TokenError> {
        let subject = self.text("sub").ok_or(TokenError::Claim("sub"))?;
        let within = (1..=LONGEST_SUBJECT).contains(&subject.len());
        // who wrote an entry of the audit must be plain to whoever reads it
        if !within || subject.contains(actor::misleads) || actor::is_own(subject) {
            return Err(TokenError::Claim("sub"));
        }
        let roles = self.roles(&names.role);
        let tenant = names.tenant.as_deref().and_then(|name| self.at(name));
        let tenant = match (&roles[..], tenant, &names.tenant) {
            ([], ..) => return Err(TokenError::Role),
            // whoever makes tenants is of none
            ([Role::Root], None, _) => Tenant::root(),
            (roles, ..) if roles.contains(&Role::Root) => return Err(TokenError::Role),
            (_, None, None) => Tenant::default(),
            (_, None, Some(_)) => return Err(TokenError::Tenant),
            (_, Some(name), _) => name.as_str().and_then(Tenant::named).ok_or(TokenError::Tenant)?,
        };
        let role = if let [role] = roles[..] { Some(role) } else { None };
        let scopes: Vec<_> = roles.iter().flat_map(|role| role.scopes().iter()).collect();
        Ok(Holder { tenant, actor: subject.into(), role, scopes: Scopes::of(&scopes) })
    }

    /// Known roles in a claim, which may be one name or a list of names.
    fn roles(&self, claim: &str) -> Vec<Role> {
        let mut roles: Vec<Role> = match self.at(claim) {
            Some(Value::String(name)) => Role::named(name).into_iter().collect(),
            Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).filter_map(Role::named).collect(),
            _ => Vec::new(),
        };
        roles.sort_unstable_by_key(|role| role.name());
        roles.dedup();
        roles
    }

    /// The claim of a name; where there is none, the one that the parts of the name lead to.
    fn at(&self, name: &str) -> Option<&Value> {
        let nested = || {
            let mut parts = name.split('.');
            let first = self.0.get(parts.next()?)?;
            parts.try_fold(first, |value, part| value.get(part))
        };
        self.0.get(name).or_else(nested)
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.as_str()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn holder(claims: Value, role: &str, tenant: Option<&str>) -> Result<Holder, TokenError> {
        let claims: Claims = serde_json::from_value(claims).unwrap();
        claims.holder(&Names { role: role.into(), tenant: tenant.map(str::to_owned) })
    }

    #[test]
    fn role_and_tenant_are_claims() {
        let found =
            holder(json!({"sub": "jd", "role": "engineer", "plant": "plant-7"}), "role", Some("plant")).unwrap();
        assert_eq!((found.tenant.as_str(), &*found.actor, found.role), ("plant-7", "jd", Some(Role::Engineer)));
        assert_eq!(found.scopes, Role::Engineer.scopes());
        // as Keycloak and Auth0 write them
        let nested = json!({"sub": "jd", "realm_access": {"roles": ["offline_access", "auditor"]}});
        assert_eq!(holder(nested, "realm_access.roles", None).unwrap().role, Some(Role::Auditor));
        let named = json!({"sub": "jd", "https://cell.example/role": "reader"});
        assert_eq!(holder(named, "https://cell.example/role", None).unwrap().tenant, Tenant::default());
        // who has several may do what any of them may
        let both = holder(json!({"sub": "jd", "role": ["engineer", "auditor", "engineer"]}), "role", None).unwrap();
        assert_eq!((both.role, both.scopes.to_string().as_str()), (None, "read compute measure decide audit"));
    }

    #[test]
    fn times_are_numbers_of_seconds() {
        let times = |claims: Value| serde_json::from_value::<Claims>(claims).unwrap().times();
        let second = |second| Timestamp::from_second(second).unwrap();
        assert_eq!(
            times(json!({"exp": 1.8e9, "nbf": 1_700_000_000.7})),
            Ok((second(1_800_000_000), Some(second(1_700_000_000))))
        );
        assert_eq!(times(json!({})), Err(TokenError::Claim("exp")));
        for wrong in [json!("1800000000"), json!(-1), json!(1e300), json!(null)] {
            assert_eq!(times(json!({"exp": wrong})), Err(TokenError::Claim("exp")));
            assert_eq!(times(json!({"exp": 1, "nbf": wrong})), Err(TokenError::Claim("nbf")));
        }
    }
}
