//! Gathers the warnings of an answer's parts into the list of the answer itself, so that a client
//! finds all of them in one place.
//!
//! The answer is scanned once, as text: parts are finished JSON already.

use std::{collections::HashSet, ops::Range};

/// Members with content of the caller, which contain no warnings.
const GIVEN: [&[u8]; 4] = [b"request", b"spec", b"gear", b"axes"];
const WARNINGS: &[u8] = b"warnings";
/// Start of the member `at`, which names the part of a gathered warning. It is the last member.
const AT: &[u8] = b",\"at\":\"";

/// Returns the answer with every warning of its parts in its outermost `warnings`, each with `at`,
/// the JSON Pointer of the part. The list is added if there are such warnings and it is missing.
pub fn gathered(answer: Vec<u8>) -> Vec<u8> {
    let Scan { mut found, own } = Scan::of(&answer);
    // the answer's own warnings first, wherever their list is
    found.sort_by_key(|warning| !warning.list.is_empty());
    let mut known = HashSet::new();
    let mut more: Vec<u8> = Vec::new();
    for Found { list, entry } in found {
        let entry = answer.get(entry).unwrap_or_default();
        let (said, at) = placed(entry, &list);
        // a warning that a part has gathered itself is also found in the inner part
        if !known.insert((said, at.clone())) || list.is_empty() {
            continue;
        }
        for part in [if more.is_empty() { &b""[..] } else { &b","[..] }, said, AT, at.as_bytes(), b"\"}"] {
            more.extend_from_slice(part);
        }
    }
    if more.is_empty() {
        return answer;
    }
    let (end, before, after): (usize, &[u8], &[u8]) = match own {
        Some(list) => (list.end, if list.is_empty() { &b""[..] } else { &b","[..] }, b""),
        None => (answer.len().saturating_sub(1), b",\"warnings\":[", b"]"),
    };
    let (begin, rest) = answer.split_at(end);
    [begin, before, &more, after, rest].concat()
}

/// Splits a warning into its text without closing bracket and `at`, and the pointer of its part
/// from the outermost object; `list` is the pointer of the list it was found in.
fn placed<'a>(entry: &'a [u8], list: &str) -> (&'a [u8], String) {
    match entry.windows(AT.len()).rposition(|part| part == AT) {
        Some(place) => {
            let at = entry.get(place + AT.len()..entry.len() - 2).unwrap_or_default();
            (entry.split_at(place).0, format!("{list}{}", String::from_utf8_lossy(at)))
        }
        None => (entry.strip_suffix(b"}").unwrap_or(entry), list.to_owned()),
    }
}

/// A warning: the pointer of the object whose list contains it, and the range of its text.
struct Found {
    list: String,
    entry: Range<usize>,
}

/// The result of a scan.
struct Scan {
    found: Vec<Found>,
    /// Content of the outermost object's own list, without the brackets.
    own: Option<Range<usize>>,
}

/// An enclosing object or list of the current position.
enum Level {
    Object {
        key: Range<usize>,
    },
    Array {
        index: usize,
    },
    /// A list of warnings, with the start of the current one.
    Warnings {
        start: usize,
    },
}

impl Scan {
    fn of(text: &[u8]) -> Scan {
        let mut scan = Scan { found: Vec::new(), own: None };
        let mut levels: Vec<Level> = Vec::new();
        let mut at = 0;
        // whether the next string is a key
        let mut before_key = false;
        while let Some(byte) = text.get(at) {
            match byte {
                b'"' => {
                    let end = end_of_string(text, at);
                    if before_key && let Some(Level::Object { key }) = levels.last_mut() {
                        *key = at + 1..end - 1;
                        before_key = false;
                    }
                    at = end;
                    continue;
                }
                b',' => match levels.last_mut() {
                    Some(Level::Object { .. }) => before_key = true,
                    Some(Level::Array { index }) => *index += 1,
                    Some(Level::Warnings { .. }) | None => {}
                },
                b'{' | b'[' if is_given(text, &levels) => {
                    at = end_of_value(text, at);
                    continue;
                }
                b'{' if matches!(levels.last(), Some(Level::Warnings { .. })) => {
                    let end = end_of_value(text, at);
                    scan.found.push(Found { list: pointer(text, &levels), entry: at..end });
                    at = end;
                    continue;
                }
                b'{' => {
                    levels.push(Level::Object { key: 0..0 });
                    before_key = true;
                }
                b'[' => levels.push(match levels.last() {
                    Some(Level::Object { key }) if text.get(key.clone()) == Some(WARNINGS) => {
                        Level::Warnings { start: at + 1 }
                    }
                    _ => Level::Array { index: 0 },
                }),
                b'}' | b']' => {
                    before_key = false;
                    if let Some(Level::Warnings { start }) = levels.pop()
                        && levels.len() == 1
                    {
                        scan.own = Some(start..at);
                    }
                }
                _ => {}
            }
            at += 1;
        }
        scan
    }
}

/// Whether the value that begins here was given by the caller.
fn is_given(text: &[u8], levels: &[Level]) -> bool {
    let Some(Level::Object { key }) = levels.last() else { return false };
    text.get(key.clone()).is_some_and(|key| GIVEN.contains(&key))
}

/// Returns the pointer of the object that has the innermost list.
fn pointer(text: &[u8], levels: &[Level]) -> String {
    let mut pointer = String::new();
    for level in levels {
        match level {
            Level::Object { key } if text.get(key.clone()) != Some(WARNINGS) => {
                pointer.push('/');
                let key = text.get(key.clone()).unwrap_or_default();
                pointer.push_str(&String::from_utf8_lossy(key).replace('~', "~0").replace('/', "~1"));
            }
            Level::Array { index } => pointer.push_str(&format!("/{index}")),
            Level::Object { .. } | Level::Warnings { .. } => {}
        }
    }
    pointer
}

/// Returns the position after the closing quotation mark of the string that begins at `at`.
fn end_of_string(text: &[u8], at: usize) -> usize {
    let mut at = at + 1;
    while let Some(byte) = text.get(at) {
        match byte {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    text.len()
}

/// Returns the position after the object or list that begins at `at`.
fn end_of_value(text: &[u8], at: usize) -> usize {
    let (mut at, mut depth) = (at, 0_usize);
    while let Some(byte) = text.get(at) {
        match byte {
            b'"' => {
                at = end_of_string(text, at);
                continue;
            }
            b'{' | b'[' => depth += 1,
            b'}' | b']' if depth == 1 => return at + 1,
            b'}' | b']' => depth -= 1,
            _ => {}
        }
        at += 1;
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> String {
        String::from_utf8(gathered(text.as_bytes().to_vec())).unwrap()
    }

    #[test]
    fn warnings_of_parts_are_gathered_with_their_places() {
        let text = r#"{"fits":[{"n":[1,2]},{"result":{"a":"]\"}","warnings":[{"code":"x","params":{"k":[1]}}]}}],"warnings":[{"code":"own"}]}"#;
        let own = r#"{"code":"own"},{"code":"x","params":{"k":[1]},"at":"/fits/1/result"}"#;
        let all = text.replace(r#"{"code":"own"}"#, own);
        assert_eq!(of(text), all);
        assert_eq!(of(&all), all, "once");
        // from two parts, into an empty list and into a missing one
        let parts = r#""left":{"warnings":[{"code":"a"},{"code":"b"}]},"right":{"warnings":[{"code":"a"}]}"#;
        let list = r#"[{"code":"a","at":"/left"},{"code":"b","at":"/left"},{"code":"a","at":"/right"}]"#;
        assert_eq!(of(&format!(r#"{{"warnings":[],{parts}}}"#)), format!(r#"{{"warnings":{list},{parts}}}"#));
        assert_eq!(of(&format!("{{{parts}}}")), format!(r#"{{{parts},"warnings":{list}}}"#));
    }

    #[test]
    fn what_is_gathered_in_a_part_is_gathered_once() {
        let part = of(r#"{"warnings":[{"code":"own"}],"result":{"warnings":[{"code":"x"}]}}"#);
        let all = of(&format!(r#"{{"result":{part}}}"#));
        let list = r#""warnings":[{"code":"own","at":"/result"},{"code":"x","at":"/result/result"}]"#;
        assert_eq!(all, format!(r#"{{"result":{part},{list}}}"#));
        // also if the part of a part is missing
        let rest = r#"{"warnings":[{"code":"own"},{"code":"x","at":"/result"}]}"#;
        assert_eq!(of(&format!(r#"{{"result":{rest}}}"#)), format!(r#"{{"result":{rest},{list}}}"#));
    }

    #[test]
    fn what_warns_of_nothing_and_what_was_asked_stay_as_they_are() {
        for text in [
            "{}",
            "[]",
            r#"{"warnings":[]}"#,
            r#"{"warnings":[{"code":"own"}],"x":{"warnings":[]}}"#,
            r#"{"request":{"warnings":[{"code":"x"}]},"spec":{"y":{"warnings":[{}]}},"warnings":[]}"#,
            r#"{"name":"\"warnings\":[{","warnings":["text"]}"#,
        ] {
            assert_eq!(of(text), text);
        }
    }
}
