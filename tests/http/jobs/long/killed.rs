//! Servers that are killed while they do an operation: it is begun anew, and is answered and stores
//! as if nothing had been.

use std::time::{Duration, Instant};

use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use tokio::time::sleep;

use super::{alike, begun, trimmed};
use crate::{
    database::in_file,
    jobs::{
        app::{Answer, send},
        kill,
    },
    postgres::Server,
};

/// For so long an operation is waited for: its own time twice, and a lease.
const PATIENCE: Duration = Duration::from_secs(240);

/// A server and who asks it.
struct Asked {
    client: Client,
    server: kill::Server,
}

impl Asked {
    fn new(server: kill::Server) -> Self {
        Asked { client: Client::builder().no_proxy().build().unwrap(), server }
    }

    fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.server.base))
    }

    async fn get(&self, path: &str) -> Answer {
        send(self.request(Method::GET, path)).await
    }

    /// A new job's path.
    async fn job(&self) -> String {
        let made = send(self.request(Method::POST, "/v1/jobs").json(&json!({"name": "wheel"}))).await.expect(201);
        made.header("location").unwrap().to_owned()
    }

    /// Returns once a server does the operation.
    async fn until_running(&self, operation: &str) {
        let asked = Instant::now();
        while self.get(operation).await.expect(200).json()["state"] != "running" {
            assert!(asked.elapsed() < PATIENCE, "nobody begins");
            sleep(Duration::from_millis(20)).await;
        }
    }

    /// The answer of an operation, once it has one.
    async fn result(&self, operation: &str) -> Answer {
        let asked = Instant::now();
        loop {
            let result = self.request(Method::GET, &format!("{operation}/result")).header("Prefer", "wait=30");
            let answer = send(result).await;
            if answer.status != 409 {
                return answer;
            }
            assert!(asked.elapsed() < PATIENCE, "{operation} does not end");
        }
    }
}

/// Has the first server begin an operation. `next` kills it and answers which one is there then.
async fn is_begun_anew(first: kill::Server, body: &Value, next: impl FnOnce(kill::Server) -> kill::Server) {
    let first = Asked::new(first);
    let job = first.job().await;
    let path = format!("{job}/iterations");
    let later = first.request(Method::POST, &path).header("Idempotency-Key", "k").header("Prefer", "respond-async");
    let operation = begun(later.json(body)).await;
    first.until_running(&operation).await;
    let second = Asked::new(next(first.server));
    let made = second.result(&operation).await.expect(201);
    let told = second.get(&operation).await.expect(200).json();
    // else it had ended before its server was killed
    assert_eq!((&told["state"], &told["attempts"]), (&json!("succeeded"), &json!(2)), "{told}");
    // as what a plain request makes in a job to which nothing happened
    let calm = second.job().await;
    let plain = send(second.request(Method::POST, &format!("{calm}/iterations")).json(body)).await.expect(201);
    alike(&made, &plain);
    assert_eq!(made.header("location"), Some(format!("{path}/1").as_str()));
    // it is there once, and whoever asks again under its key is told of it
    let again = second.request(Method::POST, &path).header("Idempotency-Key", "k");
    let again = send(again.json(body)).await.expect(201);
    assert_eq!((again.header("idempotency-replayed"), &again.text), (Some("true"), &made.text));
    let trace = second.get(&format!("{job}/trace")).await.expect(200).json();
    let iterations = trace["iterations"].as_array().unwrap();
    assert_eq!((iterations.len(), &iterations[0]["id"]), (1, &made.json()["id"]), "{trace}");
    assert_eq!(second.get(&crate::jobs::audit::verify_of(&job)).await.expect(200).json()["intact"], true);
    second.server.kill();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn another_server_begins_anew_what_a_killed_one_did() {
    let url = Server::shared().database().await;
    is_begun_anew(kill::Server::start(&url), &trimmed(150), |first| {
        // else it might end before the other one is there
        first.pause();
        let second = kill::Server::start(&url);
        first.kill();
        second
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_next_start_begins_anew_what_a_killed_server_did() {
    let directory = tempfile::tempdir().unwrap();
    let url = in_file(&directory.path().join("jobs.db"));
    is_begun_anew(kill::Server::start(&url), &trimmed(150), |first| {
        first.kill();
        kill::Server::start(&url)
    })
    .await;
}
