//! The document against itself and against the service: names, descriptions, examples, responses.

use std::collections::BTreeMap;

use flankfit::http::openapi::{openapi_3_0_json, openapi_json};
use serde_json::Value;

use crate::{
    harness::{TestApp, send},
    schema::{Schemas, with_responses},
};

fn document() -> Value {
    with_responses(openapi_json())
}

/// Calls `see` with every object of a value and its place.
fn walk(value: &Value, at: &str, see: &mut impl FnMut(&str, &Value)) {
    match value {
        Value::Object(object) => {
            see(at, value);
            object.iter().for_each(|(key, value)| walk(value, &format!("{at}/{key}"), see));
        }
        Value::Array(list) => list.iter().enumerate().for_each(|(i, value)| walk(value, &format!("{at}/{i}"), see)),
        _ => {}
    }
}

/// Names that generators make the same name of: case and underscores are style.
fn alike<'a>(names: impl Iterator<Item = &'a str>) -> Vec<Vec<&'a str>> {
    let mut groups: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for name in names {
        groups.entry(name.replace(['_', '-'], "").to_lowercase()).or_default().push(name);
    }
    groups.into_values().filter(|group| group.len() > 1).collect()
}

/// Operations with path and method.
fn operations(document: &Value) -> Vec<(&str, &str, &Value)> {
    let paths = document["paths"].as_object().unwrap().iter();
    paths
        .flat_map(|(path, item)| {
            item.as_object().unwrap().iter().map(move |(method, operation)| (path.as_str(), method.as_str(), operation))
        })
        .collect()
}

#[test]
fn no_two_names_differ_by_case_only() {
    let document = document();
    walk(&document["components"]["schemas"], "", &mut |at, value| {
        if let Some(properties) = value.get("properties").and_then(Value::as_object)
            && !at.ends_with("/properties")
        {
            assert_eq!(alike(properties.keys().map(String::as_str)), [[""; 0]; 0], "{at}");
        }
    });
    let schemas = document["components"]["schemas"].as_object().unwrap().keys().map(String::as_str);
    assert_eq!(alike(schemas), [[""; 0]; 0]);
    for (path, method, operation) in operations(&document) {
        for place in ["path", "query", "header"] {
            let parameters = operation["parameters"].as_array().into_iter().flatten();
            let names = parameters.filter(|parameter| parameter["in"] == place).map(|p| p["name"].as_str().unwrap());
            assert_eq!(alike(names), [[""; 0]; 0], "{method} {path}");
        }
    }
    let ids = operations(&document).into_iter().map(|(_, _, operation)| operation["operationId"].as_str().unwrap());
    assert_eq!(alike(ids), [[""; 0]; 0]);
}

/// Two schemas of one name would silently become one in the document.
#[test]
fn no_two_schemas_are_declared_by_one_name() {
    fn read(folder: &std::path::Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                read(&path, found);
            } else {
                let text = std::fs::read_to_string(&path).unwrap();
                let names = text.split("schema(as = ").skip(1).filter_map(|rest| rest.split([',', ')']).next());
                found.extend(names.map(str::to_owned));
            }
        }
    }
    let mut names = Vec::new();
    read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut names);
    assert!(names.len() > 100);
    names.sort();
    let twice: Vec<_> = names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| &pair[0]).collect();
    assert!(twice.is_empty(), "{twice:?}");
}

#[test]
fn everything_is_described() {
    let document = document();
    let schemas = document["components"]["schemas"].as_object().unwrap();
    let described = |value: &Value| value["description"].as_str().is_some_and(|text| text.len() > 2);
    let mut silent = Vec::new();
    for (name, schema) in schemas {
        if !described(schema) {
            silent.push(name.clone());
        }
        walk(schema, name, &mut |at, value| {
            if at.ends_with("/properties") {
                for (property, value) in value.as_object().unwrap() {
                    let named = value["$ref"].as_str().and_then(|at| schemas.get(at.rsplit('/').next().unwrap()));
                    if !described(value) && !named.is_some_and(described) {
                        silent.push(format!("{at}/{property}"));
                    }
                }
            }
        });
    }
    for (path, method, operation) in operations(&document) {
        let place = format!("{method} {path}");
        if !described(operation) || operation["description"] == operation["summary"] {
            silent.push(place.clone());
        }
        for parameter in
            operation["parameters"].as_array().into_iter().flatten().filter(|parameter| !described(parameter))
        {
            silent.push(format!("{place} {}", parameter["name"]));
        }
    }
    assert!(silent.is_empty(), "without a description: {silent:#?}");
}

/// Examples under a media type.
fn examples(content: &Value) -> Vec<(&str, &Value)> {
    let named = content["examples"].as_object().into_iter().flatten();
    let single = content.get("example").map(|value| ("example", value));
    named.map(|(name, example)| (name.as_str(), &example["value"])).chain(single).collect()
}

#[test]
fn every_example_is_valid() {
    let document = document();
    let schemas = Schemas(&document);
    let (mut requests, mut answers) = (0, 0);
    for (path, method, operation) in operations(&document) {
        for content in operation["requestBody"]["content"].as_object().into_iter().flatten().map(|(_, content)| content)
        {
            for (name, value) in examples(content) {
                requests += 1;
                assert_eq!(schemas.faults(&content["schema"], value), [""; 0], "{method} {path} {name}");
            }
        }
        for (status, response) in operation["responses"].as_object().unwrap() {
            for (media, content) in response["content"].as_object().into_iter().flatten() {
                let shown = examples(content);
                assert!(media != "application/problem+json" || !shown.is_empty(), "{method} {path} {status}");
                for (name, value) in shown {
                    answers += 1;
                    assert_eq!(schemas.faults(&content["schema"], value), [""; 0], "{method} {path} {status} {name}");
                    if media == "application/problem+json" {
                        assert_eq!(value["status"].to_string(), *status, "{method} {path}");
                    }
                }
            }
        }
    }
    for (name, schema) in document["components"]["schemas"].as_object().unwrap() {
        if let Some(value) = schema.get("example") {
            assert_eq!(schemas.faults(schema, value), [""; 0], "{name}");
        }
    }
    assert!(requests > 60 && answers > 300, "{requests} {answers}");
}

/// Checks that an answer's own list contains every warning of its parts, and counts these. Lists of
/// resources (pages and traces) have no list of their own.
fn check_warnings(answer: &Value, of: &str) -> usize {
    let mut parts = Vec::new();
    walk(answer, "", &mut |at, value| {
        let is_given = ["/request", "/spec", "/gear"].iter().any(|given| at.starts_with(given));
        if !at.is_empty() && !is_given && !at.ends_with("/spec") {
            let warnings = value.get("warnings").and_then(Value::as_array).into_iter().flatten();
            parts.extend(warnings.map(|warning| (at.to_owned(), warning.clone())));
        }
    });
    if answer.get("items").or(answer.get("iterations")).is_some_and(Value::is_array) {
        return 0;
    }
    let own = answer["warnings"].as_array().cloned().unwrap_or_default();
    for (at, warning) in &parts {
        let mut gathered = warning.clone();
        gathered["at"] = format!("{at}{}", warning["at"].as_str().unwrap_or("")).into();
        assert_eq!(own.iter().filter(|entry| **entry == gathered).count(), 1, "{of}: {gathered} in {own:?}");
    }
    parts.len()
}

/// Sends every example of a request, and reads every resource that exists then: all responses match
/// the document.
#[tokio::test]
async fn every_answer_is_as_the_document_says() {
    let app = TestApp::start().await;
    let document = document();
    let schemas = Schemas(&document);
    let example = |operation_id: &str, name: &str| {
        let (_, _, operation) = operations(&document)
            .into_iter()
            .find(|(_, _, operation)| operation["operationId"] == operation_id)
            .unwrap();
        operation["requestBody"]["content"]["application/json"]["examples"][name]["value"].to_string()
    };
    let job = send(app.post("/v1/jobs", example("create_job", "job"))).await.header("location").to_owned();
    let made = send(app.post(&format!("{job}/iterations"), example("create_iteration", "iteration"))).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let stream = send(app.post(&format!("{job}/streams"), example("create_stream", "stream"))).await;
    let id = |place: &str| place.rsplit('/').next().unwrap().to_owned();
    let (job, stream) = (id(&job), id(stream.header("location")));
    let key = send(app.post("/v1/keys", example("create_key", "key"))).await.json()["id"].clone();
    let key = key.as_str().unwrap().to_owned();
    let place = |path: &str| {
        path.replace("{key_id}", &key)
            .replace("{job_id}", &job)
            .replace("{stream_id}", &stream)
            .replace("{number}", "1")
    };
    let (mut checked, mut warned) = (0, 0);
    let mut check = |operation: &Value, answer: &crate::harness::Answer, of: &str| {
        let response = &operation["responses"][answer.status.as_str()];
        assert!(response.is_object(), "{of}: {} is not documented: {}", answer.status, answer.text);
        let media = answer.header("content-type");
        if media.ends_with("json") {
            let schema = &response["content"][media]["schema"];
            warned += check_warnings(&answer.json(), of);
            assert_eq!(schemas.faults(schema, &answer.json()), [""; 0], "{of}: {}", answer.text);
            checked += 1;
        }
    };
    let mut posts = operations(&document);
    // what is finished takes no more nodes
    posts.sort_by_key(|(_, _, operation)| operation["operationId"] == "finish_stream");
    for (path, method, operation) in posts {
        // no example knows the id of a fit, and a purge leaves nothing for the others
        if operation["operationId"] == "choose_fit" || operation["operationId"] == "purge_job" {
            continue;
        }
        for (name, value) in examples(&operation["requestBody"]["content"]["application/json"]) {
            let request = app.client.request(method.to_uppercase().parse().unwrap(), app.url(&place(path)));
            let answer = send(request.header("content-type", "application/json").body(value.to_string())).await;
            assert!(answer.status.is_success(), "{name}: {}", answer.text);
            check(operation, &answer, name);
        }
    }
    for (path, method, operation) in operations(&document) {
        let path = place(path);
        // those that never end, and those of things whose ids nobody knows here
        if method == "get" && !path.contains('{') && !path.ends_with("/events") && !path.ends_with("/ws") {
            check(operation, &send(app.get(&path)).await, &path);
        }
    }
    assert!(checked > 70 && warned > 5, "{checked} {warned}");
    app.stop().await;
}

#[test]
fn the_document_for_generators_has_only_what_they_support() {
    let copy: Value = serde_json::from_str(&openapi_3_0_json()).unwrap();
    assert_eq!(copy["openapi"], "3.0.3");
    walk(&copy["components"]["schemas"], "", &mut |at, value| {
        if value.get("nullable").is_some() && !at.ends_with("/properties") {
            assert!(value.get("type").is_some(), "{at}: nullable without type");
        }
        let parts = value.get("allOf").and_then(Value::as_array).map_or(0, Vec::len);
        assert!(parts <= 1, "{at}: an object of parts");
        for alternative in value.get("oneOf").and_then(Value::as_array).into_iter().flatten() {
            assert!(alternative.get("$ref").is_some(), "{at}: an alternative without a name");
        }
    });
    for (path, method, operation) in operations(&copy) {
        let content = operation["requestBody"]["content"].as_object();
        assert!(content.is_none_or(|content| content.len() == 1), "{method} {path}: a body of two forms");
    }
    // names that languages have taken
    for taken in ["Record", "Object", "String", "Error", "List", "Map"] {
        assert!(copy["components"]["schemas"].get(taken).is_none(), "{taken}");
    }
}
