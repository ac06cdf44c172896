//! The caller: tenant and name of the actor.

use std::sync::Arc;

use uuid::Uuid;

use super::actor::ANONYMOUS;
use crate::jobs::origin::Origin;

/// No tenant can be named so.
const ROOT: &str = "@root";

/// A plant. Each job belongs to one, and for callers of another it does not exist.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tenant(Arc<str>);

impl Tenant {
    /// Longest name: that of a label of a host name, which a tenant may become.
    pub const LONGEST: usize = 63;

    /// The tenant of that name: lower-case letters, digits and hyphens, a hyphen neither first nor
    /// last.
    pub fn named(name: &str) -> Option<Self> {
        let within = (1..=Self::LONGEST).contains(&name.len());
        let letters = name.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-');
        let ends = name.starts_with('-') || name.ends_with('-');
        (within && letters && !ends).then(|| Tenant(name.into()))
    }

    /// Returns the placeholder for callers without a tenant.
    pub fn root() -> Self {
        Tenant(ROOT.into())
    }

    pub fn is_root(&self) -> bool {
        &*self.0 == ROOT
    }

    /// One that was written down, [`Tenant::root`] among them.
    pub fn kept(name: &str) -> Option<Self> {
        if name == ROOT { Some(Self::root()) } else { Self::named(name) }
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    pub fn name(&self) -> Arc<str> {
        self.0.clone()
    }
}

impl Default for Tenant {
    /// The tenant of callers that no tenant is known of, and of jobs from before there were any.
    fn default() -> Self {
        Tenant("default".into())
    }
}

/// A caller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Caller {
    pub tenant: Tenant,
    /// The name under which the caller acts: of a key, a certificate or a person.
    pub actor: Arc<str>,
    /// Origin of the request.
    pub origin: Origin,
}

impl Caller {
    /// Whoever calls where no key is asked for.
    pub fn anonymous() -> Self {
        Caller { tenant: Tenant::default(), actor: ANONYMOUS.into(), origin: Origin::default() }
    }

    /// Returns the caller of operations that come before it is known who asks.
    pub fn nobody() -> Self {
        Caller { tenant: Tenant::root(), actor: "nobody".into(), origin: Origin::default() }
    }

    /// The name that is kept with what the caller stores; none without authentication.
    pub fn known_actor(&self) -> Option<Arc<str>> {
        (&*self.actor != ANONYMOUS).then(|| self.actor.clone())
    }
}

/// A job or a stream by its id, with the tenant to whom it belongs: what is kept in memory is kept
/// under both.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Owned {
    pub tenant: Tenant,
    pub id: Uuid,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenant_is_named_as_a_host_is() {
        for name in ["default", "a", "plant-7", "0", &"x".repeat(63)] {
            assert_eq!(Tenant::named(name).unwrap().as_str(), name);
        }
        for name in ["", "-a", "a-", "Plant", "a.b", "a b", "é", &"x".repeat(64)] {
            assert_eq!(Tenant::named(name), None, "{name}");
        }
        assert_eq!(Tenant::named("default"), Some(Tenant::default()));
        assert_eq!((Tenant::named(ROOT), Tenant::kept(ROOT)), (None, Some(Tenant::root())));
    }
}
