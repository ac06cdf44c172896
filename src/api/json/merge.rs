//! Adds to finished JSON the further members of another text. The rest stays byte for byte.

use std::{borrow::Cow, fmt};

use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, Visitor},
};
use serde_json::value::RawValue;

/// `text` with the members of objects that only `more` has, in the order of `more`; lists of
/// objects of one length are merged entry by entry. Lists that are outermost members by the names
/// in `growing` have behind their own entries those of `more` that they have not.
pub fn added(text: &str, more: &str, growing: &[&str]) -> Result<String, serde_json::Error> {
    let mut merged = String::with_capacity(text.len().max(more.len()));
    add(text, more, growing, &mut merged)?;
    Ok(merged)
}

fn add(text: &str, more: &str, growing: &[&str], out: &mut String) -> Result<(), serde_json::Error> {
    match (text.as_bytes().first(), more.as_bytes().first()) {
        (Some(b'{'), Some(b'{')) => {
            let (text, more): (Members<'_>, Members<'_>) = (serde_json::from_str(text)?, serde_json::from_str(more)?);
            out.push('{');
            for (key, value) in &more.0 {
                member(key, out)?;
                match text.get(key) {
                    Some(there) if growing.contains(&key.as_ref()) => grow(there, value.get(), out)?,
                    Some(there) => add(there, value.get(), &[], out)?,
                    None => out.push_str(value.get()),
                }
            }
            for (key, value) in text.0.iter().filter(|(key, _)| more.get(key).is_none()) {
                member(key, out)?;
                out.push_str(value.get());
            }
            out.push('}');
        }
        (Some(b'['), Some(b'[')) if text.as_bytes().get(1) == Some(&b'{') => {
            let list: Vec<&RawValue> = serde_json::from_str(text)?;
            let other: Vec<&RawValue> = serde_json::from_str(more)?;
            if list.len() != other.len() {
                out.push_str(text);
                return Ok(());
            }
            for (k, (entry, other)) in list.iter().zip(&other).enumerate() {
                out.push(if k == 0 { '[' } else { ',' });
                add(entry.get(), other.get(), &[], out)?;
            }
            out.push(']');
        }
        _ => out.push_str(text),
    }
    Ok(())
}

fn grow(text: &str, more: &str, out: &mut String) -> Result<(), serde_json::Error> {
    let list: Vec<&RawValue> = serde_json::from_str(text)?;
    let other: Vec<&RawValue> = serde_json::from_str(more)?;
    let new = other.iter().filter(|entry| list.iter().all(|there| there.get() != entry.get()));
    out.push('[');
    for (k, entry) in list.iter().chain(new).enumerate() {
        if k > 0 {
            out.push(',');
        }
        out.push_str(entry.get());
    }
    out.push(']');
    Ok(())
}

/// The comma before it where there is one before it, and the key.
fn member(key: &str, out: &mut String) -> Result<(), serde_json::Error> {
    if !out.ends_with('{') {
        out.push(',');
    }
    out.push_str(&serde_json::to_string(key)?);
    out.push(':');
    Ok(())
}

/// The members of an object in their order.
struct Members<'a>(Vec<(Cow<'a, str>, &'a RawValue)>);

impl Members<'_> {
    fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| value.get())
    }
}

impl<'de> Deserialize<'de> for Members<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = Members<'de>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Members<'de>, A::Error> {
                let mut members = Vec::new();
                while let Some(Key(key)) = map.next_key()? {
                    members.push((key, map.next_value()?));
                }
                Ok(Members(members))
            }
        }

        deserializer.deserialize_map(Read)
    }
}

#[derive(Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_added_and_nothing_is_changed() {
        let text = r#"{"a":1.50,"b":{"c":[1,2]},"d":[{"e":1},{"e":2}],"f":[],"old":0}"#;
        let more = r#"{"a":9,"new":[3],"b":{"c":[7],"g":"h"},"d":[{"e":5,"w":[1]},{"e":6,"w":[2]}],"f":[{"x":1}]}"#;
        let merged =
            r#"{"a":1.50,"new":[3],"b":{"c":[1,2],"g":"h"},"d":[{"e":1,"w":[1]},{"e":2,"w":[2]}],"f":[],"old":0}"#;
        assert_eq!(added(text, more, &[]).unwrap(), merged);
        assert_eq!(added(text, text, &[]).unwrap(), text);
        assert_eq!(added(r#"{"d":[{"e":1}]}"#, r#"{"d":[]}"#, &[]).unwrap(), r#"{"d":[{"e":1}]}"#);
        assert_eq!(added("{}", r#"{"a\"b":{}}"#, &[]).unwrap(), r#"{"a\"b":{}}"#);
        assert_eq!(added("{}", "{}", &[]).unwrap(), "{}");
    }

    #[test]
    fn growing_lists_get_the_entries_that_they_have_not() {
        let text = r#"{"w":[{"c":"a"},{"c":"b"}],"x":{"w":[{"c":1}]}}"#;
        let more = r#"{"w":[{"c":"b"},{"c":"d","n":2}],"x":{"w":[{"c":1},{"c":2}]}}"#;
        let grown = r#"{"w":[{"c":"a"},{"c":"b"},{"c":"d","n":2}],"x":{"w":[{"c":1}]}}"#;
        assert_eq!(added(text, more, &["w"]).unwrap(), grown);
        assert_eq!(added(grown, more, &["w"]).unwrap(), grown);
        assert_eq!(added(r#"{"w":[]}"#, r#"{"w":[{"c":1}]}"#, &["w"]).unwrap(), r#"{"w":[{"c":1}]}"#);
        assert_eq!(added(r#"{"w":[]}"#, r#"{"w":[]}"#, &["w"]).unwrap(), r#"{"w":[]}"#);
    }
}
