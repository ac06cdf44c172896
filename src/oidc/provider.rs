//! Keys of an identity provider: source, and times of requests.
//!
//! Every ten minutes, and when a token names a key that is not known: once a minute at most,
//! however many such tokens come. While the provider does not answer, the keys that it has given go
//! on.

use std::{
    sync::{Arc, PoisonError, RwLock},
    time::{Duration, Instant},
};

use jsonwebtoken::Algorithm;
use serde::Deserialize;
use tokio::sync::Mutex;

use super::{
    error::TokenError,
    key_set::{Key, KeyDigest, KeySet},
};
use crate::{
    config::{OidcSettings, StartError},
    outgoing, telemetry,
};

/// Time between two requests for keys after the provider did not respond.
const RETRY: Duration = Duration::from_secs(15);
/// Time between two requests for keys because of a token.
const PAUSE: Duration = Duration::from_secs(60);
/// Greatest duration and length of a response.
const PATIENCE: Duration = Duration::from_secs(10);
const LONGEST: u64 = 1 << 20;

/// Below the issuer.
const DISCOVERY: &str = "/.well-known/openid-configuration";

/// Metadata published by a provider (OpenID Connect Discovery 1.0, 3).
#[derive(Deserialize)]
struct Discovery {
    issuer: String,
    jwks_uri: String,
}

/// Addresses of the provider and the client that requests its keys.
#[derive(Clone)]
struct Source {
    issuer: String,
    keys: Option<String>,
    agent: ureq::Agent,
}

/// See the module's documentation.
pub struct Provider {
    source: Source,
    /// Time between two requests for keys.
    refresh: Duration,
    /// Keys of the provider; none until it has responded once.
    current: RwLock<Option<Arc<KeySet>>>,
    /// One asks at a time.
    requests: Mutex<Requests>,
}

/// Times of the requests to the provider.
#[derive(Default)]
struct Requests {
    /// Time of the last request, and its success.
    last: Option<(Instant, bool)>,
    /// Because of a token that names a key that is not known.
    for_token: Option<Instant>,
}

impl Requests {
    /// Time until the next request in any case: `refresh` after a success.
    fn rest(&self, refresh: Duration) -> Duration {
        self.last.map_or(Duration::ZERO, |(at, answered)| {
            (if answered { refresh } else { RETRY }).saturating_sub(at.elapsed())
        })
    }
}

impl Provider {
    pub fn of(settings: &OidcSettings, issuer: &str) -> Result<Self, StartError> {
        let keys = settings.jwks_url.clone();
        let agent = outgoing::agent(keys.as_deref().unwrap_or(issuer), PATIENCE, settings.authorities.clone())?;
        let source = Source { issuer: issuer.to_owned(), keys, agent };
        Ok(Provider { source, refresh: settings.refresh, current: RwLock::default(), requests: Mutex::default() })
    }

    /// Keeps the keys current. Never ends.
    pub async fn follow(&self) {
        loop {
            let rest = {
                let mut requests = self.requests.lock().await;
                if requests.rest(self.refresh).is_zero() {
                    self.fetch(&mut requests).await;
                }
                requests.rest(self.refresh)
            };
            tokio::time::sleep(rest).await;
        }
    }

    /// True if a key is one of the provider's.
    pub fn has(&self, digest: &KeyDigest) -> bool {
        self.current().is_some_and(|keys| keys.has(digest))
    }

    /// Returns the key of that name for an algorithm. An unknown one is requested from the
    /// provider.
    pub async fn key(&self, name: Option<&str>, algorithm: Algorithm) -> Result<Key, TokenError> {
        let seen = self.current();
        let find = |keys: &Arc<KeySet>| keys.find(name, algorithm).cloned();
        if let Some(key) = seen.as_ref().and_then(find) {
            return Ok(key);
        }
        self.ask_for_new(seen).await;
        let keys = self.current().ok_or(TokenError::Unavailable)?;
        find(&keys).ok_or(TokenError::UnknownKey)
    }

    /// Asks for keys, unless somebody has done so since `seen`, or lately.
    async fn ask_for_new(&self, seen: Option<Arc<KeySet>>) {
        let mut requests = self.requests.lock().await;
        let lately = requests.for_token.is_some_and(|at| at.elapsed() < PAUSE);
        match (seen, self.current()) {
            // nothing is known yet: as often as it would be anyway
            (None, None) if requests.rest(self.refresh).is_zero() => self.fetch(&mut requests).await,
            (Some(seen), Some(now)) if Arc::ptr_eq(&seen, &now) && !lately => {
                requests.for_token = Some(Instant::now());
                self.fetch(&mut requests).await;
            }
            _ => {}
        }
    }

    fn current(&self) -> Option<Arc<KeySet>> {
        self.current.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks, apart from the threads that serve.
    async fn fetch(&self, requests: &mut Requests) {
        let source = self.source.clone();
        let span = telemetry::here();
        let fetched = tokio::task::spawn_blocking(move || span.in_scope(|| source.fetch())).await;
        let fetched = fetched.unwrap_or_else(|lost| Err(lost.to_string()));
        requests.last = Some((Instant::now(), fetched.is_ok()));
        telemetry::record_identity_provider(fetched.is_ok());
        match fetched {
            Ok(keys) => {
                let (issuer, count) = (&self.source.issuer, keys.len());
                let known = self.current.write().unwrap_or_else(PoisonError::into_inner).replace(Arc::new(keys));
                match known {
                    None => tracing::info!(%issuer, keys = count, "tokens of the identity provider are accepted"),
                    Some(_) => tracing::debug!(%issuer, keys = count, "the identity provider sent its keys"),
                }
            }
            Err(error) if self.current().is_none() => {
                tracing::warn!(%error, "the identity provider does not tell its keys: no token is accepted until it \
                    does");
            }
            Err(error) => tracing::warn!(%error, "the identity provider does not tell its keys: those known go on"),
        }
    }
}

impl Source {
    /// Returns the keys, or the reason why there are none.
    fn fetch(&self) -> Result<KeySet, String> {
        let url = match &self.keys {
            Some(url) => url.clone(),
            None => self.discover()?,
        };
        let keys = KeySet::read(&self.get(&url)?).map_err(|error| invalid(&url, &error))?;
        match keys.is_empty() {
            true => Err(format!("{url} has no key for RS256, PS256, ES256 or EdDSA")),
            false => Ok(keys),
        }
    }

    fn discover(&self) -> Result<String, String> {
        let url = format!("{}{DISCOVERY}", self.issuer.trim_end_matches('/'));
        let said: Discovery = serde_json::from_slice(&self.get(&url)?).map_err(|error| invalid(&url, &error))?;
        if said.issuer != self.issuer {
            return Err(format!("{url} describes another issuer"));
        }
        let secure = said.jwks_uri.starts_with("https://");
        // what is requested without TLS is on this machine, and stays there
        let here = outgoing::is_here(&self.issuer) && outgoing::is_here(&said.jwks_uri);
        match secure || here {
            true => Ok(said.jwks_uri),
            false => Err(format!("the key address in {url} does not use TLS")),
        }
    }

    fn get(&self, url: &str) -> Result<Vec<u8>, String> {
        let failed = |error: ureq::Error| format!("GET {url}: {error}");
        let span = telemetry::asking_span("GET", url);
        let request = self.agent.get(url).header("accept", "application/json");
        let request = telemetry::names(&span).into_iter().fold(request, |request, (name, of)| request.header(name, of));
        // by TLS to begin with, by TLS wherever that leads
        let only = url.starts_with("https://");
        let mut response = request.config().https_only(only).build().call().map_err(|error| {
            telemetry::asked_in_vain(&span);
            failed(error)
        })?;
        telemetry::asked(&span, response.status().as_u16());
        match response.status().as_u16() {
            200 => response.body_mut().with_config().limit(LONGEST).read_to_vec().map_err(failed),
            status => Err(format!("GET {url} was answered {status}")),
        }
    }
}

fn invalid(url: &str, error: &serde_json::Error) -> String {
    format!("the response to GET {url} is invalid: {error}")
}
