//! Curves and surfaces over real HTTP.

mod curves;
mod evaluate;
mod export;
mod fitted;
mod kept;
mod sections;
mod surfaces;

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::Value;

/// The documented examples of an operation, with their names.
pub fn examples(operation: &str) -> Vec<(&'static str, Value)> {
    let of_operation = REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == operation);
    let examples: Vec<_> =
        of_operation.map(|example| (example.name, serde_json::from_str(example.text).unwrap())).collect();
    assert!(!examples.is_empty(), "{operation} has no example");
    examples
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value}")).iter().map(|x| x.as_f64().unwrap()).collect()
}

#[track_caller]
pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}
