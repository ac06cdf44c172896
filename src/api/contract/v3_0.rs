//! OpenAPI 3.1 to 3.0, for generators: what most of them do not read yet, and what they make wrong
//! code of.
//!
//! The differences in the parts that are used here: type arrays become `nullable`, `examples` of a
//! schema becomes `example`, `const` becomes a one-value `enum`, exclusive bounds become booleans
//! next to the bounds, and the licence identifier (3.1 only) is dropped.

use serde_json::{Map, Value, json};

use super::generators;

/// The 3.0 copy of a 3.1 document, pretty-printed.
pub fn convert(document: &str) -> Result<String, serde_json::Error> {
    let mut document: Value = serde_json::from_str(document)?;
    if let Some(root) = document.as_object_mut() {
        root.insert("openapi".into(), "3.0.3".into());
        root.remove("jsonSchemaDialect");
        root.remove("webhooks");
    }
    generators::spare(&mut document);
    if let Some(license) = document.pointer_mut("/info/license").and_then(Value::as_object_mut) {
        license.remove("identifier");
    }
    // Only schemas change; walking everything else leaves it as it is.
    if let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) {
        schemas.values_mut().for_each(schema);
    }
    if let Some(paths) = document.get_mut("paths") {
        find_schemas(paths);
    }
    let mut text = serde_json::to_string_pretty(&document)?;
    text.push('\n');
    Ok(text)
}

/// Converts the values of every key `schema` below.
fn find_schemas(value: &mut Value) {
    match value {
        Value::Object(object) => {
            for (key, value) in object.iter_mut() {
                match key.as_str() {
                    "schema" => schema(value),
                    "example" | "examples" => {}
                    _ => find_schemas(value),
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(find_schemas),
        _ => {}
    }
}

fn schema(value: &mut Value) {
    let Some(object) = value.as_object_mut() else { return };
    type_array(object);
    if let Some(only) = object.remove("const") {
        object.insert("enum".into(), Value::Array(vec![only]));
    }
    if let Some(Value::Array(examples)) = object.remove("examples")
        && let Some(first) = examples.into_iter().next()
    {
        object.insert("example".into(), first);
    }
    for (exclusive, bound) in [("exclusiveMinimum", "minimum"), ("exclusiveMaximum", "maximum")] {
        if let Some(limit) = object.remove(exclusive) {
            object.insert(bound.into(), limit);
            object.insert(exclusive.into(), Value::Bool(true));
        }
    }
    null_alternative(object);
    typed_null(object);
    for key in ["properties", "patternProperties"] {
        if let Some(properties) = object.get_mut(key).and_then(Value::as_object_mut) {
            properties.values_mut().for_each(schema);
        }
    }
    for key in ["items", "additionalProperties", "not"] {
        if let Some(inner) = object.get_mut(key) {
            schema(inner);
        }
    }
    for key in ["allOf", "anyOf", "oneOf"] {
        if let Some(list) = object.get_mut(key).and_then(Value::as_array_mut) {
            list.iter_mut().for_each(schema);
        }
    }
    object.remove("propertyNames");
    // A 3.0 reference ignores its siblings, so a described one is wrapped.
    if object.len() > 1
        && let Some(reference) = object.remove("$ref")
    {
        object.insert("allOf".into(), json!([{ "$ref": reference }]));
    }
}

/// `"type": ["number", "null"]` → `"type": "number", "nullable": true`.
fn type_array(object: &mut Map<String, Value>) {
    let Some(Value::Array(types)) = object.get("type") else { return };
    let mut names: Vec<Value> = types.iter().filter(|name| *name != "null").cloned().collect();
    let nullable = names.len() < types.len();
    match (names.len(), names.pop()) {
        (1, Some(name)) => object.insert("type".into(), name),
        _ => object.remove("type"),
    };
    if nullable {
        object.insert("nullable".into(), Value::Bool(true));
    }
}

/// `oneOf` with a null branch → the other branches and `nullable`.
fn null_alternative(object: &mut Map<String, Value>) {
    for key in ["oneOf", "anyOf"] {
        let Some(list) = object.get_mut(key).and_then(Value::as_array_mut) else { continue };
        let before = list.len();
        list.retain(|branch| branch.get("type") != Some(&Value::from("null")));
        let (left, only) = (list.len(), list.first().cloned());
        if left < before {
            object.insert("nullable".into(), Value::Bool(true));
        }
        // a choice of one is none
        if let (1, Some(only)) = (left, only) {
            object.remove(key);
            object.insert("allOf".into(), json!([only]));
        }
    }
}

/// `nullable` counts with `type` only. What is nullable without one is a reference to an object.
fn typed_null(object: &mut Map<String, Value>) {
    let described = ["allOf", "oneOf", "anyOf", "$ref"].iter().any(|key| object.contains_key(*key));
    if object.get("nullable") == Some(&Value::Bool(true)) && described {
        object.entry("type").or_insert_with(|| "object".into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn openapi_3_1_constructs_are_translated() {
        let document = json!({
            "openapi": "3.1.0",
            "info": {"title": "t", "version": "1", "license": {"name": "MIT", "identifier": "MIT"}},
            "paths": {"/a": {"get": {"parameters": [{"name": "n", "in": "query",
                "schema": {"type": ["integer", "null"]}}]}}},
            "components": {"schemas": {"A": {
                "type": "object",
                "properties": {
                    "a": {"type": "number", "exclusiveMinimum": 0, "examples": [1]},
                    "b": {"const": "x"},
                    "c": {"oneOf": [{"type": "null"}, {"$ref": "#/components/schemas/A"}]},
                    "d": {"type": "array", "items": {"type": ["number", "null"]}},
                    "e": {"$ref": "#/components/schemas/A", "description": "d"}
                }
            }}}
        });
        let text = convert(&document.to_string()).unwrap();
        let got: Value = serde_json::from_str(&text).unwrap();
        let properties = &got["components"]["schemas"]["A"]["properties"];
        assert_eq!(properties["a"], json!({"type": "number", "minimum": 0, "exclusiveMinimum": true, "example": 1}));
        assert_eq!(properties["b"], json!({"enum": ["x"]}));
        assert_eq!(
            properties["c"],
            json!({"allOf": [{"$ref": "#/components/schemas/A"}], "nullable": true, "type": "object"})
        );
        assert_eq!(properties["d"]["items"], json!({"type": "number", "nullable": true}));
        assert_eq!(properties["e"], json!({"allOf": [{"$ref": "#/components/schemas/A"}], "description": "d"}));
        assert_eq!(got["paths"]["/a"]["get"]["parameters"][0]["schema"], json!({"type": "integer", "nullable": true}));
        assert_eq!(got["info"]["license"], json!({"name": "MIT"}));
    }
}
