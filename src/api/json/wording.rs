//! What serde says of a wrong value, in the words of the contract.
//!
//! serde names Rust's types (`usize`, `struct Tag`) and repeats the caller's text however long it
//! is. Messages come in a few forms; one that is in none of them was written here in the first
//! place, and stays.

use std::borrow::Cow;

use super::nearest::nearest;
use flankfit_engine::fault::words::{Shown, entries};

/// Characters of the caller's text that a message repeats.
const REPEATED: usize = 64;

/// What ids are.
pub const UUID: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000, in quotes";

/// The message, without the place in the slice (which is not the place in the request), and the
/// field that it speaks of when that is unknown, missing or twice.
pub fn explain(message: &str) -> (Option<String>, String) {
    let message = message.rsplit_once(" at line ").map_or(message, |(before, _)| before);
    // The caller's text may hold anything, so what serde says after it is looked for from the end.
    let named = |prefix: &str| {
        let rest = message.strip_prefix(prefix)?;
        let bare = rest.strip_suffix("`, there are no fields").or(rest.strip_suffix('`')).unwrap_or(rest);
        Some(rest.rsplit_once("`, expected ").unwrap_or((bare, "")))
    };
    if let Some((name, known)) = named("unknown field `") {
        // serde lists them as "`a`, `b`", "`a` or `b`" or "one of `a`, `b`": every second piece
        // between the quotes is a name
        let names: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        return (Some(name.to_owned()), no_such_field(name, &names));
    }
    if let Some((name, _)) = named("missing field `") {
        return (Some(name.to_owned()), "missing".into());
    }
    if let Some((name, _)) = named("duplicate field `") {
        return (Some(name.to_owned()), "the field stands twice".into());
    }
    (None, reworded(message).unwrap_or_else(|| message.to_owned()))
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

fn reworded(message: &str) -> Option<String> {
    if message.starts_with("number out of range") {
        return Some("the number is beyond double precision (about 1.8e308)".into());
    }
    if message == "expected value" {
        // all that serde_json says when one of several names is wanted and no string stands there
        return Some("expected one of the names that are offered here, in quotes".into());
    }
    if message.starts_with("UUID parsing failed") {
        return Some(format!("expected {UUID}"));
    }
    if let Some(rest) = message.strip_prefix("unknown variant `") {
        let (got, known) = rest.split_once("`, expected ")?;
        return Some(format!("`{}` is not known; expected {known}", shortened(got)));
    }
    if let Some(rest) = message.strip_prefix("invalid length ") {
        let (got, wanted) = rest.split_once(", expected ")?;
        return Some(format!("expected {}, found {}", expected(wanted), entries(got.parse().ok()?)));
    }
    let rest = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "))?;
    let (got, wanted) = rest.rsplit_once(", expected ")?;
    let wanted = expected(wanted);
    let found = found(got, wanted.contains("whole number"));
    Some(format!("expected {wanted}, found {found}"))
}

/// What is wanted.
fn expected(wanted: &str) -> Cow<'_, str> {
    match wanted {
        "usize" | "u64" => "a whole number of at least 0".into(),
        "u32" => "a whole number from 0 to 4294967295".into(),
        "u8" => "a whole number from 0 to 255".into(),
        "f64" => "a number".into(),
        "a sequence" => "an array".into(),
        "a map" => "an object".into(),
        "a formatted UUID string" => UUID.into(),
        // serde calls any type for which it has no words by its Rust name
        other if other.starts_with("struct ") => "an object".into(),
        other => match other.strip_prefix("an array of length ") {
            Some(length) => format!("an array of {length} entries").into(),
            None => other.into(),
        },
    }
}

/// What stands there instead.
fn found(got: &str, whole: bool) -> String {
    let quoted = |prefix: &str| got.strip_prefix(prefix)?.strip_suffix('`');
    if let Some(number) = quoted("floating point `").and_then(|digits| digits.parse::<f64>().ok()) {
        return if whole && number.fract() == 0.0 {
            format!("{} written with a decimal point, with an exponent or with too many digits", Shown(number))
        } else {
            Shown(number).to_string()
        };
    }
    if let Some(number) = quoted("integer `").or_else(|| quoted("boolean `")) {
        return number.to_owned();
    }
    if let Some(text) = got.strip_prefix("string ") {
        return format!("the string {}", shortened(text));
    }
    match got {
        "sequence" => "an array".into(),
        "map" => "an object".into(),
        other => shortened(other).into_owned(),
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

    use super::*;

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
        explain(&serde_json::from_str::<T>(text).unwrap_err().to_string()).1
    }

    #[test]
    fn no_type_of_rust_is_named() {
        const WHOLE: &str = "expected a whole number of at least 0, found ";
        assert_eq!(said::<usize>("-3"), format!("{WHOLE}-3"));
        assert_eq!(said::<u64>("1.5"), format!("{WHOLE}1.5"));
        assert!(said::<usize>("1e9").starts_with(&format!("{WHOLE}1000000000 written with")));
        assert!(said::<u64>("1e300").starts_with(&format!("{WHOLE}1e300 written with")));
        assert_eq!(said::<u32>("4294967296"), "expected a whole number from 0 to 4294967295, found 4294967296");
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
        assert_eq!(said::<uuid::Uuid>("5"), format!("expected {UUID}, found 5"));
        assert_eq!(said::<uuid::Uuid>("\"fit 1\""), format!("expected {UUID}"));
        assert_eq!(said::<Name>("5"), "expected one of the names that are offered here, in quotes");
    }

    #[test]
    fn fields_are_named() {
        let said = |text: &str| explain(&serde_json::from_str::<Pair>(text).unwrap_err().to_string());
        assert_eq!(said("{}"), (Some("a".into()), "missing".into()));
        assert_eq!(said(r#"{"a":1,"a":2}"#), (Some("a".into()), "the field stands twice".into()));
        let nothing = explain(&serde_json::from_str::<Nothing>(r#"{"b":1}"#).unwrap_err().to_string());
        assert_eq!(nothing, (Some("b".into()), "there is no such field; expected none".into()));
        assert_eq!(said(r#"{"b`c":1}"#), (Some("b`c".into()), "there is no such field; expected `a`".into()));
    }

    #[test]
    fn a_long_text_is_not_repeated() {
        let said = said::<f64>(&format!("{:?}", "ä".repeat(100_000)));
        assert!(said.starts_with("expected a number, found the string") && said.chars().count() < 120, "{said}");
    }
}
