//! Messages about wrong values in the words of the contract: no type of Rust, and no long text of
//! the caller.

use std::borrow::Cow;

use super::nearest::nearest;

/// Characters of the caller's text that a message repeats.
const REPEATED: usize = 64;

/// Message for a number that no double holds.
pub const BEYOND: &str = "the number exceeds the range of double precision (about 1.8e308)";

/// Returns the message on a name that is none of those known.
pub fn unknown_name(name: &str, known: &[&str]) -> String {
    let near = nearest(name, known.iter().copied()).filter(|_| known.len() > 2);
    let meant = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
    format!("`{}` is not known; expected {}{meant}", shortened(name), one_of(known))
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

/// Returns the message for an unknown field.
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

/// Returns the beginning of a text of the caller.
pub fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(REPEATED) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}
