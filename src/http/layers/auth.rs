//! Authentication of the caller by an API key, a token of an identity provider or a client's
//! certificate, in one place.
//!
//! Of keys the server knows digests only; they are compared in [`secret::same`] and nowhere else.
//! Keys of the settings are looked at first, then tokens, then the keys of the store.

use std::future;

use axum::http::Extensions;
use tokio::time::sleep;

use super::prelude::*;
use crate::{
    config::{Authentication, Digest, KeysRole, ServeSettings},
    http::server::PeerNames,
    jobs::{Caller, JobService, KnownKey, KnownKeys, RepositoryError, Role, Scopes, actor, rows::to_hex, secret},
    oidc::{self, Token, TokenError, Tokens},
    pool::Party,
};

/// Who asks, and what they may ask for (a request extension).
#[derive(Clone, Debug)]
pub struct Principal {
    pub caller: Caller,
    pub scopes: Scopes,
    pub role: Option<Role>,
    pub proof: Proof,
}

/// Credential of a caller.
#[derive(Clone, Debug)]
pub enum Proof {
    /// Nothing was asked for.
    None,
    /// A key that the settings name.
    Listed,
    /// A key of the store, of a secret or of a certificate.
    Key(Arc<KnownKey>),
    /// A token of the identity provider.
    Token(Arc<Token>),
}

impl Principal {
    /// Returns true if it is one of several callers who can be distinguished.
    pub fn is_known(&self) -> bool {
        !matches!(self.proof, Proof::None)
    }

    /// With whom turns are shared on the pool.
    pub fn party(&self) -> Party {
        Some(self.caller.tenant.name())
    }
}

/// Who may call, and as whom.
pub struct Callers {
    /// By the digests of the keys of the settings.
    listed: Vec<(Digest, Principal)>,
    /// The keys of the store.
    kept: KnownKeys,
    /// Tokens of an identity provider, where the settings name one.
    tokens: Option<Arc<Tokens>>,
    key_required: bool,
    /// Whether keys will be required from the next start on, once one exists.
    is_undecided: bool,
    /// The caller of every request if no key is required.
    anonymous: Principal,
}

impl Callers {
    /// Decides whether a key is required for the lifetime of the process: a key created meanwhile
    /// locks no caller out.
    pub async fn of(
        settings: &ServeSettings,
        jobs: &JobService,
        tokens: Option<Arc<Tokens>>,
    ) -> Result<Self, RepositoryError> {
        let kept = jobs.known_keys();
        let is_configured = jobs.is_shared() || tokens.is_some() || !settings.api_keys_sha256.is_empty();
        let key_required = match settings.auth {
            Authentication::Off => false,
            Authentication::Required => true,
            Authentication::Auto => is_configured || kept.exist().await?,
        };
        let principal = |caller: Caller, role: Option<Role>, proof: Proof| Principal {
            caller,
            scopes: role.map_or(Scopes::ALL, Role::scopes),
            role,
            proof,
        };
        let role = Some(settings.api_keys_role.into());
        let of_key = |digest: &Digest| {
            let caller = Caller { actor: name_of_key(digest).into(), ..Caller::anonymous() };
            (*digest, principal(caller, role, Proof::Listed))
        };
        Ok(Callers {
            listed: settings.api_keys_sha256.iter().map(of_key).collect(),
            kept,
            tokens,
            key_required,
            is_undecided: settings.auth == Authentication::Auto && !key_required,
            anonymous: principal(Caller::anonymous(), None, Proof::None),
        })
    }

    /// The keys of the store.
    pub fn kept(&self) -> &KnownKeys {
        &self.kept
    }

    /// Keeps what is known of the identity provider current. Ends where there is none.
    pub async fn follow_provider(&self) {
        if let Some(tokens) = &self.tokens {
            tokens.follow().await;
        }
    }

    /// Returns the problem of a caller who is not let in any more, as soon as that is so.
    pub async fn ended(&self, proof: &Proof) -> Problem {
        let ended = match proof {
            Proof::Key(key) => self.kept.ended(key).await,
            Proof::Token(token) => {
                self.token_ended(token).await;
                Ok(())
            }
            Proof::None | Proof::Listed => future::pending().await,
        };
        let detail = "The key or token of this request cannot be used any more, so its work was cancelled.";
        ended.map_or_else(Problem::from, |()| Problem::new(ProblemCode::InvalidKey, detail))
    }

    async fn token_ended(&self, token: &Token) {
        while let Some(left) = self.tokens.as_ref().and_then(|tokens| tokens.left(token)) {
            // the store that does not answer ends nobody
            if matches!(self.lets_in(token).await, Ok(false)) {
                return;
            }
            sleep(left.min(LOOK)).await;
        }
    }

    /// Whether the tenant of a token's holder is there, and let in at present.
    async fn lets_in(&self, token: &Token) -> Result<bool, RepositoryError> {
        let tenant = &token.holder.tenant;
        if tenant.is_root() { Ok(true) } else { self.kept.lets_in(tenant).await }
    }

    /// Whether requests need a key.
    pub fn key_required(&self) -> bool {
        self.key_required
    }

    /// Whether a key created now would be the first one, so that keys are required from the next
    /// start on.
    pub async fn await_first_key(&self) -> Result<bool, RepositoryError> {
        Ok(self.is_undecided && !self.kept.exist().await?)
    }

    /// Makes out the caller of a request to the versioned interface, and refuses one who is not let
    /// in. Outside of that interface nobody is asked, and there is no caller; nor is somebody who
    /// only asks which methods there are (`OPTIONS`).
    pub async fn identify(
        &self,
        method: &Method,
        path: &str,
        headers: &HeaderMap,
        extensions: &Extensions,
    ) -> Result<Option<Principal>, Problem> {
        if !path.starts_with("/v1/") || method == Method::OPTIONS {
            return Ok(None);
        }
        let (outcome, identified) = match self.key_required {
            false => ("none", Ok(self.anonymous.clone())),
            true => self.let_in(headers, extensions.get()).await,
        };
        telemetry::record_authentication(outcome);
        identified.map(Some)
    }

    async fn let_in(
        &self,
        headers: &HeaderMap,
        names: Option<&PeerNames>,
    ) -> (&'static str, Result<Principal, Problem>) {
        let found = match (presented(headers), names) {
            (Some((key, form)), _) => match (self.listed(key), &self.tokens) {
                (Some(principal), _) => return ("ok", Ok(principal.clone())),
                (None, Some(tokens)) if form == Form::Bearer && oidc::is_token(key) => {
                    return self.of_token(tokens, key).await;
                }
                _ => self.kept.of_secret(key).await.map(|key| (key, true)),
            },
            (None, Some(PeerNames(names))) => self.kept.of_certificate(names).await,
            (None, None) => Ok((None, false)),
        };
        match found {
            Ok((Some(key), _)) => {
                self.kept.note_use(key.key.id);
                ("ok", Ok(key.into()))
            }
            Ok((None, true)) => {
                let detail = "This API key is not known, or cannot be used any more.";
                ("invalid", Err(Problem::new(ProblemCode::InvalidKey, detail)))
            }
            Ok((None, false)) => {
                let detail = match self.tokens {
                    Some(_) => "Send a token or an API key as `Authorization: Bearer …`.",
                    None => "Send the API key as `Authorization: Bearer …` or in `x-api-key`.",
                };
                ("missing", Err(Problem::new(ProblemCode::Unauthorized, detail)))
            }
            Err(away) => ("unavailable", Err(away.into())),
        }
    }

    async fn of_token(&self, tokens: &Tokens, text: &[u8]) -> (&'static str, Result<Principal, Problem>) {
        let invalid = |reason: TokenError| {
            let detail = "This token is not from the identity provider of this server, is not valid now, or has no \
                known role or tenant.";
            ("invalid", Err(Problem::new(ProblemCode::InvalidKey, detail).caused_by(reason)))
        };
        match tokens.verify(text).await {
            Ok(token) => match self.lets_in(&token).await {
                Ok(true) => ("ok", Ok(token.into())),
                Ok(false) => invalid(TokenError::Tenant),
                Err(away) => ("unavailable", Err(away.into())),
            },
            Err(reason @ TokenError::Unavailable) => {
                let detail = "The keys of the identity provider are not known yet; try again in a moment.";
                let problem = Problem::new(ProblemCode::IssuerUnavailable, detail).caused_by(reason).retry_after(15);
                ("unavailable", Err(problem))
            }
            Err(reason) => invalid(reason),
        }
    }

    /// Whose key it is of those that the settings name. Every digest is compared, in full.
    fn listed(&self, key: &[u8]) -> Option<&Principal> {
        let digest = secret::digest(key);
        let mut found = None;
        for (known, principal) in &self.listed {
            if secret::same(&known.0, &digest) {
                found = Some(principal);
            }
        }
        found
    }
}

impl From<Arc<KnownKey>> for Principal {
    fn from(known: Arc<KnownKey>) -> Self {
        let key = &known.key;
        Principal { caller: key.caller(), scopes: key.scopes, role: key.role, proof: Proof::Key(known) }
    }
}

impl From<Arc<Token>> for Principal {
    fn from(token: Arc<Token>) -> Self {
        let holder = &token.holder;
        let (tenant, actor) = (holder.tenant.clone(), holder.actor.clone());
        let caller = Caller { tenant, actor, origin: Default::default() };
        Principal { caller, scopes: holder.scopes, role: holder.role, proof: Proof::Token(token) }
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

/// A key of the settings as the log names it: by the beginning of its digest, which reveals nothing
/// of the key.
fn name_of_key(Digest(digest): &Digest) -> String {
    actor::OF_KEYS.to_owned() + &to_hex(&digest[..6])
}

/// Place of a key or a token in the request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Header,
    Bearer,
}

fn presented(headers: &HeaderMap) -> Option<(&[u8], Form)> {
    if let Some(value) = headers.get(API_KEY) {
        return Some((value.as_bytes(), Form::Header));
    }
    let value = headers.get(header::AUTHORIZATION)?.as_bytes();
    let (scheme, key) = value.split_at_checked(7)?;
    scheme.eq_ignore_ascii_case(b"bearer ").then(|| (key.trim_ascii(), Form::Bearer))
}

/// Between two looks whether a token still lets in whoever is in already.
const LOOK: Duration = Duration::from_secs(5);

/// The header that may carry a key instead of `Authorization`.
const API_KEY: &str = "x-api-key";

/// Takes the key out of a request: who comes later has no use for it.
pub fn forget(headers: &mut HeaderMap) {
    headers.remove(API_KEY);
    headers.remove(header::AUTHORIZATION);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_either_header_and_forgotten() {
        let with = |name: &'static str, value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(name, value.parse().unwrap());
            let found = presented(&headers).map(|(key, _)| key.to_vec());
            forget(&mut headers);
            assert_eq!(presented(&headers), None);
            found
        };
        assert_eq!(with("authorization", "Bearer right"), Some(b"right".to_vec()));
        assert_eq!(with("authorization", "bearer right"), Some(b"right".to_vec()));
        assert_eq!(with("x-api-key", "right"), Some(b"right".to_vec()));
        assert_eq!(with("authorization", "Basic right"), None);
        assert_eq!(with("accept", "*/*"), None);
    }

    #[test]
    fn a_key_of_the_settings_is_named_by_its_digest() {
        assert_eq!(name_of_key(&Digest(secret::digest(b"right"))), "key-27042f4e6eca");
    }
}
