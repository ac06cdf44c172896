//! Gathers the warnings of an answer's parts into the list of the answer itself, so that a client
//! finds all of them in one place.
//!
//! The answer is scanned once, as text: parts are finished JSON already.

use std::{collections::HashSet, ops::Range};

use memchr::memmem;

use super::{
    cursor::{Cursor, Syntax, Token},
    location::Location,
};

/// Members with content of the caller, which contain no warnings.
const GIVEN: [&str; 4] = ["request", "spec", "gear", "axes"];
/// Start of the member `at`, which names the part of a gathered warning. It is the last member.
const AT: &[u8] = b",\"at\":\"";

/// Returns the answer with every warning of its parts in its outermost `warnings`, each with `at`,
/// the JSON Pointer of the part. The list is added if there are such warnings and it is missing.
pub fn gathered(answer: Vec<u8>) -> Vec<u8> {
    if memmem::find(&answer, br#""warnings":[{"#).is_none() {
        return answer;
    }
    let mut scan = Scan::default();
    if scan.value(&mut Cursor::new(&answer), &Location::Root).is_err() {
        return answer;
    }
    let Scan { mut found, own } = scan;
    // the answer's own warnings first, wherever their list is
    found.sort_by_key(|(list, _)| !list.is_empty());
    let mut known = HashSet::new();
    let mut more: Vec<u8> = Vec::new();
    for (list, entry) in found {
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

/// Returns the warnings of parts as a list, each with `at`: the pointer of its part. Of each part
/// the last list `warnings` is its own, and no other part has one.
pub fn listed<'a>(parts: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let mut all = String::from("[");
    for (at, part) in parts {
        let Some(place) = memmem::rfind(part.as_bytes(), br#""warnings":[{"#) else { continue };
        let mut cursor = Cursor::new(part.as_bytes());
        cursor.at = place + br#""warnings":"#.len();
        let read = cursor.array(|cursor, _| {
            let (said, place) = placed(cursor.skip_value()?, at);
            let comma = if all.len() > 1 { "," } else { "" };
            all.extend([comma, &String::from_utf8_lossy(said), ",\"at\":\"", &place, "\"}"]);
            Ok(())
        });
        debug_assert!(read.is_ok(), "{part}");
    }
    all + "]"
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

/// The result of a scan.
#[derive(Default)]
struct Scan<'a> {
    /// Each warning, with the pointer of the object whose list contains it.
    found: Vec<(String, &'a [u8])>,
    /// Content of the outermost object's own list, without the brackets.
    own: Option<Range<usize>>,
}

impl<'a> Scan<'a> {
    fn value(&mut self, cursor: &mut Cursor<'a>, at: &Location) -> Result<(), Syntax> {
        match cursor.token()? {
            Token::Object => cursor.object(|cursor, key| match &*key {
                key if GIVEN.contains(&key) => cursor.skip_value().map(drop),
                "warnings" if cursor.token()? == Token::Array => self.warnings(cursor, at),
                key => self.value(cursor, &Location::Member(at, key)),
            }),
            Token::Array => cursor.array(|cursor, index| self.value(cursor, &Location::Entry(at, index))),
            _ => cursor.skip_value().map(drop),
        }
    }

    fn warnings(&mut self, cursor: &mut Cursor<'a>, at: &Location) -> Result<(), Syntax> {
        let start = cursor.at + 1;
        cursor.array(|cursor, _| {
            let is_object = cursor.token()? == Token::Object;
            let entry = cursor.skip_value()?;
            self.found.extend(is_object.then(|| (at.pointer(), entry)));
            Ok(())
        })?;
        if let Location::Root = at {
            self.own = Some(start..cursor.at - 1);
        }
        Ok(())
    }
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
    fn own_lists_of_parts_are_gathered_as_from_the_whole() {
        let result = r#"{"n":[1,2],"warnings":[{"code":"x","params":{"k":["]"]}},{"code":"y"}],"end":{}}"#;
        let figures = r#"{"warnings":[{"code":"z","at":"/slope"}]}"#;
        let empty = r#"{"note":"\"warnings\":[{","warnings":[]}"#;
        let list = listed([("/a", figures), ("/b", empty), ("/c/0", result)]);
        let whole = of(&format!(r#"{{"warnings":[],"a":{figures},"b":{empty},"c":[{result}]}}"#));
        assert!(whole.starts_with(&format!(r#"{{"warnings":{list},"a""#)), "{whole} {list}");
        assert_eq!(listed([("/b", empty)]), "[]");
    }

    #[test]
    fn warnings_gathered_in_a_part_are_not_gathered_twice() {
        let part = of(r#"{"warnings":[{"code":"own"}],"result":{"warnings":[{"code":"x"}]}}"#);
        let all = of(&format!(r#"{{"result":{part}}}"#));
        let list = r#""warnings":[{"code":"own","at":"/result"},{"code":"x","at":"/result/result"}]"#;
        assert_eq!(all, format!(r#"{{"result":{part},{list}}}"#));
        // also if the part of a part is missing
        let rest = r#"{"warnings":[{"code":"own"},{"code":"x","at":"/result"}]}"#;
        assert_eq!(of(&format!(r#"{{"result":{rest}}}"#)), format!(r#"{{"result":{rest},{list}}}"#));
    }

    #[test]
    fn empty_and_echoed_warnings_are_left_unchanged() {
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
