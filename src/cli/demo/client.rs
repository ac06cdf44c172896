//! The demonstration's HTTP client: the server is spoken to as any other program would, over TCP.

use std::time::Duration;

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use crate::cli::{CommandError, progress};

/// Largest answer taken, in bytes: a refit of a million nodes with its residuals is 20 MB.
const LARGEST_ANSWER: u64 = 1 << 30;

/// Speaks to one server.
pub struct Client {
    agent: ureq::Agent,
    base: String,
}

/// The parts of an `application/problem+json` that are shown.
#[derive(Deserialize)]
struct Problem {
    title: String,
    detail: Option<String>,
    #[serde(default)]
    errors: Vec<Fault>,
}

#[derive(Deserialize)]
struct Fault {
    pointer: String,
    detail: String,
}

/// Faults shown of a refused request.
const FAULTS_SHOWN: usize = 5;

impl Client {
    /// A client of the server at `base`, such as `http://127.0.0.1:8080`.
    pub fn new(base: impl Into<String>) -> Self {
        let config = ureq::Agent::config_builder()
            .http_status_as_error(false)
            // The server is on this machine, whatever HTTP_PROXY says.
            .proxy(None)
            .timeout_global(Some(Duration::from_secs(300)))
            .build();
        Client { agent: config.into(), base: base.into() }
    }

    /// The address of `path` on this server.
    pub fn url(&self, path: &str) -> String {
        format!("{}{path}", self.base)
    }

    pub fn get<T: DeserializeOwned + Send>(&self, path: &str) -> Result<T, CommandError> {
        let url = self.url(path);
        waiting(|| {
            let outcome = self.agent.get(&url).call();
            answer("GET", url, outcome)
        })
    }

    pub fn post<T: DeserializeOwned + Send>(&self, path: &str, body: &Value) -> Result<T, CommandError> {
        self.send("POST", self.agent.post(self.url(path)), path, body)
    }

    pub fn put<T: DeserializeOwned + Send>(&self, path: &str, body: &Value) -> Result<T, CommandError> {
        self.send("PUT", self.agent.put(self.url(path)), path, body)
    }

    pub fn patch<T: DeserializeOwned + Send>(&self, path: &str, body: &Value) -> Result<T, CommandError> {
        self.send("PATCH", self.agent.patch(self.url(path)), path, body)
    }

    fn send<T: DeserializeOwned + Send>(
        &self,
        method: &'static str,
        request: ureq::RequestBuilder<ureq::typestate::WithBody>,
        path: &str,
        body: &Value,
    ) -> Result<T, CommandError> {
        waiting(|| {
            let outcome = request.header("content-type", "application/json").send(body.to_string());
            answer(method, self.url(path), outcome)
        })
    }
}

/// Shows for how long an answer is waited for.
fn waiting<T: Send>(ask: impl FnOnce() -> T + Send) -> T {
    progress::watched("waiting for the server", || None, ask)
}

fn answer<T: DeserializeOwned>(
    method: &'static str,
    url: String,
    outcome: Result<ureq::http::Response<ureq::Body>, ureq::Error>,
) -> Result<T, CommandError> {
    let read = outcome.and_then(|mut response| {
        let body = response.body_mut().with_config().limit(LARGEST_ANSWER).read_to_vec()?;
        Ok((response.status().as_u16(), body))
    });
    let (status, body) = read.map_err(|error| format!("{method} {url}: {error}"))?;
    if !(200..300).contains(&status) {
        return Err(format!("{method} {url} was answered {status}: {}", in_words(&body)).into());
    }
    let invalid = |error| format!("{method} {url} was answered {status} with an invalid body: {error}").into();
    serde_json::from_slice(&body).map_err(invalid)
}

/// Returns a problem as one sentence with the first errors and their places in the request.
fn in_words(body: &[u8]) -> String {
    let Ok(problem) = serde_json::from_slice::<Problem>(body) else {
        return String::from_utf8_lossy(body).into_owned();
    };
    let mut text = problem.detail.unwrap_or(problem.title);
    for fault in problem.errors.iter().take(FAULTS_SHOWN) {
        text.push_str(&format!("\n  {}: {}", fault.pointer, fault.detail));
    }
    if problem.errors.len() > FAULTS_SHOWN {
        text.push_str(&format!("\n  and {} more", problem.errors.len() - FAULTS_SHOWN));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_reads_as_a_sentence() {
        let body = br#"{"type":"about:blank","title":"Unprocessable","status":422,"detail":"one fault",
            "errors":[{"pointer":"/nodes/z/1","detail":"not a number"}]}"#;
        assert_eq!(in_words(body), "one fault\n  /nodes/z/1: not a number");
        assert_eq!(in_words(b"plain"), "plain");
    }
}
