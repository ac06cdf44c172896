//! API keys, for servers that were started with some.
//!
//! The server knows digests only. Keys are long random tokens, so one round of SHA-256 is enough;
//! the digests are compared without an early exit.

use axum::http::{HeaderMap, Method, header};
use sha2::{Digest as _, Sha256};

use crate::{
    api::problem::{Problem, ProblemCode},
    config::{Digest, KeysRole},
    jobs::{Caller, Role, Scopes, Tenant},
    telemetry,
};

/// Who asks, and what they may ask for (a request extension).
#[derive(Clone, Debug, PartialEq)]
pub struct Principal {
    pub caller: Caller,
    pub scopes: Scopes,
    pub role: Option<Role>,
}

/// Who may call, and as whom.
pub struct Callers {
    /// By the digests of their keys.
    known: Vec<(Digest, Principal)>,
    /// Whoever calls a server that was started without keys.
    anonymous: Principal,
}

impl Callers {
    /// Callers with one of the keys of these digests, in a role, or anybody if there are none.
    pub fn of(digests: &[Digest], role: Role) -> Self {
        let principal = |actor: String, role: Option<Role>| Principal {
            caller: Caller { tenant: Tenant::default(), actor: actor.into(), origin: Default::default() },
            scopes: role.map_or(Scopes::ALL, Role::scopes),
            role,
        };
        let known = digests.iter().map(|digest| (*digest, principal(name_of_key(digest), Some(role)))).collect();
        Callers { known, anonymous: principal("anonymous".to_owned(), None) }
    }

    /// Whether each has a key, so that they can be told from each other.
    pub fn are_known(&self) -> bool {
        !self.known.is_empty()
    }

    /// Makes out the caller of a request to the versioned interface, and refuses one without a
    /// known key. Outside of that interface nobody is asked, and there is no caller; nor is
    /// somebody who only asks which methods there are (`OPTIONS`).
    pub fn identify(&self, method: &Method, path: &str, headers: &HeaderMap) -> Result<Option<Principal>, Problem> {
        if !path.starts_with("/v1/") || method == Method::OPTIONS {
            return Ok(None);
        }
        if self.known.is_empty() {
            telemetry::record_authentication("none");
            return Ok(Some(self.anonymous.clone()));
        }
        let Some(key) = presented(headers) else {
            telemetry::record_authentication("missing");
            return Err(Problem::new(
                ProblemCode::Unauthorized,
                "Send the API key as `Authorization: Bearer …` or in `x-api-key`.",
            ));
        };
        let digest: [u8; 32] = Sha256::digest(key).into();
        // Every known digest is compared, in full.
        let mut found = None;
        for (known, principal) in &self.known {
            if equal(&known.0, &digest) {
                found = Some(principal);
            }
        }
        match found {
            Some(principal) => {
                telemetry::record_authentication("ok");
                Ok(Some(principal.clone()))
            }
            None => {
                telemetry::record_authentication("invalid");
                Err(Problem::new(ProblemCode::InvalidKey, "This API key is not known, or cannot be used any more."))
            }
        }
    }
}

impl From<KeysRole> for Role {
    fn from(role: KeysRole) -> Self {
        match role {
            KeysRole::Reader => Role::Reader,
            KeysRole::Operator => Role::Operator,
            KeysRole::Engineer => Role::Engineer,
            KeysRole::Auditor => Role::Auditor,
            KeysRole::Admin => Role::Admin,
        }
    }
}

/// A key as the log names it: by the beginning of its digest, which tells nothing of the key.
fn name_of_key(Digest(digest): &Digest) -> String {
    digest.iter().take(6).fold("key-".to_owned(), |name, byte| name + &format!("{byte:02x}"))
}

fn presented(headers: &HeaderMap) -> Option<&[u8]> {
    if let Some(value) = headers.get("x-api-key") {
        return Some(value.as_bytes());
    }
    let value = headers.get(header::AUTHORIZATION)?.as_bytes();
    let (scheme, key) = value.split_at_checked(7)?;
    scheme.eq_ignore_ascii_case(b"bearer ").then(|| key.trim_ascii())
}

fn equal(a: &[u8; 32], b: &[u8; 32]) -> bool {
    let difference = a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a ^ b));
    std::hint::black_box(difference) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_asked_for_only_where_there_are_some() {
        let known = [Digest(Sha256::digest(b"right").into()), Digest([7; 32])];
        let callers = Callers::of(&known, Role::Engineer);
        let with = |name: &'static str, value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(name, value.parse().unwrap());
            callers.identify(&Method::POST, "/v1/fits", &headers).map_err(|problem| problem.status)
        };
        let right = with("authorization", "Bearer right").unwrap().unwrap();
        assert_eq!((right.caller.tenant, &*right.caller.actor), (Tenant::default(), "key-27042f4e6eca"));
        assert_eq!(right.scopes, Role::Engineer.scopes());
        assert!(with("authorization", "bearer right").is_ok());
        assert!(with("x-api-key", "right").is_ok());
        assert_eq!(with("x-api-key", "wrong"), Err(401));
        assert_eq!(with("authorization", "Basic right"), Err(401));
        assert_eq!(with("accept", "*/*"), Err(401));
        let none = HeaderMap::new();
        let open = Callers::of(&[], Role::Engineer).identify(&Method::POST, "/v1/fits", &none).unwrap().unwrap();
        assert_eq!((&*open.caller.actor, open.scopes), ("anonymous", Scopes::ALL));
        assert!(callers.identify(&Method::GET, "/healthz", &none).unwrap().is_none());
        assert!(callers.identify(&Method::OPTIONS, "/v1/fits", &none).unwrap().is_none());
    }
}
