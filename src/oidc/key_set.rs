//! The public keys of a provider, as its JWKS names them.

use jsonwebtoken::{
    Algorithm, DecodingKey,
    jwk::{AlgorithmParameters, EllipticCurve, Jwk, KeyAlgorithm, KeyOperations, PublicKeyUse},
};
use serde::Deserialize;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

/// Algorithms that may sign tokens. Symmetric ones are excluded: a server that could verify such
/// tokens could make them.
pub const ALGORITHMS: [Algorithm; 4] = [Algorithm::RS256, Algorithm::PS256, Algorithm::ES256, Algorithm::EdDSA];

/// Most keys of a set.
const MOST: usize = 100;

/// Digest that identifies a key.
pub type KeyDigest = [u8; 32];

/// A public key.
#[derive(Clone, Debug)]
pub struct Key {
    name: Option<String>,
    algorithms: Vec<Algorithm>,
    pub decoding: DecodingKey,
    pub digest: KeyDigest,
}

/// Keys that can be used.
#[derive(Clone, Debug, Default)]
pub struct KeySet(Vec<Key>);

#[derive(Deserialize)]
struct Document {
    keys: Vec<Value>,
}

impl KeySet {
    /// Reads a set. Keys of other kinds and for other purposes are left out.
    pub fn read(text: &[u8]) -> Result<Self, serde_json::Error> {
        let Document { keys } = serde_json::from_slice(text)?;
        Ok(KeySet(keys.into_iter().take(MOST).filter_map(Key::of).collect()))
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The key of that name for an algorithm; without a name the only one for it.
    pub fn find(&self, name: Option<&str>, algorithm: Algorithm) -> Option<&Key> {
        let mut fit = self.0.iter().filter(|key| {
            key.algorithms.contains(&algorithm) && name.is_none_or(|name| key.name.as_deref() == Some(name))
        });
        let first = fit.next()?;
        (name.is_some() || fit.next().is_none()).then_some(first)
    }

    pub fn has(&self, digest: &KeyDigest) -> bool {
        self.0.iter().any(|key| key.digest == *digest)
    }
}

impl Key {
    fn of(value: Value) -> Option<Self> {
        let jwk: Jwk = serde_json::from_value(value).ok()?;
        let common = &jwk.common;
        let is_for_signatures =
            common.public_key_use.as_ref().is_none_or(|purpose| *purpose == PublicKeyUse::Signature);
        let verifies = common.key_operations.as_ref().is_none_or(|may| may.contains(&KeyOperations::Verify));
        if !is_for_signatures || !verifies {
            return None;
        }
        let mut algorithms = match &jwk.algorithm {
            AlgorithmParameters::RSA(_) => vec![Algorithm::RS256, Algorithm::PS256],
            AlgorithmParameters::EllipticCurve(key) if key.curve == EllipticCurve::P256 => vec![Algorithm::ES256],
            AlgorithmParameters::OctetKeyPair(key) if key.curve == EllipticCurve::Ed25519 => vec![Algorithm::EdDSA],
            _ => return None,
        };
        if let Some(only) = common.key_algorithm {
            algorithms.retain(|algorithm| KeyAlgorithm::from(*algorithm) == only);
        }
        let decoding = DecodingKey::from_jwk(&jwk).ok().filter(|_| !algorithms.is_empty())?;
        let digest = Sha256::digest(serde_json::to_vec(&jwk.algorithm).ok()?).into();
        Some(Key { name: jwk.common.key_id, algorithms, decoding, digest })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn names(set: &KeySet) -> Vec<&str> {
        set.0.iter().map(|key| key.name.as_deref().unwrap_or("-")).collect()
    }

    #[test]
    fn keys_of_other_kinds_are_left_out() {
        let (n, x) = ("AQAB".repeat(86), "A".repeat(43));
        let rsa = |name: &str, more: Value| {
            let mut key = json!({"kty": "RSA", "kid": name, "n": n, "e": "AQAB"});
            key.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            key
        };
        let set = json!({"keys": [
            rsa("any", json!({})), rsa("ps", json!({"alg": "PS256", "use": "sig"})),
            rsa("encrypts", json!({"use": "enc"})), rsa("signs", json!({"key_ops": ["sign"]})),
            rsa("rs512", json!({"alg": "RS512"})), rsa("oaep", json!({"alg": "RSA-OAEP"})),
            {"kty": "EC", "kid": "ec", "crv": "P-256", "x": x, "y": x},
            {"kty": "EC", "kid": "p384", "crv": "P-384", "x": x, "y": x},
            {"kty": "OKP", "kid": "ed", "crv": "Ed25519", "x": x, "alg": "EdDSA"},
            {"kty": "OKP", "kid": "x25519", "crv": "X25519", "x": x},
            {"kty": "oct", "kid": "secret", "k": "c2VjcmV0", "alg": "HS256"},
            {"kty": "new", "kid": "new"}, 7,
        ]});
        let set = KeySet::read(set.to_string().as_bytes()).unwrap();
        assert_eq!(names(&set), ["any", "ps", "ec", "ed"]);
        let found = |name: Option<&str>, algorithm| set.find(name, algorithm).map(|key| key.name.clone().unwrap());
        assert_eq!(found(Some("any"), Algorithm::RS256).as_deref(), Some("any"));
        assert_eq!(found(Some("ps"), Algorithm::RS256), None, "it is for PS256 alone");
        assert_eq!(found(Some("ec"), Algorithm::RS256), None);
        // without a name only where there is no doubt
        assert_eq!(found(None, Algorithm::RS256).as_deref(), Some("any"));
        assert_eq!(found(None, Algorithm::PS256), None);
        assert_eq!(found(None, Algorithm::EdDSA).as_deref(), Some("ed"));
        assert!(KeySet::read(b"{}").is_err() && KeySet::read(b"<html>").is_err());
    }

    #[test]
    fn a_key_is_identified_by_its_content() {
        let set = |x: &str, name: &str| {
            let text = json!({"keys": [{"kty": "OKP", "crv": "Ed25519", "kid": name, "x": x}]}).to_string();
            KeySet::read(text.as_bytes()).unwrap()
        };
        let digest = set(&"A".repeat(43), "one").0[0].digest;
        assert!(set(&"A".repeat(43), "other").has(&digest));
        assert!(!set(&("B".repeat(42) + "A"), "one").has(&digest), "another key under the same name");
    }
}
