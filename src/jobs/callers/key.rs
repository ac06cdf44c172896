//! Keys as they are kept: whose they are and what they allow; of a secret its digest alone.

use std::{
    fmt::{self, Display},
    sync::Arc,
};

use jiff::Timestamp;

use crate::jobs::*;

/// By which a key is found and named; no secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyId(u64);

impl KeyId {
    pub const fn of(number: u64) -> Self {
        KeyId(number)
    }

    pub const fn number(self) -> u64 {
        self.0
    }

    /// The id of 16 hexadecimal digits.
    pub fn named(text: &str) -> Option<Self> {
        let digits = text.len() == 16 && text.bytes().all(|c| c.is_ascii_digit() || (b'a'..=b'f').contains(&c));
        digits.then(|| u64::from_str_radix(text, 16).ok().map(KeyId))?
    }
}

impl Display for KeyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// A name in a client's certificate: of a host (DNS) or a URI.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct San(Arc<str>);

impl San {
    /// Longest name.
    pub const LONGEST: usize = 253;

    /// A name of visible ASCII letters; with a colon it is a URI, else that of a host, whose
    /// letters have no case.
    pub fn named(text: &str) -> Option<Self> {
        let visible = (1..=Self::LONGEST).contains(&text.len()) && text.bytes().all(|c| c.is_ascii_graphic());
        if !visible {
            return None;
        }
        if let Some((scheme, rest)) = text.split_once(':') {
            let letters = scheme.bytes().all(|c| c.is_ascii_alphanumeric() || matches!(c, b'+' | b'-' | b'.'));
            let is_uri = scheme.starts_with(|c: char| c.is_ascii_alphabetic()) && letters && !rest.is_empty();
            return is_uri.then(|| San(text.into()));
        }
        let label = |label: &str| {
            let letters = label.bytes().all(|c| c.is_ascii_alphanumeric() || matches!(c, b'-' | b'_'));
            (1..=63).contains(&label.len()) && letters
        };
        text.split('.').all(label).then(|| San(text.to_ascii_lowercase().into()))
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// A key without what proves it.
#[derive(Clone, Debug, PartialEq)]
pub struct ApiKey {
    pub id: KeyId,
    pub tenant: Tenant,
    pub name: String,
    /// None where scopes were named one by one.
    pub role: Option<Role>,
    pub scopes: Scopes,
    /// Name in a certificate; none for a secret.
    pub san: Option<San>,
    /// 1 when created, one more with every change (not with every use).
    pub version: u64,
    pub created_at: Timestamp,
    pub expires_at: Option<Timestamp>,
    /// To the minute.
    pub last_used_at: Option<Timestamp>,
    pub revoked_at: Option<Timestamp>,
    /// The key that took its place.
    pub replaced_by: Option<KeyId>,
}

impl ApiKey {
    /// As whom its holder acts.
    pub fn caller(&self) -> Caller {
        Caller {
            tenant: self.tenant.clone(),
            actor: format!("{}{}", actor::OF_KEYS, self.id).into(),
            origin: Default::default(),
        }
    }

    /// Returns whether it lets anybody in at this time.
    pub fn is_valid(&self, now: Timestamp) -> bool {
        self.revoked_at.is_none() && self.expires_at.is_none_or(|end| now < end)
    }

    /// The key after `patch`; the version moves on only when something changed. The end of one that
    /// was replaced is not put off.
    pub fn patched(&self, patch: KeyPatch, now: Timestamp) -> Result<ApiKey, RepositoryError> {
        self.check_alive(now)?;
        if patch.expires_at > self.expires_at {
            self.check_place()?;
        }
        let mut key = self.clone();
        key.name = patch.name.unwrap_or(key.name);
        key.expires_at = patch.expires_at.or(key.expires_at);
        key.version += u64::from(key != *self);
        Ok(key)
    }

    /// The key after another has taken its place: it ends with the overlap at the latest. That is
    /// done once: a further key would live no longer than what is left of this one.
    pub fn rotated(&self, rotation: &Rotation) -> Result<ApiKey, RepositoryError> {
        let new = &rotation.new.key;
        self.check_place()?;
        self.check_alive(new.created_at)?;
        if self.san.is_some() {
            return Err(RepositoryError::NoSecret);
        }
        let ends = self.expires_at.map_or(rotation.old_ends, |end| end.min(rotation.old_ends));
        let version = self.version + 1;
        Ok(ApiKey { expires_at: Some(ends), replaced_by: Some(new.id), version, ..self.clone() })
    }

    /// The key after its end for good.
    pub fn revoked(&self, now: Timestamp) -> ApiKey {
        ApiKey { revoked_at: Some(now), version: self.version + 1, ..self.clone() }
    }

    /// Refuses what has ended, by itself or by somebody: it does not come back.
    fn check_alive(&self, now: Timestamp) -> Result<(), RepositoryError> {
        match self.expires_at {
            _ if self.revoked_at.is_some() => Err(RepositoryError::KeyRevoked),
            Some(at) if at <= now => Err(RepositoryError::KeyEnded { at }),
            _ => Ok(()),
        }
    }

    /// Refuses a key whose place another has taken.
    fn check_place(&self) -> Result<(), RepositoryError> {
        match self.replaced_by {
            Some(by) => Err(RepositoryError::KeyReplaced { by: by.to_string() }),
            None => Ok(()),
        }
    }
}

/// A key to be kept, with the digest of its secret where it has one.
#[derive(Clone, Debug)]
pub struct NewKey {
    pub key: ApiKey,
    pub sha256: Option<[u8; 32]>,
}

/// A key as it is asked about when somebody comes with it.
#[derive(Clone, Debug)]
pub struct KnownKey {
    pub key: ApiKey,
    pub sha256: Option<[u8; 32]>,
    /// Its tenant is not let in at present.
    pub suspended: bool,
}

impl KnownKey {
    pub fn is_valid(&self, now: Timestamp) -> bool {
        !self.suspended && self.key.is_valid(now)
    }
}

/// A change of a key; what is not named stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyPatch {
    pub name: Option<String>,
    pub expires_at: Option<Timestamp>,
}

/// A secret that takes the place of another, which goes on for a while.
#[derive(Clone, Debug)]
pub struct Rotation {
    pub of: KeyId,
    /// When the old one ends, unless it ends earlier anyway.
    pub old_ends: Timestamp,
    pub new: NewKey,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_sixteen_digits() {
        let id = KeyId::of(0xa1);
        assert_eq!((id.to_string().as_str(), KeyId::named("00000000000000a1")), ("00000000000000a1", Some(id)));
        for wrong in ["", "a1", "00000000000000A1", "+0000000000000a1", "00000000000000a1f", "é000000000000a1"] {
            assert_eq!(KeyId::named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn names_of_certificates_are_hosts_or_uris() {
        for (text, kept) in
            [("Press7.Plant.example", "press7.plant.example"), ("spiffe://plant/Press7", "spiffe://plant/Press7")]
        {
            assert_eq!(San::named(text).unwrap().as_str(), kept);
        }
        for wrong in
            ["", "*.example", "a..b", ".a", "a b", "7:x", ":x", "urn:", "é.example", &"x".repeat(254), &"x".repeat(64)]
        {
            assert_eq!(San::named(wrong), None, "{wrong}");
        }
    }
}
