//! Numbers of settings that 0 makes no sense for.

use std::num::NonZeroU32;

/// A whole number above 0.
pub fn parse_positive(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| format!("write a whole number from 1 to {}, or leave the setting out", u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_no_limit() {
        assert_eq!(parse_positive("7"), Ok(NonZeroU32::new(7).unwrap()));
        for text in ["0", "-1", "1.5", "", "4294967296"] {
            assert!(parse_positive(text).unwrap_err().contains("leave the setting out"), "{text}");
        }
    }
}
