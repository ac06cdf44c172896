//! Header values of the form `value; name=value; name="value"`, such as `content-type` and
//! `content-disposition`.

/// The value before the first semicolon, in lower case.
pub fn essence(header: &str) -> String {
    header.split(';').next().unwrap_or("").trim().to_ascii_lowercase()
}

/// The value of a parameter, without its quotes. Names are the same in any case.
pub fn parameter(header: &str, name: &str) -> Option<String> {
    let mut rest = header.split_once(';')?.1;
    loop {
        let (found, after) = rest.split_once('=')?;
        // anything before is a parameter without a value
        let found = found.rsplit(';').next().unwrap_or("").trim();
        let (value, next) = value(after.trim_start());
        if found.eq_ignore_ascii_case(name) {
            return Some(value);
        }
        rest = next;
    }
}

/// A quoted string or a token, and what comes after the semicolon that ends it.
fn value(text: &str) -> (String, &str) {
    let end = |rest: &'_ str| rest.find(';').map_or(rest.len(), |at| at + 1);
    let Some(quoted) = text.strip_prefix('"') else {
        let token = text.split(';').next().unwrap_or("");
        return (token.trim().to_owned(), &text[end(text)..]);
    };
    let mut value = String::new();
    let mut chars = quoted.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        match c {
            '"' => {
                let rest = &quoted[at + 1..];
                return (value, &rest[end(rest)..]);
            }
            // Some programs write the path of a file with plain backslashes.
            '\\' => match chars.next_if(|(_, next)| matches!(next, '"' | '\\')) {
                Some((_, escaped)) => value.push(escaped),
                None => value.push('\\'),
            },
            plain => value.push(plain),
        }
    }
    (value, "")
}

/// The character set that a text is said to have, where it is not UTF-8 (or ASCII, which is part of
/// it).
pub fn foreign_charset(header: &str) -> Option<String> {
    let name = parameter(header, "charset")?;
    let known = ["utf-8", "utf8", "us-ascii", "ascii"].iter().any(|known| name.eq_ignore_ascii_case(known));
    (!known).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_found_quoted_or_not() {
        let header = r#"form-data; x; name = "a;b=\"c\""; FileName="C:\dir\f.csv"; plain=token ; last=" s p ""#;
        assert_eq!(parameter(header, "name").as_deref(), Some(r#"a;b="c""#));
        assert_eq!(parameter(header, "filename").as_deref(), Some(r"C:\dir\f.csv"));
        assert_eq!(parameter(header, "plain").as_deref(), Some("token"));
        assert_eq!(parameter(header, "last").as_deref(), Some(" s p "));
        assert_eq!(parameter(header, "x"), None);
        assert_eq!(parameter("text/csv", "charset"), None);
        assert_eq!(parameter("text/csv; charset=\"open", "charset").as_deref(), Some("open"));
        assert_eq!(essence(" Text/CSV ;charset=x"), "text/csv");
    }

    #[test]
    fn only_utf_8_is_at_home() {
        assert_eq!(foreign_charset("application/json"), None);
        assert_eq!(foreign_charset("application/json; charset=\"UTF-8\""), None);
        assert_eq!(foreign_charset("text/csv; charset=us-ascii"), None);
        assert_eq!(foreign_charset("application/json;Charset=utf-16").as_deref(), Some("utf-16"));
    }
}
