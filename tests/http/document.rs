//! The OpenAPI document and its page.

use std::path::Path;

use flankfit::{
    api::examples::REQUEST_EXAMPLES,
    http::openapi::{openapi_3_0_json, openapi_json},
};
use serde_json::Value;

use crate::{
    harness::{TestApp, send},
    schema::with_responses,
};

/// The committed document is what the code says. `UPDATE_OPENAPI=1 cargo test` writes it anew.
#[test]
fn the_committed_document_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi/flankfit.json");
    let generated = openapi_json();
    if std::env::var_os("UPDATE_OPENAPI").is_some() {
        std::fs::write(&path, generated).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let line = committed.lines().zip(generated.lines()).position(|(a, b)| a != b);
    assert!(
        committed == generated,
        "openapi/flankfit.json differs from the code (first at line {:?}); run UPDATE_OPENAPI=1 cargo test --test http",
        line.map(|line| line + 1)
    );
}

fn operations(document: &Value) -> Vec<(String, String, Value)> {
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            all.push((path.clone(), method.clone(), operation.clone()));
        }
    }
    all
}

#[test]
fn every_operation_is_documented_to_its_end() {
    let document = with_responses(openapi_json());
    let mut ids = Vec::new();
    for (path, method, operation) in operations(&document) {
        let id = operation["operationId"].as_str().unwrap_or_else(|| panic!("{method} {path}")).to_owned();
        assert!(id.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{id}");
        // an imperative verb and its object: "Create a job"
        let summary = operation["summary"].as_str().unwrap_or_else(|| panic!("{id}"));
        let (verb, object) = summary.split_once(' ').unwrap_or_else(|| panic!("{id}: {summary}"));
        assert!(verb.starts_with(char::is_uppercase) && !verb.ends_with('s'), "{id}: {summary}");
        assert!(!object.contains('\n') && !object.ends_with('.') && summary.len() <= 72, "{id}: {summary}");
        assert_eq!(operation["tags"].as_array().map(Vec::len), Some(1), "{id}");
        let responses = operation["responses"].as_object().unwrap();
        assert!(responses.keys().any(|status| status.starts_with(['1', '2', '3'])), "{id}");
        for (status, response) in responses {
            assert!(response["description"].as_str().is_some_and(|text| !text.is_empty()), "{id} {status}");
            assert!(response["headers"]["x-request-id"].is_object(), "{id} {status}");
            if status.starts_with(['4', '5']) {
                assert!(response["content"]["application/problem+json"].is_object(), "{id} {status}");
            }
        }
        let mut expected = vec!["500", "503"];
        if path.starts_with("/v1/") {
            expected.extend(["401", "403"]);
            if operation.get("requestBody").is_some() {
                expected.extend(["400", "408", "413", "415", "422"]);
            }
        }
        for status in expected {
            assert!(responses.contains_key(status), "{id} {status}");
        }
        ids.push(id);
    }
    ids.sort();
    let count = ids.len();
    ids.dedup();
    assert_eq!(ids.len(), count);
}

#[test]
fn references_lead_somewhere_and_nothing_is_nullable_but_measured_entries() {
    fn walk(document: &Value, place: &str, value: &Value) {
        match value {
            Value::Object(object) => {
                if let Some(reference) = object.get("$ref").and_then(Value::as_str) {
                    assert!(document.pointer(&reference[1..]).is_some(), "{reference}");
                }
                if place.ends_with("/example") || place.ends_with("/examples") {
                    return;
                }
                if let Some(Value::Array(kinds)) = object.get("type") {
                    // of measurements and of nodes, what is undefined keeps its place
                    let measured =
                        ["_um/", "_mm/", "angle_deg/", "GearDeviationsRequest/properties/points/", "/Influence/"]
                            .iter()
                            .any(|unit| place.contains(unit));
                    let entry = place.ends_with("/items") && measured;
                    assert!(kinds.len() == 1 || entry || place.contains("GridNodes/properties/z"), "{place}");
                }
                object.iter().for_each(|(key, value)| walk(document, &format!("{place}/{key}"), value));
            }
            Value::Array(list) => list.iter().for_each(|value| walk(document, place, value)),
            _ => {}
        }
    }
    for text in [openapi_json().to_owned(), openapi_3_0_json()] {
        let document: Value = serde_json::from_str(&text).unwrap();
        walk(&document, "", &document);
    }
}

#[test]
fn unions_have_discriminators_whose_variants_name_themselves() {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let mut unions = 0;
    for (name, schema) in document["components"]["schemas"].as_object().unwrap() {
        let Some(mapping) = schema.pointer("/discriminator/mapping").and_then(Value::as_object) else { continue };
        unions += 1;
        for (tag, reference) in mapping {
            let variant = document.pointer(&reference.as_str().unwrap()[1..]).unwrap();
            assert_eq!(variant["properties"]["type"]["enum"], serde_json::json!([tag]), "{name}");
            assert!(variant["required"].as_array().unwrap().contains(&"type".into()), "{name}");
        }
    }
    assert!(unions >= 4);
}

#[test]
fn every_example_is_in_the_document() {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let operations = operations(&document);
    for example in REQUEST_EXAMPLES {
        let (_, _, operation) = operations
            .iter()
            .find(|(_, _, operation)| operation["operationId"] == example.operation_id)
            .unwrap_or_else(|| panic!("{}", example.operation_id));
        let shown = &operation["requestBody"]["content"]["application/json"]["examples"][example.name]["value"];
        assert_eq!(shown, &serde_json::from_str::<Value>(example.text).unwrap(), "{}", example.name);
    }
}

#[tokio::test]
async fn the_document_is_served_as_committed() {
    let app = TestApp::start().await;
    let answer = send(app.get("/openapi.json")).await;
    assert_eq!((answer.status.as_u16(), answer.header("content-type")), (200, "application/json"));
    assert_eq!(answer.text, openapi_json());
}

#[tokio::test]
async fn the_page_needs_no_internet() {
    let app = TestApp::start().await;
    let answer = send(app.get("/docs")).await;
    assert_eq!(answer.status, 200, "redirected to the page");
    assert!(answer.text.contains("swagger-ui"));
    for file in ["/docs/", "/docs/swagger-initializer.js", "/docs/index.css"] {
        let answer = send(app.get(file)).await;
        assert_eq!(answer.status, 200, "{file}");
        assert!(!answer.text.contains("http://") && !answer.text.contains("https://"), "{file}: {}", answer.text);
    }
    assert!(send(app.get("/docs/swagger-initializer.js")).await.text.contains("/openapi.json"));
    for file in ["/docs/swagger-ui-bundle.js", "/docs/swagger-ui-standalone-preset.js", "/docs/swagger-ui.css"] {
        assert_eq!(send(app.get(file)).await.status, 200, "{file}");
    }
    let packed = send(app.get("/docs/swagger-ui.css").header("accept-encoding", "gzip")).await;
    assert_eq!((packed.header("content-encoding"), packed.header("vary")), ("gzip", "accept-encoding"));
    let plain = send(app.get("/docs/swagger-ui.css").header("accept-encoding", "identity")).await;
    assert!(plain.text.contains(".swagger-ui") && !plain.headers.contains_key("content-encoding"));
    send(app.get("/docs/nothing.js")).await.problem(404, "not_found");
    let without = TestApp::start_with(|settings| settings.docs = false).await;
    send(without.get("/docs/")).await.problem(404, "not_found");
}
