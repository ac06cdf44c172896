//! Every fault of what serde reads.
//!
//! serde stops at the first fault. So what is wrong is taken out of the text and the rest is read
//! again; where something is missing, anything that passes stands in for it. What is read this way
//! is never used, only what is wrong with it.

use std::collections::{BTreeMap, BTreeSet};

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::{
    cursor::{Cursor, Syntax, Token},
    part::first_fault,
    pointer::escape,
};
use crate::api::faults::{Fault, Faults};

/// Texts beyond this get their first fault only: they would be read many times.
const SMALL: usize = 16 * 1024;

/// The faults of a text that come after `first`.
pub fn further<T: DeserializeOwned>(text: &[u8], first: &Fault) -> Vec<Fault> {
    let body = (text.len() <= SMALL).then(|| serde_json::from_slice::<Value>(text).ok()).flatten();
    let Some(body) = body else { return Vec::new() };
    let mut rest = Rest { body, tried: BTreeMap::new(), taken: BTreeMap::new() };
    let mut faults = Vec::new();
    // The text has been walked over before, so that nothing can be wrong with it.
    let _ = doubles(&mut Cursor::new(text), &mut String::new(), &mut faults);
    faults.retain(|double| double != first);
    let mut pointer = first.pointer.clone();
    while faults.len() < Faults::MOST && rest.settle(&pointer) {
        let Some(next) = rest.fault::<T>() else { break };
        let place = rest.place(&next.pointer);
        if !rest.is_own_doing(&place) {
            faults.push(Fault { pointer: place, detail: next.detail });
        }
        pointer = next.pointer;
    }
    faults
}

/// Fields that stand twice: serde may never come to the second, and what is read again has one of
/// them.
fn doubles(cursor: &mut Cursor, place: &mut String, found: &mut Vec<Fault>) -> Result<(), Syntax> {
    let length = place.len();
    match cursor.token()? {
        Token::Object => {
            let mut seen = BTreeSet::new();
            cursor.object(|cursor, key| {
                place.extend(["/", &escape(&key)]);
                if !seen.insert(key.into_owned()) && found.last().is_none_or(|last| last.pointer != *place) {
                    found.push(Fault { pointer: place.clone(), detail: "the field stands twice".to_owned() });
                }
                doubles(cursor, place, found)?;
                place.truncate(length);
                Ok(())
            })
        }
        Token::Array => cursor.array(|cursor, i| {
            place.push_str(&format!("/{i}"));
            doubles(cursor, place, found)?;
            place.truncate(length);
            Ok(())
        }),
        _ => cursor.skip_value().map(drop),
    }
}

/// What is left of a text. Places are pointers into it as it came.
struct Rest {
    body: Value,
    /// How often something was tried at a place.
    tried: BTreeMap<String, usize>,
    /// Which entries were taken out of the array at a place, ascending.
    taken: BTreeMap<String, Vec<usize>>,
}

impl Rest {
    fn fault<T: DeserializeOwned>(&self) -> Option<Fault> {
        first_fault::<T>(&serde_json::to_vec(&self.body).ok()?)
    }

    /// Where a pointer into what is left pointed before entries were taken out.
    fn place(&self, pointer: &str) -> String {
        let mut place = String::new();
        for part in pointer.split('/').skip(1) {
            let entry = self.taken.get(&place).zip(part.parse::<usize>().ok());
            let entry = entry.map(|(taken, k)| taken.iter().fold(k, |k, gone| if *gone <= k { k + 1 } else { k }));
            match entry {
                Some(entry) => place.push_str(&format!("/{entry}")),
                None => place.extend(["/", part]),
            }
        }
        place
    }

    /// What a stand-in lacks is no fault of the request, nor is it that an array has become too
    /// short.
    fn is_own_doing(&self, place: &str) -> bool {
        let within = |stand_in: &String| {
            let rest = place.strip_prefix(stand_in.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.tried.keys().any(within) || self.taken.contains_key(place)
    }

    /// Takes out what is at fault; where that is missing then, puts in one value after the other;
    /// in the end takes out what it belongs to. `false` where nothing is left to be done.
    fn settle(&mut self, pointer: &str) -> bool {
        let stand_ins = [json!(1), json!("x"), json!([]), json!({})];
        let Some((parent, key)) = pointer.rsplit_once('/') else { return false };
        let (place, array) = (self.place(pointer), self.place(parent));
        match self.body.pointer_mut(parent) {
            Some(Value::Object(fields)) => {
                let times = self.tried.entry(place).or_default();
                *times += 1;
                let key = key.replace("~1", "/").replace("~0", "~");
                match *times {
                    1 => drop(fields.remove(&key)),
                    times if times <= stand_ins.len() + 1 => drop(fields.insert(key, stand_ins[times - 2].clone())),
                    _ => return self.settle(parent),
                }
                true
            }
            Some(Value::Array(entries)) if key.parse().is_ok_and(|k: usize| k < entries.len()) => {
                let entry = place.rsplit('/').next().and_then(|entry| entry.parse().ok()).unwrap_or(0);
                entries.remove(key.parse().unwrap_or(0));
                let taken = self.taken.entry(array).or_default();
                taken.insert(taken.partition_point(|gone| *gone < entry), entry);
                true
            }
            _ => self.settle(parent),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::jobs::job::NewJobBody;

    /// The first as serde met it, the others sorted.
    fn of<T: DeserializeOwned>(text: &str) -> Vec<String> {
        let first = first_fault::<T>(text.as_bytes()).unwrap();
        let mut found: Vec<String> = further::<T>(text.as_bytes(), &first).into_iter().map(|f| f.pointer).collect();
        found.sort_unstable();
        found.insert(0, first.pointer);
        found
    }

    fn pointers(text: &str) -> Vec<String> {
        of::<NewJobBody>(text)
    }

    #[test]
    fn every_fault_is_found_once() {
        assert_eq!(pointers("[]"), [""]);
        assert_eq!(pointers("{}"), ["/name"]);
        assert_eq!(pointers(r#"{"name":"w","gear":[]}"#), ["/gear"]);
        let gear = r#"{"teeth":0,"helix_angle_deg":91,"tool":{"tip_radius_mm":-1},"x/y":1}"#;
        assert_eq!(
            pointers(&format!(r#"{{"name":5,"gear":{gear},"machine":null}}"#)),
            [
                "/name",
                "/gear/helix_angle_deg",
                "/gear/normal_module_mm",
                "/gear/teeth",
                "/gear/tool/tip_radius_mm",
                "/gear/x~1y",
                "/machine",
            ]
        );
        assert_eq!(
            pointers(r#"{"gear":{},"tags":{"a":1,"b":"x","c":2}}"#),
            ["/gear/teeth", "/gear/normal_module_mm", "/name", "/tags/a", "/tags/c"]
        );
        assert_eq!(pointers(r#"{"name":"w","name":"v","gear":7}"#), ["/name", "/gear"]);
        // the first of two may be wrong by itself
        assert_eq!(pointers(r#"{"name":5,"name":"v","gear":7}"#), ["/name", "/gear", "/name"]);
        assert_eq!(
            pointers(r#"{"gear":{"teeth":0,"teeth":20,"normal_module_mm":1}}"#),
            ["/gear/teeth", "/gear/teeth", "/name"]
        );
    }

    #[test]
    fn entries_of_arrays_are_named_by_the_places_that_they_have() {
        assert_eq!(of::<Vec<u8>>(r#"["a",1,2,"b",3,-1,"c"]"#), ["/0", "/3", "/5", "/6"]);
        assert_eq!(of::<Vec<Vec<bool>>>("[[true,1],[2],[true],7,[1,true,0]]"), ["/0/1", "/1/0", "/3", "/4/0", "/4/2"]);
        // what is as long as it must be is not called too short for what was taken out of it
        assert_eq!(of::<Vec<[u8; 2]>>(r#"[["a",1],[1,2],[1],["b","c"]]"#), ["/0/0", "/2", "/3/0", "/3/1"]);
        assert_eq!(pointers(r#"{"name":1,"tags":{"a":[1]},"gear":{"teeth":[]}}"#)[0], "/name");
    }

    #[test]
    fn it_ends_whatever_is_sent() {
        let many: String = (0..500).map(|i| format!(r#","k{i}":1"#)).collect();
        assert_eq!(pointers(&format!(r#"{{"name":1{many}}}"#)).len(), Faults::MOST + 1);
        assert_eq!(pointers(&format!(r#"{{"name":1,"gear":2,"machine":"{}"}}"#, "x".repeat(SMALL))).len(), 1);
    }
}
