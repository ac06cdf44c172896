//! State after an end: a free key, a stream that continues, a process that has ended, the same
//! numbers as ever.

use std::time::{Duration, Instant};

use super::dear;
use crate::{
    harness,
    jobs::{
        app::{TestApp, iteration},
        kill::Server,
    },
};
use flankfit::api::fits::service;
use flankfit_engine::numerics::cancel::Handle;
use serde_json::json;
use tokio::io::AsyncWriteExt;

/// A request whose client can leave; it is at work when this returns.
async fn begun(app: &TestApp, path: &str, headers: &str, body: &str) -> tokio::net::TcpStream {
    let mut stream = tokio::net::TcpStream::connect(app.base.trim_start_matches("http://")).await.unwrap();
    let head = format!(
        "POST {path} HTTP/1.1\r\nhost: [::1]\r\ncontent-type: application/json\r\ncontent-length: {}\r\n{headers}\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(body.as_bytes()).await.unwrap();
    while app.state().pool.busy() == 0 {
        tokio::task::yield_now().await;
    }
    stream
}

async fn until_rest(app: &TestApp) {
    while app.state().pool.busy() > 0 {
        tokio::task::yield_now().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_is_free_once_its_client_has_left_while_computing() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/iterations");
    let gone = begun(&app, &path, "idempotency-key: k\r\n", &String::from_utf8(dear::lp().bytes).unwrap()).await;
    app.post_keyed(&path, "k", &iteration()).await.problem(409, "idempotency_key_in_use");
    drop(gone);
    // the key is given back when the server has noticed, not before
    let created = loop {
        let answer = app.post_keyed(&path, "k", &iteration()).await;
        if answer.status != 409 {
            break answer.expect(201);
        }
        answer.problem(409, "idempotency_key_in_use");
    };
    assert_eq!(created.json()["number"], 1);
    let again = app.post_keyed(&path, "k", &iteration()).await.expect(201);
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.text, created.text);
    until_rest(&app).await;
    let trace = app.get(&format!("{job}/trace")).await.expect(200).json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_goes_on_after_a_client_that_left_with_its_block() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let stream = app.stream(&job, &dear::stream()).await;
    let path = format!("{stream}/nodes");
    let gone = begun(&app, &path, "", &String::from_utf8(dear::block().bytes).unwrap()).await;
    drop(gone);
    until_rest(&app).await;
    let small = json!({"sequence": 1, "nodes": {"type": "scattered", "u": [0.5], "v": [0.25], "z": [1.0]}});
    let answer = app.post(&path, &small).await.expect(200);
    assert_eq!(answer.json()["node_count"], 1);
    let repeated = app.post(&path, &small).await.expect(200);
    assert_eq!(repeated.text, answer.text);
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_socket_that_closes_takes_its_block_along() {
    use futures_util::SinkExt;
    use tokio_tungstenite::{connect_async, tungstenite::Message};

    let mut app = TestApp::start().await;
    let job = app.job().await;
    let stream = app.stream(&job, &dear::stream()).await;
    let url = format!("{}{stream}/ws", app.base.replace("http://", "ws://"));
    let mut socket = connect_async(url).await.expect("a WebSocket").0;
    socket.send(Message::text(String::from_utf8(dear::block().bytes).unwrap())).await.unwrap();
    while app.state().pool.busy() == 0 {
        tokio::task::yield_now().await;
    }
    drop(socket);
    until_rest(&app).await;
    let view = app.get(&stream).await.expect(200).json();
    assert_eq!((view["sequence"].as_u64(), view["node_count"].as_u64()), (Some(0), Some(0)));
    app.stop().await;
}

#[tokio::test]
async fn the_time_of_a_request_ends_its_work() {
    let app = harness::TestApp::start_with(|settings| {
        settings.workers = 1;
        settings.request_timeout = 1;
    })
    .await;
    app.fit(&String::from_utf8(dear::lp().bytes).unwrap()).await.problem(503, "request_timeout");
    // the worker is free for the next one
    let ended = Instant::now();
    let next = loop {
        let answer = app.fit(harness::CURVE).await;
        if answer.status != 503 {
            break answer;
        }
        // a busy machine may hold this one up for as long; alone the first would go on for minutes
        answer.problem(503, "request_timeout");
        assert!(ended.elapsed() < Duration::from_secs(30), "the worker goes on");
    };
    assert_eq!(next.status, 200, "{}", next.text);
}

/// SIGTERM while a fit runs for minutes: the process is gone when its grace is over.
#[test]
fn a_stop_ends_whatever_runs() {
    const GRACE: Duration = Duration::from_secs(1);
    let directory = tempfile::tempdir().unwrap();
    let database = directory.path().join("jobs.db");
    let mut server = Server::start_with(&database, &["--workers", "1", "--shutdown-grace", "1"]);
    let address = server.base.trim_start_matches("http://").to_owned();
    let _waiting: Vec<_> = (0..3).map(|_| super::registry::sent(&address, "/v1/fits", &dear::lp())).collect();
    while super::registry::Metrics::of(&address).busy == 0 {
        std::thread::yield_now();
    }
    let begun = Instant::now();
    server.terminate();
    let status = loop {
        if let Some(status) = server.ended() {
            break status;
        }
        std::thread::sleep(Duration::from_millis(5));
        assert!(begun.elapsed() < Duration::from_secs(60), "it goes on");
    };
    let took = begun.elapsed();
    println!("gone {took:?} after SIGTERM");
    assert!(status.success(), "{status}");
    assert!(took >= GRACE, "the fit had its grace: {took:?}");
    // with the delays of a busy machine
    assert!(took < GRACE + Duration::from_secs(20), "{took:?}");
}

/// A handle that is never cancelled changes no bit.
#[test]
fn fits_under_a_handle_have_the_same_bits() {
    for text in [
        include_str!("../../../examples/requests/fit_grid.json"),
        include_str!("../../../examples/requests/fit_lp.json"),
        include_str!("../../../examples/requests/fit_least_trimmed.json"),
        include_str!("../../../examples/requests/fit_rank.json"),
        include_str!("../../../examples/requests/fit_tikhonov.json"),
        include_str!("../../../examples/requests/fit_filtered.json"),
        include_str!("../../../examples/requests/fit_scattered.json"),
    ] {
        let run = || service::fit_json(text.as_bytes()).unwrap();
        let handle = Handle::new();
        assert_eq!(handle.run(run).unwrap(), run());
    }
}
