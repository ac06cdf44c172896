//! Two services on one store, each with a memory of its own: whichever gets the next block of a
//! stream, the answers are those of one service.

use std::sync::{Arc, mpsc};

use flankfit::{
    config::ServeSettings,
    http::{self, AppState},
    jobs::{Clock, JobService, OrderedIds, SystemClock},
    store::{SqliteStore, StoreSettings},
};
use serde_json::json;
use tempfile::TempDir;
use tokio::{net::TcpListener, sync::oneshot};

use super::{
    app::{Answer, TestApp, iteration, send},
    streams::{block, spec},
};

/// Services on one store.
struct Replicas {
    client: reqwest::Client,
    bases: Vec<String>,
    states: Vec<AppState>,
    _directory: TempDir,
}

impl Replicas {
    async fn start(count: usize) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let settings = StoreSettings::of_file(directory.path().join("jobs.db"));
        let store = Arc::new(SqliteStore::open(settings, SystemClock.now()).await.unwrap());
        let (mut bases, mut states) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let jobs = JobService::new(store.clone(), Arc::new(SystemClock), Arc::new(OrderedIds::new()));
            let settings = ServeSettings { workers: 2, ..ServeSettings::default() };
            let state = AppState::new(settings, jobs).unwrap();
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            bases.push(format!("http://{}", listener.local_addr().unwrap()));
            states.push(state.clone());
            tokio::spawn(async move { axum::serve(listener, http::router(state)).await });
        }
        let client = reqwest::Client::builder().no_proxy().no_gzip().build().unwrap();
        Replicas { client, bases, states, _directory: directory }
    }

    async fn post(&self, replica: usize, path: &str, body: &serde_json::Value) -> Answer {
        send(self.client.post(format!("{}{path}", self.bases[replica])).json(body)).await
    }

    fn keyed(&self, replica: usize, path: &str, key: &str, body: &serde_json::Value) -> reqwest::RequestBuilder {
        self.client.post(format!("{}{path}", self.bases[replica])).header("Idempotency-Key", key).json(body)
    }

    async fn get(&self, replica: usize, path: &str) -> Answer {
        send(self.client.get(format!("{}{path}", self.bases[replica]))).await
    }

    async fn open(&self) -> String {
        let job = self.post(0, "/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
        let streams = format!("{}/streams", job.header("location").unwrap());
        self.post(0, &streams, &spec()).await.expect(201).header("location").unwrap().to_owned()
    }
}

/// Without what names the moment.
fn without_times(answer: &Answer) -> serde_json::Value {
    let mut json = answer.json();
    for name in ["id", "job_id", "created_at", "updated_at"] {
        json.as_object_mut().unwrap().remove(name);
    }
    json
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn blocks_may_come_to_any_replica() {
    let replicas = Replicas::start(2).await;
    let alone = TestApp::start().await;
    let job = alone.job().await;
    let own = alone.post(&format!("{job}/streams"), &spec()).await.expect(201).header("location").unwrap().to_owned();
    let stream = replicas.open().await;
    let nodes = format!("{stream}/nodes");
    // each replica has an estimate of its own before the other goes on
    let turns = [0, 1, 0, 0, 0, 1, 1, 0, 1];
    for (sequence, &replica) in (1..).zip(&turns) {
        let from = 40 * (sequence as usize - 1);
        let body = block(sequence, from..from + 40);
        let answer = replicas.post(replica, &nodes, &body).await.expect(200);
        let expected = alone.post(&format!("{own}/nodes"), &body).await.expect(200);
        assert_eq!(answer.text, expected.text, "block {sequence} at replica {replica}");
        assert_eq!(answer.header("etag"), expected.header("etag"));
        // sent again, to the other one, which knows nothing of it yet
        let again = replicas.post(1 - replica, &nodes, &body).await.expect(200);
        assert_eq!(again.text, answer.text);
        let seen: Vec<_> =
            [replicas.get(0, &stream).await, replicas.get(1, &stream).await].map(|a| a.expect(200)).into();
        assert_eq!(seen[0].text, seen[1].text);
        assert_eq!(seen[0].header("etag"), answer.header("etag"));
    }
    let own = alone.get(&own).await.expect(200);
    assert_eq!(without_times(&replicas.get(0, &stream).await), without_times(&own));

    // finished where the last block did not come, and refused everywhere
    replicas.post(0, &format!("{stream}/finish"), &json!({})).await.expect(201);
    for replica in [1, 0] {
        let late = replicas.post(replica, &nodes, &block(10, 0..40)).await;
        late.problem(409, "conflict");
        assert!(late.text.contains("has become iteration 1"), "{}", late.text);
        assert_eq!(replicas.get(replica, &stream).await.expect(200).json()["state"], "finished");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_blocks_of_one_number_one_counts_wherever_they_come() {
    let replicas = Replicas::start(2).await;
    let stream = replicas.open().await;
    let nodes = format!("{stream}/nodes");
    let mut count = 0;
    for sequence in 1..=12 {
        let (one, other) = (block(sequence, 0..30), block(sequence, 30..50));
        let answers = tokio::join!(replicas.post(0, &nodes, &one), replicas.post(1, &nodes, &other));
        let answers = [answers.0, answers.1];
        let (taken, refused): (Vec<_>, Vec<_>) = answers.iter().partition(|answer| answer.status == 200);
        assert_eq!((taken.len(), refused.len()), (1, 1), "{answers:?}");
        count = taken[0].json()["node_count"].as_u64().unwrap();
        let message = format!("Block {sequence} was posted before with other nodes");
        assert!(refused[0].text.contains(&message), "{}", refused[0].text);
    }
    for replica in [0, 1] {
        let seen = replicas.get(replica, &stream).await.expect(200).json();
        assert_eq!((seen["sequence"].as_u64(), seen["node_count"].as_u64()), (Some(12), Some(count)));
    }
}

/// A key whose first request runs at another replica: both compute, one stores, and the other gives
/// that answer, or says that the key was used for another request.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_of_two_replicas_stores_under_a_key() {
    let replicas = Replicas::start(2).await;
    let job = replicas.post(0, "/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
    let path = format!("{}/iterations", job.header("location").unwrap());
    let mut another = iteration();
    another["note"] = json!("another request");
    for (key, body) in [("same", iteration()), ("other", another)] {
        // the second replica has looked for the key and waits for a worker
        let second = &replicas.states[1];
        let mut gates = Vec::new();
        for _ in 0..2 {
            let (open, gate) = mpsc::channel::<()>();
            let (begun, busy) = oneshot::channel();
            let state = second.clone();
            tokio::spawn(async move {
                let held = move || {
                    let _ = begun.send(());
                    let _ = gate.recv();
                };
                state.pool.run(held).await
            });
            busy.await.unwrap();
            gates.push(open);
        }
        let late = tokio::spawn(send(replicas.keyed(1, &path, key, &body)));
        while second.pool.waiting() == 0 {
            tokio::task::yield_now().await;
        }
        let first = send(replicas.keyed(0, &path, key, &iteration())).await.expect(201);
        drop(gates);
        let late = late.await.unwrap();
        if key == "same" {
            let late = late.expect(201);
            assert_eq!((late.header("idempotency-replayed"), &late.text), (Some("true"), &first.text));
            assert_eq!(late.header("etag"), first.header("etag"));
        } else {
            late.problem(422, "idempotency_key_reused");
        }
    }
    let trace = replicas.get(0, &path.replace("iterations", "trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 2);
}
