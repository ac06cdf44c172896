//! Tokens (JWT) of an identity provider, in the place of keys.
//!
//! A token is believed that the provider has signed (RS256, PS256, ES256 or EdDSA) for this server
//! (`iss`, `aud`) and for now (`exp`, `nbf`). Its subject is the actor; claims name role and
//! tenant. Whether there is such a tenant is not known here.

mod claims;
mod error;
mod key_set;
mod provider;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use jiff::Timestamp;
use jsonwebtoken::{Algorithm, Validation, decode, decode_header};
use sha2::{Digest as _, Sha256};

use crate::{
    config::{OidcSettings, StartError},
    jobs::Clock,
};
use claims::{Claims, Names};
use key_set::KeyDigest;
use provider::Provider;

pub use claims::{Holder, LEEWAY};
pub use error::TokenError;

/// Longest token that is looked at.
const LONGEST: usize = 16 << 10;
/// Tokens that are remembered as verified.
const MOST: usize = 1 << 14;

/// A token that was verified.
#[derive(Clone, Debug)]
pub struct Token {
    pub holder: Holder,
    pub expires_at: Timestamp,
    not_before: Option<Timestamp>,
    /// Digest of the provider's key that verified it.
    key: KeyDigest,
}

/// See the module's documentation.
pub struct Tokens {
    issuer: String,
    audiences: Vec<String>,
    names: Names,
    provider: Provider,
    clock: Arc<dyn Clock>,
    /// Verified tokens by the digests of their texts.
    verified: Mutex<HashMap<[u8; 32], Arc<Token>>>,
}

/// True if a text has the form of a token; a key has not.
pub fn is_token(text: &[u8]) -> bool {
    text.starts_with(b"ey") && text.iter().filter(|byte| **byte == b'.').count() == 2
}

impl Tokens {
    /// Tokens of the provider that the settings name; `None` if they name none.
    pub fn of(settings: &OidcSettings, clock: Arc<dyn Clock>) -> Result<Option<Arc<Self>>, StartError> {
        let Some(issuer) = settings.issuer.clone() else { return Ok(None) };
        Ok(Some(Arc::new(Tokens {
            provider: Provider::of(settings, &issuer)?,
            issuer,
            audiences: settings.audience.clone().unwrap_or_default(),
            names: Names { role: settings.role_claim.clone(), tenant: settings.tenant_claim.clone() },
            clock,
            verified: Mutex::default(),
        })))
    }

    /// Keeps the provider's keys current. Never ends.
    pub async fn follow(&self) {
        self.provider.follow().await;
    }

    /// Whom a token is of, if it is to be believed now.
    pub async fn verify(&self, text: &[u8]) -> Result<Arc<Token>, TokenError> {
        let digest: [u8; 32] = Sha256::digest(text).into();
        let known = self.verified().get(&digest).cloned();
        if let Some(token) = known.filter(|token| self.provider.has(&token.key)) {
            return self.check_time(&token).map(|()| token);
        }
        let token = Arc::new(self.verify_anew(text).await?);
        self.check_time(&token)?;
        let mut verified = self.verified();
        if verified.len() >= MOST {
            verified.clear();
        }
        verified.insert(digest, token.clone());
        Ok(token)
    }

    async fn verify_anew(&self, text: &[u8]) -> Result<Token, TokenError> {
        if text.len() > LONGEST {
            return Err(TokenError::Malformed);
        }
        let header = decode_header(text).map_err(|_| TokenError::Algorithm)?;
        if header.crit.is_some() || header.enc.is_some() || header.zip.is_some() {
            return Err(TokenError::Critical);
        }
        if !key_set::ALGORITHMS.contains(&header.alg) {
            return Err(TokenError::Algorithm);
        }
        let key = self.provider.key(header.kid.as_deref(), header.alg).await?;
        let claims: Claims = decode(text, &key.decoding, &self.validation(header.alg)).map_err(refusal)?.claims;
        claims.check_issuer(&self.issuer)?;
        let (expires_at, not_before) = claims.times()?;
        Ok(Token { holder: claims.holder(&self.names)?, expires_at, not_before, key: key.digest })
    }

    /// All but the time, for which there is a clock here.
    fn validation(&self, algorithm: Algorithm) -> Validation {
        let mut validation = Validation::new(algorithm);
        validation.set_required_spec_claims(&["exp", "iss", "aud", "sub"]);
        validation.set_issuer(&[&self.issuer]);
        validation.set_audience(&self.audiences);
        (validation.validate_exp, validation.validate_nbf) = (false, false);
        validation
    }

    fn check_time(&self, token: &Token) -> Result<(), TokenError> {
        let now = self.clock.now();
        if now >= token.expires_at + LEEWAY {
            return Err(TokenError::Expired);
        }
        match token.not_before {
            Some(begin) if now + LEEWAY < begin => Err(TokenError::NotYet),
            _ => Ok(()),
        }
    }

    /// The time that a token still lets in; none where it has expired, or the provider has taken
    /// its key back.
    pub fn left(&self, token: &Token) -> Option<Duration> {
        let left = (token.expires_at + LEEWAY).duration_since(self.clock.now());
        Duration::try_from(left).ok().filter(|left| self.provider.has(&token.key) && !left.is_zero())
    }

    fn verified(&self) -> MutexGuard<'_, HashMap<[u8; 32], Arc<Token>>> {
        self.verified.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Translates an error of the JWT library into the service's own.
fn refusal(error: jsonwebtoken::errors::Error) -> TokenError {
    use jsonwebtoken::errors::ErrorKind;
    match error.kind() {
        ErrorKind::InvalidAudience => TokenError::Audience,
        ErrorKind::InvalidIssuer => TokenError::Issuer,
        ErrorKind::MissingRequiredClaim(name) => match name.as_str() {
            "exp" => TokenError::Claim("exp"),
            "iss" => TokenError::Claim("iss"),
            "aud" => TokenError::Claim("aud"),
            _ => TokenError::Claim("sub"),
        },
        ErrorKind::Json(_) | ErrorKind::Base64(_) | ErrorKind::Utf8(_) => TokenError::Malformed,
        _ => TokenError::Signature,
    }
}
