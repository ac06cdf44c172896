//! PostgreSQL is away for less than the patience of the servers, but for longer than the proxy
//! takes to see that none of them is ready: whoever asks meanwhile waits, and nobody is refused.

use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::{Value, json};
use tokio::{
    task::{JoinSet, spawn_blocking},
    time::sleep,
};

use super::{proxy::Proxy, rolling::until_ready};
use crate::{
    jobs::{
        app::{iteration, send},
        kill,
        streams::{block, spec},
    },
    postgres::{Server, shell},
};

/// A busy machine takes its time to start the database.
const WAITING: [&str; 2] = ["--store-patience", "60"];
const PATIENCE: Duration = Duration::from_secs(60);
/// Messages of the proxy on a backend without a ready server.
const NONE: [&str; 2] = ["jobs has no server available", "streams has no server available"];

async fn run(server: &Server, script: &str) {
    let mut command = shell(&server.folder, script);
    let done = spawn_blocking(move || command.status()).await.unwrap().unwrap();
    assert!(done.success(), "{script}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(any(without_postgres, without_haproxy), ignore = "there is no PostgreSQL server, or no haproxy")]
async fn a_restart_of_the_database_is_nothing_but_a_longer_answer() {
    let server = Server::start();
    let url = server.database().await;
    let proxy = Proxy::start(3);
    let replicas = proxy.servers.map(|address| kill::Server::start_at(address, &url, &WAITING));
    until_ready(&proxy.base).await;
    let client = Client::builder().no_proxy().retry(reqwest::retry::never()).build().unwrap();
    let post = |path: &str, body: &Value| client.post(format!("{}{path}", proxy.base)).json(body);
    let made = async |path: &str, body: &Value| {
        let answer = send(post(path, body)).await.expect(201);
        answer.header("location").unwrap().to_owned()
    };
    let job = made("/v1/jobs", &json!({"name": "wheel"})).await;
    let stream = made(&format!("{job}/streams"), &spec()).await;

    run(&server, "$BIN/pg_ctl -D data -m fast -w stop").await;
    let begun = Instant::now();
    while NONE.iter().any(|none| !proxy.log().contains(none)) {
        assert!(begun.elapsed() < PATIENCE, "{}", proxy.log());
        sleep(Duration::from_millis(50)).await;
    }
    let mut asked = JoinSet::new();
    for request in [
        post("/v1/jobs", &json!({"name": "pinion"})),
        post(&format!("{job}/iterations"), &iteration()),
        post(&format!("{stream}/nodes"), &block(1, 0..40)),
        client.get(format!("{}{job}", proxy.base)),
    ] {
        asked.spawn(send(request));
    }
    // they are on their way while it is away
    sleep(Duration::from_millis(500)).await;
    run(&server, "$BIN/pg_ctl -D data -l log -w start").await;
    for answer in asked.join_all().await {
        assert!(answer.status.is_success(), "{} {}\n{}", answer.status, answer.text, proxy.log());
    }
    until_ready(&proxy.base).await;
    replicas.into_iter().for_each(kill::Server::kill);
}
