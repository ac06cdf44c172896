//! Requests with their responses as they were before the interface was redesigned: numbers must
//! keep every bit, refusals their status and pointers. `tests/corpus/README.md` describes the
//! files.

use std::{collections::BTreeMap, fs, path::PathBuf};

use flankfit::{api::examples::REQUEST_EXAMPLES, http::openapi::openapi_json};
use reqwest::Method;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use crate::harness::{Answer, TestApp, send};

/// An exchange with the service.
#[derive(Debug, Deserialize, Serialize)]
struct Exchange {
    /// Name of the example, or of the draw.
    name: String,
    method: String,
    path: String,
    /// The body; of an example it is the example's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    body: Option<String>,
    status: u16,
    /// The answer with ids and times masked; of a refusal its pointers, sorted.
    answer: Value,
}

/// Operations on stored things, in the order in which one job goes through them.
const STORY: [&str; 18] = [
    "create_job",
    "create_iteration",
    "update_iteration",
    "create_iteration_fit",
    "preview_iteration_fit",
    "choose_fit",
    "create_iteration_evaluation",
    "create_iteration_pitch",
    "create_iteration_deviations",
    "create_iteration_curve",
    "create_iteration_surface",
    "create_iteration_correction",
    "create_applied_changes",
    "create_gear_correction",
    "create_gear_applied_changes",
    "create_stream",
    "add_stream_nodes",
    "finish_stream",
];

/// Resources that are read at the end of the story.
const READ: [&str; 10] = [
    "/v1/jobs",
    "/v1/jobs/{job_id}",
    "/v1/jobs/{job_id}/trace",
    "/v1/jobs/{job_id}/correction",
    "/v1/jobs/{job_id}/iterations",
    "/v1/jobs/{job_id}/iterations/1",
    "/v1/jobs/{job_id}/iterations/1/nodes",
    "/v1/jobs/{job_id}/iterations/1/fits",
    "/v1/jobs/{job_id}/iterations/1/records",
    "/v1/jobs/{job_id}/iterations/1/correction",
];

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name)
}

fn recorded(name: &str) -> Vec<Exchange> {
    let text = fs::read_to_string(file(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// True if a text is an id, a time or a digest, which differ from run to run or are derived from
/// such.
fn varies(text: &str) -> bool {
    let is_id = text.len() == 36 && text.bytes().filter(|byte| *byte == b'-').count() == 4;
    let is_time = text.len() > 19 && text.ends_with('Z') && text.as_bytes()[10] == b'T';
    is_id || is_time
}

/// Masks what varies.
fn masked(value: Value) -> Value {
    match value {
        Value::String(text) if varies(&text) => json!("…"),
        Value::String(text) => {
            // ids within paths
            let parts: Vec<&str> = text.split('/').map(|part| if varies(part) { "…" } else { part }).collect();
            json!(parts.join("/"))
        }
        Value::Array(items) => items.into_iter().map(masked).collect(),
        Value::Object(members) => {
            members.into_iter().map(|(name, value)| (name, masked(value))).collect::<serde_json::Map<_, _>>().into()
        }
        other => other,
    }
}

/// Returns what is compared of an answer.
fn shown(answer: &Answer) -> Value {
    match serde_json::from_str::<Value>(&answer.text) {
        Ok(problem) if answer.status.is_client_error() => {
            let errors = problem["errors"].as_array().cloned().unwrap_or_default();
            let mut pointers: Vec<String> =
                errors.iter().filter_map(|error| error["pointer"].as_str().map(str::to_owned)).collect();
            pointers.sort();
            json!(pointers)
        }
        Ok(body) => masked(body),
        Err(_) => {
            let lines = answer.text.lines().filter(|line| !has_time(line));
            json!({"lines": answer.text.lines().count(), "sha256": digest(&lines.collect::<Vec<_>>().join("\n"))})
        }
    }
}

/// True if a line of a file has the time at which it was written.
fn has_time(line: &str) -> bool {
    line.split(['\'', ',', ' ']).any(varies)
}

fn digest(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Lists the differences between two responses.
fn differences(at: &str, old: &Value, new: &Value, found: &mut Vec<String>) {
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            for (name, old) in a {
                match b.get(name) {
                    Some(new) => differences(&format!("{at}/{name}"), old, new, found),
                    None => found.push(format!("{at}/{name} is gone")),
                }
            }
            found.extend(b.keys().filter(|name| !a.contains_key(*name)).map(|name| format!("{at}/{name} is new")));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            pairs.for_each(|(k, (old, new))| differences(&format!("{at}/{k}"), old, new, found));
        }
        (Value::Number(a), Value::Number(b)) if a.as_f64().map(f64::to_bits) == b.as_f64().map(f64::to_bits) => {}
        _ if old == new => {}
        _ => found.push(format!("{at}: {old} became {new}")),
    }
}

/// Method and path of each operation.
fn operations() -> BTreeMap<String, (String, String)> {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let mut all = BTreeMap::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let id = operation["operationId"].as_str().unwrap();
            all.insert(id.to_owned(), (method.to_uppercase(), path.clone()));
        }
    }
    all
}

/// A server with the ids of what the story has stored.
struct Stage {
    app: TestApp,
    ids: BTreeMap<&'static str, String>,
}

impl Stage {
    fn filled(&self, text: &str) -> String {
        let ids = self.ids.iter();
        ids.fold(text.replace("{number}", "1"), |text, (name, id)| text.replace(&format!("{{{name}}}"), id))
    }

    async fn exchange(&mut self, name: &str, method: &str, path: &str, body: &str) -> Exchange {
        let url = self.app.url(&self.filled(path));
        let mut request = self.app.client.request(method.parse::<Method>().unwrap(), url);
        if !body.is_empty() {
            request = request.header("content-type", "application/json").body(self.filled(body));
        }
        let answer = send(request).await;
        if let Ok(stored) = serde_json::from_str::<Value>(&answer.text) {
            let mut keep = |name: &'static str, id: &Value| {
                if let Some(id) = id.as_str() {
                    self.ids.insert(name, id.to_owned());
                }
            };
            match name {
                "create_job" => keep("job_id", &stored["id"]),
                "create_iteration" => keep("fit_id", &stored["fits"][0]["id"]),
                "create_stream" => keep("stream_id", &stored["id"]),
                _ => {}
            }
        }
        let (name, method, path) = (name.to_owned(), method.to_owned(), path.to_owned());
        Exchange { name, method, path, body: None, status: answer.status.as_u16(), answer: shown(&answer) }
    }
}

/// Sends every example: those of calculations by themselves, those of stored things as the story of
/// one job.
async fn examples() -> Vec<Exchange> {
    let operations = operations();
    let mut stage = Stage { app: TestApp::start().await, ids: BTreeMap::new() };
    let mut all = Vec::new();
    for example in REQUEST_EXAMPLES {
        let (method, path) = &operations[example.operation_id];
        if !path.contains('{') && !["create_job", "create_key", "create_tenant"].contains(&example.operation_id) {
            all.push(stage.exchange(example.name, method, path, example.text).await);
        }
    }
    for operation in STORY {
        let (method, path) = &operations[operation];
        let example = REQUEST_EXAMPLES.iter().find(|example| example.operation_id == operation).unwrap();
        let mut body: Value = serde_json::from_str(example.text).unwrap();
        if let Some(fit) = body.get_mut("fit_id") {
            *fit = json!("{fit_id}");
        }
        all.push(stage.exchange(operation, method, path, &body.to_string()).await);
    }
    for path in READ {
        all.push(stage.exchange(path, "GET", path, "").await);
    }
    stage.app.stop().await;
    all
}

#[tokio::test]
async fn examples_are_answered_as_before() {
    let found = examples().await;
    if std::env::var("FLANKFIT_CORPUS").is_ok_and(|mode| mode == "write") {
        let lines: Vec<String> = found.iter().map(|exchange| serde_json::to_string(exchange).unwrap()).collect();
        fs::write(file("examples.jsonl"), lines.join("\n") + "\n").unwrap();
    }
    let mut differing = Vec::new();
    let before = recorded("examples.jsonl");
    assert_eq!(before.len(), found.len());
    for (old, new) in before.iter().zip(&found) {
        assert_eq!(old.name, new.name);
        if old.status != new.status {
            differing.push(format!("{}: status {} became {}", old.name, old.status, new.status));
        }
        differences(&old.name, &old.answer, &new.answer, &mut differing);
    }
    assert!(
        differing.is_empty(),
        "{} differences:\n{}",
        differing.len(),
        differing[..differing.len().min(40)].join("\n")
    );
}

#[tokio::test]
async fn drawn_requests_are_refused_as_before() {
    let app = TestApp::start().await;
    let mut differing = Vec::new();
    let before = recorded("drawn.jsonl");
    assert!(before.len() >= 2000, "{}", before.len());
    for old in &before {
        let answer = send(app.post(&old.path, old.body.clone().unwrap())).await;
        let refused = answer.status.is_client_error();
        let pointers = if refused { shown(&answer) } else { Value::Null };
        if (old.status, &old.answer) != (answer.status.as_u16(), &pointers) {
            differing.push(format!("{}: {} {} became {} {pointers}", old.name, old.status, old.answer, answer.status));
        }
    }
    assert!(
        differing.is_empty(),
        "{} differences:\n{}",
        differing.len(),
        differing[..differing.len().min(40)].join("\n")
    );
    app.stop().await;
}

/// Every example of a fit, stored with a job, has the numbers of the plain answer, and its replay
/// is identical.
#[tokio::test]
async fn stored_examples_are_replayed() {
    let app = TestApp::start().await;
    for example in REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == "create_fit") {
        let plain = app.fit(example.text).await;
        let job = send(app.post("/v1/jobs", r#"{"name":"w"}"#)).await;
        let made = send(app.post(&format!("{}/iterations", job.header("location")), example.text)).await;
        if made.status != 201 {
            // a prior or a single trace of a matrix has nothing that a job could keep
            assert_eq!(made.status, 422, "{}: {}", example.name, made.text);
            continue;
        }
        let fit = made.json()["fits"][0].clone();
        let (plain, mut found) = (plain.json(), Vec::new());
        for member in ["coefficients", "spectrum", "residuals"] {
            assert!(plain[member].is_object() || plain[member].is_array(), "{}", example.name);
            differences(member, &plain[member], &fit["result"][member], &mut found);
        }
        assert!(found.is_empty(), "{}: {found:?}", example.name);
        let place = format!("{}/iterations/1/fits/{}/replay", job.header("location"), fit["id"].as_str().unwrap());
        assert_eq!(send(app.post(&place, "{}")).await.json(), json!({"identical": true}), "{}", example.name);
    }
    app.stop().await;
}
