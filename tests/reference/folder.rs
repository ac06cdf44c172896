//! Reading the reference files.

use crate::oracle::big::Big;
use serde_json::Value;
use std::io::Write;
use std::path::Path;

/// The file `name.json`, or `None` (said aloud) where there is no folder of references. A folder without the file
/// is a fault.
pub fn reference(name: &str) -> Option<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/refdata");
    if !folder.is_dir() {
        // Past the capture of the test harness, so that it is seen when the test passes.
        let line = format!("SKIPPED {name}: there is no folder ../shared/refdata beside this checkout\n");
        std::io::stderr().write_all(line.as_bytes()).expect("standard error");
        return None;
    }
    let path = folder.join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Some(serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value} is not an array")).iter().map(number).collect()
}

pub fn table(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap_or_else(|| panic!("{value} is not an array")).iter().map(numbers).collect()
}

/// Decimal texts, with all their digits.
pub fn decimals(value: &Value) -> Vec<Big> {
    let text = |v: &Value| Big::parse(v.as_str().unwrap_or_else(|| panic!("{v} is not a text")));
    value.as_array().unwrap_or_else(|| panic!("{value} is not an array")).iter().map(text).collect()
}
