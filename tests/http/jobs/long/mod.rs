//! Requests that are answered later: `Prefer: respond-async`.

mod answers;
mod keys;
mod killed;
mod kinds;
mod owners;
mod room;

use std::time::{Duration, Instant};

use jiff::Timestamp;
use reqwest::{Method, RequestBuilder};
use serde_json::{Value, json};
use uuid::Uuid;

use super::app::{Answer, TestApp, iteration, send};

const STUDY: &str = include_str!("../../../../examples/requests/study_flank.json");
/// For so long an operation is waited for.
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

/// An iteration that takes longer than some servers of a test live.
pub fn robust_iteration() -> Value {
    trimmed(40)
}

/// A fit of trimmed squares: of 40 × 40 or 150 × 150 nodes it takes seconds, of 200 × 200 some
/// twenty.
pub fn trimmed(side: usize) -> Value {
    let axis = |count: usize| (0..count).map(|i| i as f64).collect::<Vec<_>>();
    let height = |i: usize, j: usize| (3.0 * i as f64 + 7.0 * j as f64).sin();
    let heights: Vec<Vec<f64>> = (0..side).map(|i| (0..side).map(|j| height(i, j)).collect()).collect();
    json!({
        "nodes": {"type": "grid", "u": axis(side), "v": axis(side), "z": heights},
        "model": {"type": "polynomial", "degree": [5, 5], "basis": "chebyshev"},
        "estimator": {"type": "least_trimmed_squares", "coverage": 0.75}
    })
}

fn later(app: &TestApp, path: &str, body: &Value) -> RequestBuilder {
    app.request(Method::POST, path).header("Prefer", "respond-async").json(body)
}

/// Begins an operation: its path.
pub async fn begun(request: RequestBuilder) -> String {
    let answer = send(request).await.expect(202);
    assert_eq!((answer.header("preference-applied"), answer.header("retry-after")), (Some("respond-async"), Some("1")));
    let path = answer.header("location").unwrap().to_owned();
    assert_eq!(path, format!("/v1/operations/{}", answer.json()["id"].as_str().unwrap()));
    path
}

/// The operation once it stands so.
async fn once(app: &TestApp, path: &str, seen: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let operation = app.get(path).await.expect(200).json();
        if seen(&operation) {
            return operation;
        }
        assert!(begun.elapsed() < PATIENCE, "{operation}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

async fn result(app: &TestApp, path: &str) -> Answer {
    send(app.request(Method::GET, &format!("{path}/result")).header("Prefer", "wait=60")).await
}

/// What differs between two answers: whose they are, when, and how they were sent.
const OF_ONE_ANSWER: [&str; 5] = ["x-request-id", "date", "preference-applied", "content-length", "transfer-encoding"];

fn headers(answer: &Answer) -> Vec<(String, String)> {
    let kept = answer.headers.iter().filter(|(name, _)| !OF_ONE_ANSWER.contains(&name.as_str()));
    let mut kept: Vec<_> = kept.map(|(name, value)| (name.to_string(), value.to_str().unwrap().to_owned())).collect();
    kept.sort();
    kept
}

#[track_caller]
fn same(later: &Answer, plain: &Answer) {
    assert_eq!((later.status, headers(later)), (plain.status, headers(plain)));
    assert!(later.text == plain.text, "{}\n{}", later.text, plain.text);
}

/// A text without what differs between two that tell the same of two jobs: ids, digests and times.
fn masked(text: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || "-:.".contains(c);
    let without = |piece: &str| {
        let word = piece.trim_end_matches(|c: char| !is_word(c));
        let is_digest = word.len() == 64 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
        let is_id = word.len() == 36 && Uuid::try_parse(word).is_ok();
        let differs = is_digest || is_id || word.parse::<Timestamp>().is_ok();
        if differs { piece.replacen(word, "*", 1) } else { piece.to_owned() }
    };
    text.split_inclusive(|c: char| !is_word(c)).map(without).collect()
}

/// The same of another job.
#[track_caller]
fn alike(later: &Answer, plain: &Answer) {
    let seen = |answer: &Answer| {
        let headers = headers(answer).into_iter().map(|(name, value)| (name, masked(&value)));
        (answer.status, headers.collect::<Vec<_>>())
    };
    assert_eq!(seen(later), seen(plain));
    assert!(masked(&later.text) == masked(&plain.text), "{}\n{}", later.text, plain.text);
}

#[test]
fn only_what_is_of_one_answer_is_masked() {
    let (id, other) = ("01a21a63-e043-75e8-bf7a-ca9fabb79b0c", "01a21a67-d6cb-709d-9f40-61dd88f6318c");
    let text = |id: &str, at: &str| format!(r#"{{"id":"{id}","created_at":"{at}","x":-1.5,"etag":"\"2\""}}"#);
    let first = text(id, "2026-11-27T00:24:44.944705Z");
    assert_eq!(masked(&first), text("*", "*"));
    assert_eq!(masked(&first), masked(&text(other, "2026-11-28T01:02:03Z")));
    assert_eq!(masked(&format!("/v1/jobs/{id}/iterations/2")), "/v1/jobs/*/iterations/2");
    assert_eq!(masked(&format!("{}:1", "0f".repeat(32))), format!("{}:1", "0f".repeat(32)), "a part of a word");
}
