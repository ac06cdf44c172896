//! Digests of API keys.

/// SHA-256 of an API key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub [u8; 32]);

/// Digests of all keys.
pub type Digests = Vec<Digest>;

/// Digests separated by commas; an empty text has none, as in `FLANKFIT_API_KEYS_SHA256=`.
pub fn parse_digests(text: &str) -> Result<Digests, String> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(parse_digest).collect()
}

fn parse_digest(text: &str) -> Result<Digest, String> {
    let text = text.trim();
    let mut digest = [0_u8; 32];
    if text.len() != 64 || !text.is_ascii() {
        return Err("a SHA-256 digest has 64 hexadecimal digits".into());
    }
    for (byte, pair) in digest.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
        let pair = std::str::from_utf8(pair).map_err(|error| error.to_string())?;
        *byte = u8::from_str_radix(pair, 16).map_err(|error| error.to_string())?;
    }
    Ok(Digest(digest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_read_strictly() {
        let text = "00ff".to_owned() + &"0".repeat(60);
        assert_eq!(parse_digest(&text).map(|d| d.0[1]), Ok(255));
        assert!(parse_digest("00").is_err());
        assert!(parse_digest(&"g".repeat(64)).is_err());
        assert_eq!(parse_digests(&format!("{text}, {text}")).map(|digests| digests.len()), Ok(2));
        assert_eq!(parse_digests(" "), Ok(Vec::new()));
        assert!(parse_digests(&format!("{text},")).is_err());
    }
}
