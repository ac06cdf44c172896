//! Responses with progress: `Accept: text/event-stream`.

mod ends;
mod kinds;

use std::time::Duration;

use reqwest::{Method, RequestBuilder, Response};
use serde_json::{Value, json};

use super::app::{TestApp, iteration};

const STUDY: &str = include_str!("../../../../examples/requests/study_flank.json");
/// Longest wait for the next event.
const PATIENCE: Duration = Duration::from_secs(60);

/// A study of so many repetitions: thousands take seconds.
pub fn study(repetitions: u32) -> Value {
    let mut request: Value = serde_json::from_str(STUDY).unwrap();
    request["repetitions"] = json!(repetitions);
    request
}

/// An iteration that takes a while.
pub fn slow_iteration() -> Value {
    let mut request = iteration();
    request["estimator"] = json!({"type": "lp", "p": 1.5});
    request
}

/// A server whose events begin at once.
async fn eager() -> TestApp {
    TestApp::around(crate::harness::TestApp::start_with(|settings| settings.pace.look = Duration::ZERO).await)
}

/// Returns the request with progress in its response.
pub fn with_progress(request: RequestBuilder) -> RequestBuilder {
    request.header("accept", "text/event-stream")
}

fn posted(app: &TestApp, path: &str, body: &Value) -> RequestBuilder {
    with_progress(app.request(Method::POST, path)).json(body)
}

/// One entry of an event stream.
#[derive(Debug)]
pub enum Entry {
    Comment,
    Event { name: String, data: String },
}

/// An answer with progress, read entry by entry.
pub struct Events {
    pub response: Response,
    text: String,
}

impl Events {
    pub async fn of(request: RequestBuilder) -> Self {
        Events::over(request.send().await.unwrap())
    }

    fn over(response: Response) -> Self {
        let header = |name: &str| response.headers().get(name).map(|value| value.to_str().unwrap());
        assert_eq!((response.status().as_u16(), header("content-type")), (200, Some("text/event-stream")));
        assert_eq!((header("cache-control"), header("x-accel-buffering")), (Some("no-store"), Some("no")));
        Events { response, text: String::new() }
    }

    /// The next entry; `None` at the end.
    pub async fn next(&mut self) -> Option<Entry> {
        loop {
            if let Some((entry, rest)) = self.text.split_once("\n\n") {
                let field = |name: &str| entry.lines().find_map(|line| line.strip_prefix(name)).map(str::to_owned);
                let entry = match (field("event: "), field("data: ")) {
                    (Some(name), Some(data)) => Entry::Event { name, data },
                    other => {
                        assert!(entry.starts_with(':') && other == (None, None), "{entry}");
                        Entry::Comment
                    }
                };
                self.text = rest.to_owned();
                return Some(entry);
            }
            let chunk = tokio::time::timeout(PATIENCE, self.response.chunk()).await.expect("an entry").unwrap()?;
            self.text.push_str(std::str::from_utf8(&chunk).unwrap());
        }
    }

    /// The completed shares that are reported, and the name and the data of the last event.
    pub async fn into_end(mut self) -> (Vec<f64>, String, String) {
        let mut shares = Vec::new();
        loop {
            match self.next().await.expect("a result or a problem") {
                Entry::Comment => {}
                Entry::Event { name, data } if name == "progress" => {
                    let data: Value = serde_json::from_str(&data).unwrap();
                    shares.push(data["progress"].as_f64().unwrap());
                }
                Entry::Event { name, data } => {
                    assert!(self.next().await.is_none(), "nothing comes after {name}");
                    assert!(shares.is_sorted_by(|a, b| a < b), "{shares:?}");
                    assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{shares:?}");
                    return (shares, name, data);
                }
            }
        }
    }

    /// Reads up to the first event `progress`.
    pub async fn begun(&mut self) {
        while !matches!(self.next().await.expect("progress"), Entry::Event { name, .. } if name == "progress") {}
    }
}

/// The data of the result.
pub async fn result(request: RequestBuilder) -> String {
    let (_, name, data) = Events::of(request).await.into_end().await;
    assert_eq!(name, "result", "{data}");
    data
}

/// The problem in which it ends.
async fn problem(request: RequestBuilder) -> Value {
    let (_, name, data) = Events::of(request).await.into_end().await;
    assert_eq!(name, "problem", "{data}");
    serde_json::from_str(&data).unwrap()
}
