//! Every fault of what serde reads.
//!
//! A visitor stops at the first value that it refuses, and what it had read is lost with it; serde
//! has no way to go on from there. So the text is read again and again, each time without what was
//! refused so far, and with something that stands in where a field is missing. What is read this
//! way is never used, only what is refused of it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::{
    location::Location,
    reader::read,
    refusal::{Refusal, Wrong},
};
use crate::api::faults::{Fault, Faults};

/// Texts beyond this get their first fault only: they would be read many times.
const SMALL: usize = 16 * 1024;

/// The faults of a text that come after `first`.
pub fn further<'de, T: Deserialize<'de>>(text: &'de [u8], first: &Refusal) -> Vec<Fault> {
    let mut faults = Vec::new();
    if text.len() > SMALL {
        return faults;
    }
    let mut mended = Mended::default();
    let mut refusal = first.clone();
    while faults.len() < Faults::MOST && mended.mend(&refusal) {
        let Err(next) = read::<T>(text, Some(&mended)) else { break };
        if !mended.caused(&next) {
            faults.push(next.clone().into_fault());
        }
        refusal = next;
    }
    faults
}

/// What of a text is read otherwise than it stands there, by JSON Pointers.
#[derive(Debug, Default)]
pub struct Mended {
    /// Fields and entries that are passed over.
    left_out: BTreeSet<String>,
    /// Arrays with such entries.
    shortened: BTreeSet<String>,
    /// Fields of which only the first is read.
    once: BTreeSet<String>,
    /// By their objects: fields that are missing.
    added: BTreeMap<String, Vec<String>>,
}

impl Mended {
    pub fn leaves_out(&self, location: &Location) -> bool {
        self.left_out.contains(&location.pointer())
    }

    pub fn has_once(&self, location: &Location) -> bool {
        self.once.contains(&location.pointer())
    }

    /// Fields that are to be read of the object at `location` although it has none of them.
    pub fn added(&self, location: &Location) -> &[String] {
        self.added.get(&location.pointer()).map_or(&[], Vec::as_slice)
    }

    /// Whether only a repaired part is refused: a stand-in, a field that was left out, an array
    /// that has become too short.
    fn caused(&self, refusal: &Refusal) -> bool {
        let pointer = refusal.pointer();
        refusal.is_of_stand_in()
            || match refusal.wrong() {
                Wrong::Missing(_) => self.left_out.contains(pointer),
                Wrong::Value => self.shortened.contains(pointer),
                Wrong::Unknown(_) | Wrong::Twice(_) => false,
            }
    }

    /// Has what is refused read otherwise. `false` where nothing is left to be done.
    fn mend(&mut self, refusal: &Refusal) -> bool {
        let pointer = refusal.pointer();
        let Some((parent, key)) = pointer.rsplit_once('/') else { return false };
        if refusal.is_of_stand_in() {
            return self.leave_out(parent);
        }
        match refusal.wrong() {
            Wrong::Value | Wrong::Unknown(_) => self.leave_out(pointer),
            Wrong::Twice(_) => self.once.insert(pointer.to_owned()),
            Wrong::Missing(name) => {
                let fields = self.added.entry(parent.to_owned()).or_default();
                let new = !fields.iter().any(|there| there == name) && !key.is_empty();
                if new {
                    fields.push((*name).to_owned());
                }
                new
            }
        }
    }

    fn leave_out(&mut self, pointer: &str) -> bool {
        let Some((parent, key)) = pointer.rsplit_once('/') else { return false };
        if key.bytes().all(|byte| byte.is_ascii_digit()) {
            self.shortened.insert(parent.to_owned());
        }
        self.left_out.insert(pointer.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;

    use super::*;
    use crate::api::{gears::design::profile::ToolMotionBody, jobs::job::NewJobBody, json::wording::OBJECT_WANTED};

    /// The first as serde met it, the others sorted.
    fn of<T: DeserializeOwned>(text: &str) -> Vec<String> {
        let first = read::<T>(text.as_bytes(), None).err().unwrap();
        let mut found: Vec<String> = further::<T>(text.as_bytes(), &first).into_iter().map(|f| f.pointer).collect();
        found.sort_unstable();
        found.insert(0, first.into_fault().pointer);
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
            pointers(&format!(r#"{{"name":5,"gear":{gear},"machine":1}}"#)),
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
    fn the_type_of_a_union_is_a_name() {
        let of = |text: &str| of::<ToolMotionBody>(text);
        for wrong in ["0", "1", "2.5", "true", "[]", r#"["rack"]"#, r#"{"rack":1}"#, r#""worm""#] {
            assert_eq!(of(&format!(r#"{{"type":{wrong},"pitch_radius_mm":26}}"#)), ["/type"], "{wrong}");
        }
        assert_eq!(of("{}"), ["/type"]);
        // fields of a union of which nobody knows which one it is are not called unknown
        assert_eq!(of(r#"{"pitch_radius_mm":26,"internal":true}"#), ["/type"]);
        for array in ["[]", "[0]", "[0,26]", r#"["rack",26]"#, r#"["rack",{"pitch_radius_mm":26}]"#, "[[]]"] {
            let refusal = read::<ToolMotionBody>(array.as_bytes(), None).err().unwrap();
            assert_eq!(refusal.to_string(), OBJECT_WANTED, "{array}");
            assert_eq!(of(array), [""], "{array}");
        }
        assert_eq!(read::<ToolMotionBody>(b"1", None).err().unwrap().to_string(), "expected an object, found 1");
        let two = r#"[{"type":1,"pitch_radius_mm":26},["rack",26],{"pitch_radius_mm":26},{"type":"rack"}]"#;
        assert_eq!(super::tests::of::<Vec<ToolMotionBody>>(two), ["/0/type", "/1", "/2/type", "/3/pitch_radius_mm"]);
    }

    #[test]
    fn it_ends_whatever_is_sent() {
        let many: String = (0..500).map(|i| format!(r#","k{i}":1"#)).collect();
        assert_eq!(pointers(&format!(r#"{{"name":1{many}}}"#)).len(), Faults::MOST + 1);
        assert_eq!(pointers(&format!(r#"{{"name":1,"gear":2,"machine":"{}"}}"#, "x".repeat(SMALL))).len(), 1);
    }
}
