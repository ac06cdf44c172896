//! API keys, for servers that were started with some.
//!
//! The server knows digests only. Keys are long random tokens, so one round of SHA-256 is enough;
//! the digests are compared without an early exit.

use axum::http::{HeaderMap, header};
use sha2::{Digest as _, Sha256};

use crate::{
    api::problem::{Problem, ProblemCode},
    config::Digest,
};

/// Refuses a request to the versioned interface without a known key.
pub fn authorize(known: &[Digest], path: &str, headers: &HeaderMap) -> Result<(), Problem> {
    if known.is_empty() || !path.starts_with("/v1/") {
        return Ok(());
    }
    let Some(key) = presented(headers) else {
        return Err(Problem::new(
            ProblemCode::Unauthorized,
            "Send the API key as `Authorization: Bearer …` or in `x-api-key`.",
        ));
    };
    let digest: [u8; 32] = Sha256::digest(key).into();
    // Every known digest is compared, in full.
    let found = known.iter().fold(false, |found, known| found | equal(&known.0, &digest));
    if found { Ok(()) } else { Err(Problem::new(ProblemCode::Forbidden, "This API key is not among the known ones.")) }
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
        let with = |name: &'static str, value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(name, value.parse().unwrap());
            authorize(&known, "/v1/fits", &headers).map_err(|problem| problem.status)
        };
        assert_eq!(with("authorization", "Bearer right"), Ok(()));
        assert_eq!(with("authorization", "bearer right"), Ok(()));
        assert_eq!(with("x-api-key", "right"), Ok(()));
        assert_eq!(with("x-api-key", "wrong"), Err(403));
        assert_eq!(with("authorization", "Basic right"), Err(401));
        assert_eq!(with("accept", "*/*"), Err(401));
        assert!(authorize(&[], "/v1/fits", &HeaderMap::new()).is_ok());
        assert!(authorize(&known, "/healthz", &HeaderMap::new()).is_ok());
    }
}
