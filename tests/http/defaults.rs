//! Defaults of the document are those of the service: a request with one of them written out has
//! the response of the request without it.

use flankfit::{api::examples::REQUEST_EXAMPLES, http::openapi::openapi_json};
use serde_json::{Value, json};

use crate::{
    harness::{Answer, TestApp, send},
    schema::Schemas,
};

/// Requests with one default written out, and its place.
struct Written<'a> {
    schemas: &'a Value,
    found: Vec<(String, Value)>,
}

impl Written<'_> {
    fn look(&mut self, schema: &Value, part: &Value, at: &str, whole: &Value) {
        let schema = match schema["$ref"].as_str() {
            Some(reference) => &self.schemas[reference.rsplit('/').next().unwrap()],
            None => schema,
        };
        if let Some(mapping) = schema.pointer("/discriminator/mapping")
            && let Some(reference) = part["type"].as_str().and_then(|kind| mapping[kind].as_str())
        {
            return self.look(&json!({"$ref": reference}), part, at, whole);
        }
        match part {
            Value::Object(fields) => {
                for (name, property) in schema["properties"].as_object().into_iter().flatten() {
                    let place = format!("{at}/{name}");
                    match (fields.get(name), property.get("default")) {
                        (Some(value), _) => self.look(property, value, &place, whole),
                        (None, Some(default)) => {
                            let mut request = whole.clone();
                            request.pointer_mut(at).unwrap()[name] = default.clone();
                            self.found.push((place, request));
                        }
                        (None, None) => {}
                    }
                }
            }
            Value::Array(list) => {
                for (i, entry) in list.iter().enumerate().take(2) {
                    self.look(&schema["items"], entry, &format!("{at}/{i}"), whole);
                }
            }
            _ => {}
        }
    }
}

/// Returns a response without what repeats the request: its digest, and the settings of an
/// evaluation.
fn result(answer: &Answer) -> Value {
    let mut all = answer.json();
    for place in ["/result", "/registration/result"] {
        all.pointer_mut(&format!("{place}/provenance")).map(Value::take);
    }
    all.pointer_mut("/evaluation").map(Value::take);
    all
}

#[test]
fn defaults_of_the_document_are_valid() {
    fn walk(schemas: &Schemas<'_>, schema: &Value, wrong: &mut Vec<String>) {
        if let (Value::Object(fields), Some(default)) = (schema, schema.get("default")) {
            let mut own = fields.clone();
            own.remove("default");
            wrong.extend(schemas.faults(&own.into(), default).into_iter().map(|fault| format!("{schema}: {fault}")));
        }
        match schema {
            Value::Object(fields) => fields.values().for_each(|part| walk(schemas, part, wrong)),
            Value::Array(list) => list.iter().for_each(|part| walk(schemas, part, wrong)),
            _ => {}
        }
    }
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let mut wrong = Vec::new();
    for schema in document["components"]["schemas"].as_object().unwrap().values() {
        walk(&Schemas(&document), schema, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[tokio::test]
async fn defaults_of_the_document_are_those_of_the_service() {
    let app = TestApp::start().await;
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let mut wrong = Vec::new();
    let mut tried = 0;
    for (path, item) in document["paths"].as_object().unwrap() {
        let operation = &item["post"];
        // responses of what is stored have ids and times
        if path.contains('{')
            || ["/v1/jobs", "/v1/simulations/closed-loop"].contains(&path.as_str())
            || operation["responses"].get("200").is_none()
        {
            continue;
        }
        let examples = REQUEST_EXAMPLES.iter().filter(|one| operation["operationId"] == one.operation_id);
        for example in examples {
            let request: Value = serde_json::from_str(example.text).unwrap();
            let schema = &operation["requestBody"]["content"]["application/json"]["schema"];
            let mut written = Written { schemas: &document["components"]["schemas"], found: Vec::new() };
            written.look(schema, &request, "", &request);
            let plain = send(app.post(path, request.to_string())).await;
            // files have the time of their making
            if !plain.header("content-type").ends_with("json") {
                continue;
            }
            for (place, request) in written.found {
                let answer = send(app.post(path, request.to_string())).await;
                tried += 1;
                if (answer.status, result(&answer)) != (plain.status, result(&plain)) {
                    let shown: String = answer.text.chars().take(200).collect();
                    wrong.push(format!("{} {place}: {shown}", example.name));
                }
            }
        }
    }
    assert!(wrong.is_empty() && tried > 50, "{tried}\n{}", wrong.join("\n"));
}
