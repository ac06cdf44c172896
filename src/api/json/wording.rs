//! What is said of a wrong value, in the words of the contract: no type of Rust, and no text of the
//! caller's at any length.

use std::borrow::Cow;

use serde::de::Unexpected;

use super::nearest::nearest;
use flankfit_engine::words::{Shown, entries};

/// Characters of the caller's text that a message repeats.
const REPEATED: usize = 64;

/// Of a number that no double holds.
pub const BEYOND: &str = "the number is beyond double precision (about 1.8e308)";
/// Of an array where an object is wanted, whatever the array holds.
pub const OBJECT_WANTED: &str = "expected an object, found an array";
/// Of a union's `type` that is no string.
pub const NAME_WANTED: &str = "expected one of the names that are offered here, in quotes";

/// What to say of a value of another kind or range than `expected`.
pub fn mismatch(found: Unexpected, expected: &str) -> String {
    let beyond = match found {
        Unexpected::Unsigned(_) => true,
        Unexpected::Float(number) => number.abs() >= i64::MAX as f64,
        _ => false,
    };
    let wanted = match expected {
        "i64" if beyond => Cow::from(format!("a whole number from {} to {}", i64::MIN, i64::MAX)),
        _ => wanted(expected),
    };
    let found = shown(found, wanted.contains("whole number"));
    format!("expected {wanted}, found {found}")
}

/// What to say of an array with too few entries for what `expected` says.
pub fn too_short(length: usize, expected: &str) -> String {
    format!("expected {}, found {}", wanted(expected), entries(length))
}

/// What to say of an array with more entries than there may be.
pub fn too_long(most: usize, length: usize) -> String {
    format!("expected an array of {}, found {}", entries(most), entries(length))
}

/// What to say of a name that is none of those known.
pub fn unknown_name(name: &str, known: &str) -> String {
    format!("`{}` is not known; expected {known}", shortened(name))
}

/// What to say of what is no string where one of the names `known` is wanted.
pub fn name_wanted(known: &[&str], found: &str) -> String {
    format!("expected {} in quotes, found {found}", one_of(known))
}

/// Names to choose from.
pub fn one_of(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        [name] => format!("`{name}`"),
        [a, b] => format!("`{a}` or `{b}`"),
        names => format!("one of `{}`", names.join("`, `")),
    }
}

/// What to say of a field that is not known.
pub fn no_such_field(name: &str, known: &[&str]) -> String {
    if let Some(near) = nearest(name, known.iter().copied()) {
        return format!("there is no such field; did you mean `{near}`?");
    }
    match known.is_empty() {
        true => "there is no such field; expected none".to_owned(),
        false => {
            format!("there is no such field; expected {}", alternatives(known.iter().map(|key| format!("`{key}`"))))
        }
    }
}

/// One of several, in words: `a`, `a or b`, `a, b or c`.
pub fn alternatives(names: impl IntoIterator<Item = impl Into<String>>) -> String {
    let mut names: Vec<String> = names.into_iter().map(Into::into).collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() { last } else { format!("{} or {last}", names.join(", ")) }
}

/// What is wanted, where serde has words of its own for it.
fn wanted(expected: &str) -> Cow<'_, str> {
    match expected {
        "usize" | "u64" => "a whole number of at least 0".into(),
        "i64" | "i32" => "a whole number".into(),
        "u32" => "a whole number from 0 to 4294967295".into(),
        "u8" => "a small whole number".into(),
        "f64" => "a number".into(),
        "a sequence" => "an array".into(),
        "a map" => "an object".into(),
        // serde calls any type for which it has no words by its Rust name
        other if other.starts_with("struct ") => "an object".into(),
        other => match other.strip_prefix("an array of length ") {
            Some(length) => format!("an array of {length} entries").into(),
            None => other.into(),
        },
    }
}

/// What stands there instead.
fn shown(found: Unexpected, whole: bool) -> String {
    match found {
        Unexpected::Float(number) if whole && number.fract() == 0.0 => {
            format!("{} written with a decimal point, with an exponent or with too many digits", Shown(number))
        }
        Unexpected::Float(number) => Shown(number).to_string(),
        Unexpected::Unsigned(number) => number.to_string(),
        Unexpected::Signed(number) => number.to_string(),
        Unexpected::Bool(value) => value.to_string(),
        Unexpected::Str(text) => {
            // more than is repeated, with its quotes and escapes
            let begin: String = text.chars().take(REPEATED + 1).collect();
            format!("the string {}", shortened(&format!("{begin:?}")))
        }
        Unexpected::Unit => "null".to_owned(),
        Unexpected::Seq => "an array".to_owned(),
        Unexpected::Map => "an object".to_owned(),
        other => shortened(&other.to_string()).into_owned(),
    }
}

fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(REPEATED) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, de::DeserializeOwned};

    use crate::api::json::reader::read;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Pair {
        #[serde(rename = "a")]
        _a: usize,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Nothing {}

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Name {
        FirstOrder,
        Exact,
    }

    fn said<T: DeserializeOwned + std::fmt::Debug>(text: &str) -> String {
        read::<T>(text.as_bytes(), None).unwrap_err().to_string()
    }

    #[test]
    fn no_type_of_rust_is_named() {
        const WHOLE: &str = "expected a whole number of at least 0, found ";
        assert_eq!(said::<usize>("-3"), format!("{WHOLE}-3"));
        assert_eq!(said::<u64>("1.5"), format!("{WHOLE}1.5"));
        assert!(said::<usize>("1e9").starts_with(&format!("{WHOLE}1000000000 written with")));
        assert!(said::<u64>("1e300").starts_with(&format!("{WHOLE}1e300 written with")));
        assert_eq!(said::<u32>("4294967296"), "expected a whole number from 0 to 4294967295, found 4294967296");
        const LONG: &str = "expected a whole number from -9223372036854775808 to 9223372036854775807, found ";
        assert_eq!(said::<i64>("9223372036854775808"), format!("{LONG}9223372036854775808"));
        assert!(said::<i64>("-9223372036854775809").starts_with(LONG), "{}", said::<i64>("-9223372036854775809"));
        assert_eq!(said::<i64>("1.5"), "expected a whole number, found 1.5");
        assert_eq!(said::<f64>("true"), "expected a number, found true");
        assert_eq!(said::<f64>("null"), "expected a number, found null");
        assert_eq!(said::<f64>("1e999"), "the number is beyond double precision (about 1.8e308)");
        assert_eq!(said::<f64>(r#""1, expected 2""#), r#"expected a number, found the string "1, expected 2""#);
        assert_eq!(said::<String>("[]"), "expected a string, found an array");
        assert_eq!(said::<bool>("{}"), "expected a boolean, found an object");
        assert_eq!(said::<Vec<f64>>("1"), "expected an array, found 1");
        assert_eq!(said::<[f64; 2]>("[1]"), "expected an array of 2 entries, found 1 entry");
        assert_eq!(said::<Pair>("1"), "expected an object, found 1");
        assert_eq!(said::<Name>(r#""first""#), "`first` is not known; expected `first_order` or `exact`");
        assert_eq!(said::<Name>("5"), "expected `first_order` or `exact` in quotes, found a number");
    }

    fn fault_of<T: DeserializeOwned + std::fmt::Debug>(text: &str) -> (String, String) {
        let fault = read::<T>(text.as_bytes(), None).unwrap_err().into_fault();
        (fault.pointer, fault.detail)
    }

    #[test]
    fn fields_are_named() {
        let said = |text: &str| fault_of::<Pair>(text);
        assert_eq!(said("{}"), ("/a".into(), "missing".into()));
        assert_eq!(said(r#"{"a":1,"a":2}"#), ("/a".into(), "the field occurs twice; give it once".into()));
        let nothing = fault_of::<Nothing>(r#"{"b":1}"#);
        assert_eq!(nothing, ("/b".into(), "there is no such field; expected none".into()));
        assert_eq!(said(r#"{"b`c":1}"#), ("/b`c".into(), "there is no such field; expected `a`".into()));
    }

    #[test]
    fn a_long_text_is_not_repeated() {
        let said = said::<f64>(&format!("{:?}", "ä".repeat(100_000)));
        assert!(said.starts_with("expected a number, found the string") && said.chars().count() < 120, "{said}");
    }
}
