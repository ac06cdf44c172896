//! Reading the reference files.

use crate::oracle::big::Big;
use serde_json::Value;
use std::path::Path;

/// The file `tests/refdata/name.json`.
pub fn reference(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/refdata").join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
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
