//! Every fault of a small body.
//!
//! serde stops at the first fault. So what is wrong is taken out of the body and the rest is read again; where something is
//! missing, anything that passes stands in for it. What is read this way is never used, only what is wrong with it.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::request::read_object;
use crate::estimation::{Fault, Faults};

/// Bodies beyond this get their first fault only: they would be read many times.
const SMALL: usize = 16 * 1024;

/// Adds the faults of `text` that come after the first, which `faults` holds.
pub fn add_further<T: DeserializeOwned>(text: &[u8], faults: &mut Faults) {
    let [first] = faults.list() else { return };
    let Some(mut body) = (text.len() <= SMALL).then(|| serde_json::from_slice::<Value>(text).ok()).flatten() else {
        return;
    };
    let mut fault = first.clone();
    // how often something was tried at a place
    let mut tried = BTreeMap::<String, usize>::new();
    while faults.count() < Faults::MOST && settle(&mut body, &fault.pointer, &mut tried) {
        let Some(next) = fault_of::<T>(&body) else { return };
        // what a stand-in lacks is no fault of the request
        let of_stand_in = tried.keys().any(|place| {
            let rest = next.pointer.strip_prefix(place.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        });
        if !of_stand_in {
            faults.push(next.pointer.clone(), next.detail.clone());
        }
        fault = next;
    }
}

fn fault_of<T: DeserializeOwned>(body: &Value) -> Option<Fault> {
    let text = serde_json::to_vec(body).ok()?;
    let mut faults = Faults::default();
    read_object::<T>(&text, "", &mut faults);
    faults.list().first().cloned()
}

/// Takes what is at fault out of the body; where that is missing then, puts in one value after the other; in the end takes out what
/// it belongs to. `false` where nothing is left to be done.
fn settle(body: &mut Value, pointer: &str, tried: &mut BTreeMap<String, usize>) -> bool {
    let stand_ins = [json!(1), json!("x"), json!([]), json!({})];
    let Some((parent, key)) = pointer.rsplit_once('/') else { return false };
    let times = tried.entry(pointer.to_owned()).or_default();
    *times += 1;
    let times = *times;
    match body.pointer_mut(parent) {
        Some(Value::Object(fields)) if times <= stand_ins.len() + 1 => {
            let key = key.replace("~1", "/").replace("~0", "~");
            match times {
                1 => fields.remove(&key),
                _ => fields.insert(key, stand_ins[times - 2].clone()),
            };
            true
        }
        // an entry of an array, or nothing fits: the whole
        _ => settle(body, parent, tried),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::jobs::NewJobBody;

    /// The first as serde met it, the others sorted.
    fn pointers(text: &str) -> Vec<String> {
        let mut faults = Faults::default();
        assert!(read_object::<NewJobBody>(text.as_bytes(), "", &mut faults).is_none());
        add_further::<NewJobBody>(text.as_bytes(), &mut faults);
        let mut found: Vec<String> = faults.list().iter().map(|fault| fault.pointer.clone()).collect();
        found[1..].sort_unstable();
        found
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
    }

    #[test]
    fn it_ends_whatever_is_sent() {
        let many: String = (0..500).map(|i| format!(r#","k{i}":1"#)).collect();
        assert_eq!(pointers(&format!(r#"{{"name":1{many}}}"#)).len(), Faults::MOST);
        assert_eq!(pointers(&format!(r#"{{"name":1,"gear":2,"machine":"{}"}}"#, "x".repeat(SMALL))).len(), 1);
    }
}
