//! Removes what generators of clients turn into wrong code from their copy of the document
//! (`docs/how-to/clients.md`).
//!
//! - A union of numbers and arrays, or of arrays of different depth, becomes a value of any form:
//!   C# and C++ get two constructors of the same signature otherwise. Its description says which
//!   forms there are. Unions of objects stay; they have discriminators or different required
//!   properties.
//! - Where a body may be JSON or a form, the form is left out, and where it may be a form or a
//!   file, the file: most generators cannot handle one method with two bodies.
//! - The address of a server, since clients have none from which the document came.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

/// Address of a server that is started without settings.
const SERVER: &str = "http://127.0.0.1:8080";

/// Takes out what generators cannot do.
pub fn spare(document: &mut Value) {
    if let Some(root) = document.as_object_mut() {
        root.insert("servers".into(), json!([{"url": SERVER, "description": "A server with its default settings."}]));
    }
    if let Some(paths) = document.get_mut("paths").and_then(Value::as_object_mut) {
        for operation in paths.values_mut().filter_map(Value::as_object_mut).flat_map(Map::values_mut) {
            without_form(operation);
        }
    }
    if let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) {
        schemas.values_mut().for_each(without_mixture);
    }
    drop_unused(document);
}

fn without_form(operation: &mut Value) {
    if let Some(content) = operation.pointer_mut("/requestBody/content").and_then(Value::as_object_mut)
        && let Some(one) =
            ["application/json", "multipart/form-data"].into_iter().find(|one| content.contains_key(*one))
    {
        content.retain(|media, _| media == one);
    }
}

/// A union with an alternative that is no object, as any value.
fn without_mixture(schema: &mut Value) {
    let Some(object) = schema.as_object_mut() else { return };
    let Some(alternatives) = object.get("oneOf").and_then(Value::as_array) else { return };
    if alternatives.iter().any(|alternative| alternative.get("$ref").is_none()) {
        object.remove("oneOf");
    }
}

/// Schemas that nothing refers to any more, and those that only they referred to.
fn drop_unused(document: &mut Value) {
    loop {
        let mut used = BTreeSet::new();
        references(document, &mut used);
        let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) else { return };
        let before = schemas.len();
        schemas.retain(|name, _| used.contains(name));
        if schemas.len() == before {
            return;
        }
    }
}

fn references(value: &Value, used: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            if let Some(reference) = object.get("$ref").and_then(Value::as_str) {
                used.extend(reference.rsplit('/').next().map(str::to_owned));
            }
            object.values().for_each(|value| references(value, used));
        }
        Value::Array(list) => list.iter().for_each(|value| references(value, used)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alternative_bodies_and_mixed_unions_are_removed() {
        let reference = |name: &str| json!({"schema": {"$ref": format!("#/components/schemas/{name}")}});
        let mut document = json!({
            "paths": {
                "/a": {"post": {"requestBody": {"content": {
                    "application/json": reference("Body"), "multipart/form-data": reference("Form")
                }}}},
                "/b": {"post": {"requestBody": {"content": {"multipart/form-data": reference("File"), "text/csv": {}}}}}
            },
            "components": {"schemas": {
                "Body": {"properties": {"degree": {"$ref": "#/components/schemas/Degree"},
                    "curve": {"$ref": "#/components/schemas/Curve"}}},
                "Degree": {"description": "d", "oneOf": [{"type": "integer"}, {"type": "array"}]},
                "Curve": {"oneOf": [{"$ref": "#/components/schemas/File"}]},
                "Form": {"properties": {"spec": {"$ref": "#/components/schemas/Spec"}}}, "Spec": {}, "File": {}
            }}
        });
        spare(&mut document);
        let names: Vec<_> = document["components"]["schemas"].as_object().unwrap().keys().collect();
        assert_eq!(names, ["Body", "Curve", "Degree", "File"]);
        assert_eq!(document["components"]["schemas"]["Degree"], json!({"description": "d"}));
        assert!(document["paths"]["/b"]["post"]["requestBody"]["content"]["multipart/form-data"].is_object());
        assert_eq!(document["servers"][0]["url"], SERVER);
    }
}
