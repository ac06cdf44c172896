//! The harness in the words of jobs.

use std::path::{Path, PathBuf};

use flankfit::http::AppState;
use reqwest::{Client, Method, RequestBuilder, StatusCode, header::HeaderMap};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::harness;

pub struct TestApp {
    pub client: Client,
    pub base: String,
    server: Option<harness::TestApp>,
    database: PathBuf,
}

/// An answer, read.
#[derive(Debug)]
pub struct Answer {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub text: String,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap_or_else(|error| panic!("{error}: {}", self.text))
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.get(name).map(|value| value.to_str().unwrap())
    }

    /// The answer, after a look at its status.
    #[track_caller]
    pub fn expect(self, status: u16) -> Self {
        assert_eq!(self.status.as_u16(), status, "{}", self.text);
        self
    }

    /// The pointers of a problem, after a look at its status and code.
    #[track_caller]
    pub fn problem(&self, status: u16, code: &str) -> Vec<String> {
        assert_eq!(self.status.as_u16(), status, "{}", self.text);
        assert_eq!(self.header("content-type"), Some("application/problem+json"));
        let problem = self.json();
        assert_eq!(problem["code"], code, "{problem}");
        assert_eq!(problem["status"], status);
        let errors = problem["errors"].as_array().cloned().unwrap_or_default();
        errors.iter().map(|error| error["pointer"].as_str().unwrap().to_owned()).collect()
    }
}

impl TestApp {
    pub async fn start() -> Self {
        TestApp::around(harness::TestApp::start().await)
    }

    /// On a file, for tests that reach into it.
    pub async fn start_on_file() -> Self {
        TestApp::around(harness::TestApp::start_on_file().await)
    }

    pub fn around(server: harness::TestApp) -> Self {
        TestApp {
            client: server.client.clone(),
            base: format!("http://{}", server.address),
            database: server.directory.path().join("test.db"),
            server: Some(server),
        }
    }

    /// State that the server's handlers share.
    pub fn state(&self) -> &AppState {
        &self.server.as_ref().unwrap().state
    }

    /// The server.
    pub fn server(&self) -> &harness::TestApp {
        self.server.as_ref().unwrap()
    }

    pub fn database(&self) -> PathBuf {
        self.database.clone()
    }

    /// Stops the server as a signal would and starts another one on the same database.
    pub async fn restart(&mut self) {
        let directory = self.stop_server().await;
        *self = TestApp::around(harness::TestApp::start_in(directory, |_| {}).await);
    }

    /// The same on a file, with something done to it in between.
    pub async fn restart_after(&mut self, between: impl AsyncFnOnce(&Path)) {
        let directory = self.stop_server().await;
        between(&self.database).await;
        *self = TestApp::around(harness::TestApp::start_with_file(directory).await);
    }

    /// Stops the server; the database goes away.
    pub async fn stop(&mut self) {
        self.stop_server().await;
    }

    pub async fn stop_server(&mut self) -> TempDir {
        // Idle connections of the client would be waited for.
        self.client = Client::new();
        self.server.take().unwrap().stop().await
    }

    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.base))
    }

    pub async fn get(&self, path: &str) -> Answer {
        send(self.request(Method::GET, path)).await
    }

    pub async fn post(&self, path: &str, body: &Value) -> Answer {
        send(self.request(Method::POST, path).json(body)).await
    }

    pub async fn post_keyed(&self, path: &str, key: &str, body: &Value) -> Answer {
        send(self.request(Method::POST, path).header("Idempotency-Key", key).json(body)).await
    }

    pub async fn put(&self, path: &str, body: &Value) -> Answer {
        send(self.request(Method::PUT, path).json(body)).await
    }

    pub async fn patch(&self, path: &str, body: &Value) -> Answer {
        send(self.request(Method::PATCH, path).json(body)).await
    }

    pub async fn patch_if(&self, path: &str, tag: &str, body: &Value) -> Answer {
        send(self.request(Method::PATCH, path).header("If-Match", tag).json(body)).await
    }

    pub async fn delete(&self, path: &str) -> Answer {
        send(self.request(Method::DELETE, path)).await
    }

    /// A new job's path.
    pub async fn job(&self) -> String {
        let answer = self.post("/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
        answer.header("location").unwrap().to_owned()
    }

    /// A new stream's path.
    pub async fn stream(&self, job: &str, spec: &Value) -> String {
        let answer = self.post(&format!("{job}/streams"), spec).await.expect(201);
        answer.header("location").unwrap().to_owned()
    }

    /// A new iteration's path.
    pub async fn iteration(&self, job: &str) -> String {
        let answer = self.post(&format!("{job}/iterations"), &iteration()).await.expect(201);
        answer.header("location").unwrap().to_owned()
    }
}

pub async fn send(request: RequestBuilder) -> Answer {
    let response = request.send().await.unwrap();
    Answer { status: response.status(), headers: response.headers().clone(), text: response.text().await.unwrap() }
}

/// Returns a part of a response as it is returned by itself, with its own list of the warnings
/// gathered from it.
pub fn alone(answer: &Value, part: &str) -> Value {
    let mut alone = answer.pointer(part).unwrap().clone();
    let of_part = |warning: &Value| {
        let at = warning["at"].as_str()?.strip_prefix(part).filter(|rest| rest.starts_with('/'))?.to_owned();
        let mut warning = warning.clone();
        warning["at"] = at.into();
        Some(warning)
    };
    let gathered: Vec<Value> = answer["warnings"].as_array().unwrap().iter().filter_map(of_part).collect();
    if !gathered.is_empty() {
        assert_eq!(alone.get("warnings"), None);
        alone["warnings"] = gathered.into();
    }
    alone
}

/// A flank grid: a plane, some waviness, one missing node.
pub fn nodes() -> Value {
    let u: Vec<f64> = (0..9).map(|i| 30.0 + 0.5 * f64::from(i)).collect();
    let v: Vec<f64> = (0..5).map(|j| 5.0 * f64::from(j)).collect();
    let mut z: Vec<Vec<Value>> = u
        .iter()
        .map(|u| v.iter().map(|v| json!(0.01 * u - 0.002 * v + 1e-3 * (3.0 * u + v).sin())).collect())
        .collect();
    z[3][2] = Value::Null;
    json!({"type": "grid", "u": u, "v": v, "z": z})
}

/// An iteration request.
pub fn iteration() -> Value {
    json!({
        "nodes": nodes(),
        "model": {"type": "polynomial", "degree": [2, 2]},
        "measured_at": "2026-11-21T09:30:00+01:00",
        "instrument": "P40",
        "operator": "J. Doe",
        "note": "after the first cut",
    })
}
