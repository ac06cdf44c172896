//! Permissions of callers: each operation of the interface requires one scope.

use std::fmt::{self, Display};

/// Scope that an operation requires.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize, utoipa::ToSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Reading what is stored.
    Read,
    /// Computing without storing.
    Compute,
    /// Storing what was measured and what follows from it by itself.
    Measure,
    /// Storing what somebody has decided.
    Decide,
    /// Reading who did what.
    Audit,
    /// Keys of the tenant.
    Admin,
    /// Tenants, and the first key of each.
    Tenants,
}

names! {
    Scope {
        Read "read", Compute "compute", Measure "measure", Decide "decide", Audit "audit", Admin "admin",
        Tenants "tenants",
    }
}

impl Scope {
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A set of scopes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scopes(u8);

impl Scopes {
    /// Every scope.
    pub const ALL: Scopes = Scopes::of(&Scope::ALL);
    /// Every scope that somebody of a tenant can have.
    pub const OF_TENANT: Scopes =
        Scopes::of(&[Scope::Read, Scope::Compute, Scope::Measure, Scope::Decide, Scope::Audit, Scope::Admin]);

    pub const fn of(scopes: &[Scope]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < scopes.len() {
            bits |= scopes[i].bit();
            i += 1;
        }
        Scopes(bits)
    }

    pub fn contains(self, scope: Scope) -> bool {
        self.0 & scope.bit() != 0
    }

    /// In the order of their declaration.
    pub fn iter(self) -> impl Iterator<Item = Scope> {
        Scope::ALL.into_iter().filter(move |scope| self.contains(*scope))
    }

    /// Those of a text as it is displayed.
    pub fn named(text: &str) -> Option<Self> {
        let scopes: Option<Vec<Scope>> = text.split(' ').filter(|name| !name.is_empty()).map(Scope::named).collect();
        scopes.map(|scopes| Scopes::of(&scopes))
    }
}

impl Display for Scopes {
    /// Their names with spaces between them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, scope) in self.iter().enumerate() {
            let space = if i == 0 { "" } else { " " };
            write!(f, "{space}{}", scope.name())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_written_and_read_again() {
        for bits in 0..1 << Scope::ALL.len() {
            let set = Scopes(bits);
            assert_eq!(Scopes::named(&set.to_string()), Some(set));
            assert_eq!(Scopes::of(&set.iter().collect::<Vec<_>>()), set);
        }
        assert_eq!(Scopes::named("read write"), None);
        assert_eq!(Scopes::of(&[Scope::Decide, Scope::Read]).to_string(), "read decide");
        assert!(!Scopes::OF_TENANT.contains(Scope::Tenants));
    }
}
