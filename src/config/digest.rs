//! Digests of API keys.

use super::bounds::parse_list;

/// SHA-256 of an API key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub [u8; 32]);

/// Digests of all keys.
pub type Digests = Vec<Digest>;

/// Reads digests separated by commas; an empty text has none, as in `FLANKFIT_API_KEYS_SHA256=`.
pub fn parse_digests(text: &str) -> Result<Digests, String> {
    parse_list(text, |text| {
        let mut digest = [0; 32];
        if text.len() != 64 || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err("a SHA-256 digest has 64 hexadecimal digits".into());
        }
        for (k, byte) in digest.iter_mut().enumerate() {
            *byte = u8::from_str_radix(&text[2 * k..2 * k + 2], 16).map_err(|error| error.to_string())?;
        }
        Ok(Digest(digest))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_read_strictly() {
        let text = "00ff".to_owned() + &"0".repeat(60);
        assert_eq!(parse_digests(&text).map(|digests| digests[0].0[1]), Ok(255));
        assert!(parse_digests("00").is_err());
        assert!(parse_digests(&"g".repeat(64)).is_err());
        assert_eq!(parse_digests(&format!("{text}, {text}")).map(|digests| digests.len()), Ok(2));
        assert_eq!(parse_digests(" "), Ok(Vec::new()));
        assert!(parse_digests(&format!("{text},")).is_err());
    }
}
