//! Parts of a whole.

/// A part that is more than nothing, up to 1.
pub fn parse_share(text: &str) -> Result<f64, String> {
    parse_part(text).ok().filter(|share| *share > 0.0).ok_or_else(|| "write a number above 0, up to 1".into())
}

/// A part from 0 to 1.
pub fn parse_part(text: &str) -> Result<f64, String> {
    let part = text.parse::<f64>().ok().filter(|part| (0.0..=1.0).contains(part));
    part.ok_or_else(|| "write a number from 0 to 1".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_no_more_than_everything_and_not_nothing() {
        assert_eq!((parse_share("0.5"), parse_share("1"), parse_part("0")), (Ok(0.5), Ok(1.0), Ok(0.0)));
        for wrong in ["-0.1", "1.1", "NaN", "half", ""] {
            assert!(parse_share(wrong).is_err() && parse_part(wrong).is_err(), "{wrong}");
        }
        assert!(parse_share("0").is_err());
    }
}
