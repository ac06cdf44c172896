//! Leaves members out of finished JSON. The rest stays byte for byte.

use std::sync::Arc;

use memchr::memmem;

use super::{
    cursor::{Cursor, Syntax, Token},
    location::Location,
};

/// Returns the text without members that are `null`, which are absent. In lists `null` is a value:
/// a missing node.
pub fn without_nulls(text: &str) -> Result<Arc<str>, Syntax> {
    if memmem::find(text.as_bytes(), b"null").is_none() {
        return Ok(text.into());
    }
    without(text, |_, token| token == Token::Null)
}

/// Returns the text without the members of objects that `leaves_out` is true for.
pub fn without(text: &str, leaves_out: impl Fn(&Location<'_>, Token) -> bool) -> Result<Arc<str>, Syntax> {
    let mut rest = Rest { text, copied: 0, out: String::with_capacity(text.len()), leaves_out };
    rest.value(&mut Cursor::new(text.as_bytes()), &Location::Root)?;
    rest.copy_to(text.len());
    Ok(rest.out.into())
}

/// Text that is copied up to a place, in part.
struct Rest<'t, F> {
    text: &'t str,
    copied: usize,
    out: String,
    leaves_out: F,
}

impl<F: Fn(&Location<'_>, Token) -> bool> Rest<'_, F> {
    fn copy_to(&mut self, end: usize) {
        self.out.push_str(&self.text[self.copied..end]);
        self.copied = end;
    }

    fn value(&mut self, cursor: &mut Cursor<'_>, at: &Location<'_>) -> Result<(), Syntax> {
        match cursor.token()? {
            Token::Object => {
                // end of the member before, and whether one of them is kept
                let (mut end, mut follows) = (cursor.at + 1, false);
                cursor.object(|cursor, key| {
                    let member = Location::Member(at, &key);
                    let token = cursor.token()?;
                    if (self.leaves_out)(&member, token) {
                        cursor.skip_value()?;
                        self.copy_to(end);
                        self.copied = cursor.at;
                    } else {
                        if !follows && self.copied == end {
                            self.copied += self.text[end..].find(',').map_or(0, |comma| comma + 1);
                        }
                        follows = true;
                        self.value(cursor, &member)?;
                    }
                    end = cursor.at;
                    Ok(())
                })
            }
            Token::Array => cursor.array(|cursor, index| self.value(cursor, &Location::Entry(at, index))),
            _ => cursor.skip_value().map(drop),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_that_are_null_are_left_out_and_the_rest_stays() {
        for (text, rest) in [
            (r#"{ "a": 1.50, "b" :null , "c": [1, null] }"#, r#"{ "a": 1.50 , "c": [1, null] }"#),
            (r#"{"a":null,"b":1}"#, r#"{"b":1}"#),
            (r#"{ "a" : null , "b":null, "c":2,"d":null}"#, r#"{ "c":2}"#),
            (r#"{"a":null}"#, "{}"),
            (r#"{"a":{"b":null},"c":[{"d":null,"e":"null"},null]}"#, r#"{"a":{},"c":[{"e":"null"},null]}"#),
            (r#"{"null":{"null":{"a":1}}}"#, r#"{"null":{"null":{"a":1}}}"#),
            ("null", "null"),
            (r#" {"é":1} "#, r#" {"é":1} "#),
        ] {
            assert_eq!(&*without_nulls(text).unwrap(), rest, "{text}");
        }
        assert!(without_nulls(r#"{"a":null"#).is_err());
    }

    #[test]
    fn members_are_left_out_by_their_places() {
        let inner = |at: &Location<'_>, _| matches!(at, Location::Member(Location::Member(Location::Root, "a"), "b"));
        let text = r#"{"b": 1, "a": {"b": [2], "c": {"b": 3}}}"#;
        assert_eq!(&*without(text, inner).unwrap(), r#"{"b": 1, "a": { "c": {"b": 3}}}"#);
    }
}
