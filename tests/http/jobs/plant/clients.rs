//! Clients of the plant: each repeats a request until it has a response, and keeps the responses.

use std::{
    sync::{
        Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use tokio::time::sleep;

use crate::jobs::{
    app::{Answer, iteration},
    events::Listener,
    kill,
    progress::{slow_iteration, with_progress},
    streams::block,
};

const MOST_BLOCKS: usize = 5000;
/// For so long a client asks again.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// The servers as their clients know them.
pub struct Plant {
    pub client: Client,
    pub base: String,
    pub over: AtomicBool,
    pub counts: Counts,
    /// Responses that should not have been.
    pub failures: Mutex<Vec<String>>,
}

/// Counts of requests and responses.
#[derive(Default)]
pub struct Counts {
    pub requests: AtomicU64,
    /// Connections that broke before an answer.
    pub broken: AtomicU64,
    /// Responses of 503, and among them those of unknown outcome.
    pub refused: AtomicU64,
    pub unknown: AtomicU64,
}

impl Counts {
    fn add(count: &AtomicU64) {
        count.fetch_add(1, Ordering::Relaxed);
    }
}

/// Response to an iteration, without its text.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Written {
    pub number: u64,
    pub id: String,
    pub key: String,
    pub sha256: [u8; 32],
}

/// The digest of an answer: there are too many to keep their texts.
pub fn sha256(text: &str) -> [u8; 32] {
    Sha256::digest(text.as_bytes()).into()
}

impl Plant {
    pub fn new(base: &str) -> Self {
        let (over, counts, failures) = Default::default();
        // what failed is not sent again unseen
        let client = Client::builder().no_proxy().retry(reqwest::retry::never()).build().unwrap();
        Plant { client, base: base.to_owned(), over, counts, failures }
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::SeqCst)
    }

    /// Repeats the request until there is a response other than 503.
    pub async fn ask(&self, path: &str, request: impl Fn(RequestBuilder) -> RequestBuilder) -> Answer {
        let begun = Instant::now();
        loop {
            Counts::add(&self.counts.requests);
            let asked = self.client.request(Method::POST, format!("{}{path}", self.base));
            if let Some(answer) = self.answered(request(asked)).await {
                return answer;
            }
            assert!(begun.elapsed() < PATIENCE, "{path} is not answered");
            sleep(Duration::from_millis(20)).await;
        }
    }

    /// An answer that is one: of a server that is there (the proxy says 502 where it has been
    /// lost), whose store is there, and that does not work on the same request already.
    async fn answered(&self, request: RequestBuilder) -> Option<Answer> {
        let broken = |_| Counts::add(&self.counts.broken);
        let response = request.send().await.map_err(broken).ok()?;
        let (status, headers) = (response.status(), response.headers().clone());
        let answer = Answer { status, headers, text: response.text().await.map_err(broken).ok()? };
        let said = |code: &str| answer.text.contains(&format!("\"code\":\"{code}\""));
        let again = matches!(status.as_u16(), 502..=504) || status == 409 && said("idempotency_key_in_use");
        if again {
            Counts::add(&self.counts.refused);
        }
        if said("outcome_unknown") {
            Counts::add(&self.counts.unknown);
        }
        (!again).then_some(answer)
    }

    pub async fn post(&self, path: &str, body: &Value) -> Answer {
        self.ask(path, |request| request.json(body)).await
    }

    /// Returns the response if it has this status; others are reported at the end, with the
    /// servers' errors.
    fn as_expected(&self, answer: Answer, status: u16) -> Option<Answer> {
        if answer.status == status {
            return Some(answer);
        }
        let said = kill::ERRORS.lock().unwrap().iter().rev().take(5).cloned().collect::<Vec<_>>();
        let failure = format!("{}: {}\n{said:#?}", answer.status, answer.text);
        eprintln!("{failure}");
        self.failures.lock().unwrap().push(failure);
        None
    }

    /// Posts the iteration that has this key.
    pub async fn post_iteration(&self, job: &str, key: &str) -> Answer {
        let mut body = iteration();
        body["note"] = json!(key);
        self.ask(&format!("{job}/iterations"), |request| request.header("Idempotency-Key", key).json(&body)).await
    }

    /// Stores iterations one after the other.
    pub async fn write(&self, writer: usize, job: &str) -> Vec<Written> {
        let mut stored = Vec::new();
        for turn in 0.. {
            if self.is_over() {
                break;
            }
            let key = format!("{writer}-{turn}");
            let answer = self.post_iteration(job, &key).await;
            if let Some(answer) = self.as_expected(answer, 201) {
                stored.push(written(&answer, key));
            }
        }
        stored
    }

    /// Stores iterations with progress, one after the other and at least one.
    pub async fn write_watched(&self, job: &str) -> Vec<Written> {
        let mut stored = Vec::new();
        let path = format!("{job}/iterations");
        for turn in 0.. {
            if self.is_over() && !stored.is_empty() {
                break;
            }
            let (key, body) = (format!("watched {turn}"), slow_iteration());
            let request = |request| with_progress(request).header("Idempotency-Key", &key).json(&body);
            let begun = Instant::now();
            stored.push(loop {
                let answer = self.ask(&path, request).await.expect(200);
                if let Some((_, data)) = answer.text.split_once("event: result\ndata: ") {
                    break written(&Answer { text: data.trim_end().to_owned(), ..answer }, key);
                }
                let refused = ["\"status\":503", "idempotency_key_in_use"];
                assert!(refused.iter().any(|said| answer.text.contains(said)), "{}", answer.text);
                assert!(begun.elapsed() < PATIENCE, "{key} does not end");
                Counts::add(&self.counts.refused);
            });
        }
        stored
    }

    /// Repeats the request until there is a response.
    pub async fn get(&self, url: &str) -> Answer {
        let begun = Instant::now();
        loop {
            Counts::add(&self.counts.requests);
            if let Some(answer) = self.answered(self.client.get(url)).await {
                return answer;
            }
            assert!(begun.elapsed() < PATIENCE, "{url} is not answered");
            sleep(Duration::from_millis(20)).await;
        }
    }

    /// Posts the blocks of a stream, each under a key of its own if `keyed`: the digests of the
    /// responses.
    pub async fn stream(&self, stream: &str, keyed: bool) -> Vec<[u8; 32]> {
        let (path, mut answers) = (format!("{stream}/nodes"), Vec::new());
        for sequence in (1..=MOST_BLOCKS).take_while(|_| !self.is_over()) {
            let (key, body) = (format!("{stream} {sequence}"), nodes(sequence));
            let request = |request: RequestBuilder| match keyed {
                true => request.header("Idempotency-Key", &key).json(&body),
                false => request.json(&body),
            };
            match self.as_expected(self.ask(&path, request).await, 200) {
                Some(answer) => answers.push(sha256(&answer.text)),
                None => break,
            }
            sleep(Duration::from_millis(10)).await;
        }
        answers
    }

    /// Listens to a job again and again: the numbers of its events in the order in which they came.
    pub async fn listen(&self, job: &str, seen: &Mutex<Vec<u64>>) {
        loop {
            let last = seen.lock().unwrap().last().map(u64::to_string);
            let request = self.client.request(Method::GET, format!("{}{job}/events", self.base));
            if let Some(mut listener) = Listener::of(request, last.as_deref()).await {
                while let Some((number, ..)) = listener.next().await {
                    seen.lock().unwrap().push(number);
                }
            }
            sleep(Duration::from_millis(20)).await;
        }
    }
}

fn written(answer: &Answer, key: String) -> Written {
    let json = answer.json();
    let id = json["id"].as_str().unwrap().to_owned();
    Written { number: json["number"].as_u64().unwrap(), id, key, sha256: sha256(&answer.text) }
}

/// A block of a stream.
pub fn nodes(sequence: usize) -> Value {
    block(sequence as u64, 5 * sequence..5 * sequence + 5)
}
