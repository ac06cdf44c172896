//! Names under which somebody acts, as log and audit have them.

/// Who asks a server that asks for no key.
pub const ANONYMOUS: &str = "anonymous";
/// Who purges what is old.
pub const RETENTION: &str = "retention";
/// Who stores jobs of an archive.
pub const IMPORT: &str = "import";
/// Whoever makes keys on the database itself.
pub const ON_THE_DATABASE: &str = "keys create";
/// Beginning of the actors of keys, before hexadecimal digits.
pub const OF_KEYS: &str = "key-";

/// Whether only the service itself gives this name: nobody else acts under it.
pub fn is_own(name: &str) -> bool {
    let folded = name.trim().to_lowercase();
    let of_key = |digits: &str| !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    [ANONYMOUS, RETENTION, IMPORT, ON_THE_DATABASE].contains(&folded.as_str())
        || folded.strip_prefix(OF_KEYS).is_some_and(of_key)
}

/// Whether a character of a name is not shown, or shows others in another place: control
/// characters, those that set the direction of text, and those that end a line.
pub fn misleads(c: char) -> bool {
    let sets_direction =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || sets_direction || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_service_are_reserved() {
        for own in [
            "retention",
            "import",
            "anonymous",
            "keys create",
            "key-27042f4e6eca",
            "Retention",
            " anonymous ",
            "KEY-0A",
        ] {
            assert!(is_own(own), "{own}");
        }
        for other in ["jd", "retention@plant.example", "key-", "key-jd", "key", "anonymous2", ""] {
            assert!(!is_own(other), "{other}");
        }
    }

    #[test]
    fn invisible_characters_are_misleading() {
        for c in ['\0', '\n', '\u{7f}', '\u{85}', '\u{202e}', '\u{2066}', '\u{200f}', '\u{61c}', '\u{2028}'] {
            assert!(misleads(c), "{c:?}");
        }
        for c in ['a', ' ', 'é', 'ה', 'ع', '名', '\u{200d}'] {
            assert!(!misleads(c), "{c:?}");
        }
    }
}
