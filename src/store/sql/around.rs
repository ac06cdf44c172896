//! An answer that contains a text which is stored anyway, as the parts around that text.

/// Returns the parts of a body before and after a text; `None` if the body does not contain it.
///
/// Answers end with the result of their fit, but for a few brackets; so it is looked for from the
/// end.
pub fn around<'a>(body: &'a [u8], text: &str) -> Option<(&'a [u8], &'a [u8])> {
    let last = body.len().checked_sub(text.len())?;
    let at = (0..=last).rev().find(|&at| body[at..].starts_with(text.as_bytes()))?;
    Some((&body[..at], &body[at + text.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_and_the_text_are_the_body() {
        let parts = |body: &'static str, text| around(body.as_bytes(), text);
        assert_eq!(parts("[{1}]", "{1}"), Some((b"[".as_slice(), b"]".as_slice())));
        assert_eq!(parts("{1}", "{1}"), Some((b"".as_slice(), b"".as_slice())));
        // the last of several
        assert_eq!(parts("{1}{1},", "{1}"), Some((b"{1}".as_slice(), b",".as_slice())));
        assert_eq!(parts("[{1}]", "{2}"), None);
        assert_eq!(parts("{", "{1}"), None);
    }
}
