//! What operations take of the memory that a server may have, and of its time.

use std::time::{Duration, Instant};

use axum::body::Bytes;
use http_body_util::StreamBody;
use hyper::body::Frame;
use reqwest::Method;
use serde_json::json;
use tokio::time::sleep;

use super::{PATIENCE, begun, kinds::example, later, owners::occupied, result, same, study};
use crate::{
    harness,
    jobs::app::{TestApp, send},
};

/// An answer is kept and given piece by piece: it may be longer than the memory for all requests.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_large_answer_is_never_whole_in_memory() {
    const BOUND: usize = 8 << 20;
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.body_memory = BOUND).await);
    let mut export = example("surface_export");
    (export["format"], export["samples"]) = (json!("stl_text"), json!([160, 160]));
    let path = "/v1/surfaces/export";
    let plain = app.post(path, &export).await.expect(200);
    assert!(plain.text.len() > 12 << 20, "{} bytes", plain.text.len());
    let operation = begun(later(&app, path, &export)).await;
    let budget = app.server().state.budget.clone();
    for _ in 0..2 {
        let (mut most, mut asked) = (0, std::pin::pin!(result(&app, &operation)));
        let given = loop {
            most = most.max(budget.held());
            tokio::select! {
                given = &mut asked => break given,
                () = sleep(Duration::from_millis(1)) => {}
            }
        };
        same(&given, &plain);
        assert!((1 << 16..=BOUND).contains(&most), "{most} bytes were held");
    }
    all_given_back(&app).await;
}

/// Whoever has an answer may have it a moment before its server has let go of all it took.
async fn all_given_back(app: &TestApp) {
    let asked = Instant::now();
    loop {
        let held = app.server().state.budget.held();
        if held == 0 {
            return;
        }
        assert!(asked.elapsed() < PATIENCE, "{held} bytes are still held");
        sleep(Duration::from_millis(5)).await;
    }
}

/// Whoever waits is told where the answer is, if there is no room for it at the moment.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_without_room_can_be_had_later() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.body_memory = 4 << 20).await);
    let mut export = example("surface_export");
    (export["format"], export["samples"]) = (json!("stl_text"), json!([100, 100]));
    let path = "/v1/surfaces/export";
    let plain = app.post(path, &export).await.expect(200);
    let waiting = || later(&app, path, &export).header("Idempotency-Key", "one");
    let operation = begun(waiting()).await;
    same(&result(&app, &operation).await, &plain);
    all_given_back(&app).await;
    let others = app.server().state.budget.take(3_500_000).unwrap();
    result(&app, &operation).await.problem(503, "overloaded");
    let told = send(waiting().header("Prefer", "wait=30")).await.expect(202);
    assert_eq!((told.header("location"), told.header("retry-after")), (Some(&*operation), None));
    assert_eq!(told.json()["state"], "succeeded");
    drop(others);
    same(&result(&app, &operation).await, &plain);
}

/// What is too long to be kept is given up, and says what may be done.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_beyond_what_is_kept_is_the_end_of_its_operation() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.operation_bytes = 20_000).await);
    let mut export = example("surface_export");
    (export["format"], export["samples"]) = (json!("stl_text"), json!([60, 60]));
    let operation = begun(later(&app, "/v1/surfaces/export", &export)).await;
    let refused = result(&app, &operation).await;
    refused.problem(413, "answer_too_large");
    assert!(refused.text.contains("20000 bytes") && refused.text.contains("ask for less"), "{}", refused.text);
    let told = app.get(&operation).await.expect(200).json();
    assert_eq!((&told["state"], &told["problem"]["code"]), (&json!("failed"), &json!("answer_too_large")));
}

/// A request has the room for its body once, whether it is answered now or later.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_large_request_is_taken_later_as_it_is_at_once() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.body_memory = 3 << 20).await);
    let path = "/v1/studies/randomization";
    let text = format!("{}{}", " ".repeat(2 << 20), study(40));
    let json = ("content-type", "application/json");
    let request = || app.request(Method::POST, path).header(json.0, json.1);
    let plain = send(request().body(text.clone())).await.expect(200);
    all_given_back(&app).await;
    let length_unknown = || {
        let pieces = text.as_bytes().chunks(100_000).map(|piece| Frame::data(Bytes::from(piece.to_vec())));
        let pieces: Vec<_> = pieces.map(Ok::<_, std::io::Error>).collect();
        reqwest::Body::wrap(StreamBody::new(futures_util::stream::iter(pieces)))
    };
    for body in [reqwest::Body::from(text.clone()), length_unknown()] {
        let operation = begun(request().header("Prefer", "respond-async").body(body)).await;
        assert_eq!(result(&app, &operation).await.expect(200).text, plain.text);
        all_given_back(&app).await;
    }
}

/// Whoever is told of faults, or that the request is kept, waits for none of those who compute.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_are_told_while_all_workers_are_busy() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.workers = 2).await);
    let open = occupied(&app.server().state, 2).await;
    let asked = Instant::now();
    let path = "/v1/studies/randomization";
    let mut wrong = study(300);
    wrong["levels"] = json!([-1]);
    let refused = send(later(&app, path, &wrong)).await;
    refused.problem(422, "invalid_request");
    assert!(refused.text.contains("/levels/0"), "{}", refused.text);
    let operation = begun(later(&app, path, &study(40))).await;
    // no worker was free so long, and nothing was given up for want of one
    assert!(asked.elapsed() < Duration::from_secs(8), "{:?}", asked.elapsed());
    drop(open);
    assert_eq!(result(&app, &operation).await.expect(200).json()["repetitions"], 40);
}
