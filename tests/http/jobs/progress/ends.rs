//! Content of events, and the ends of a response with progress.

use std::time::{Duration, Instant};

use axum::body::Bytes;
use flankfit::jobs::Role;
use http_body_util::StreamBody;
use hyper::body::Frame;
use reqwest::Method;
use serde_json::{Value, json};

use super::{Entry, Events, eager, posted, problem, result, slow_iteration, study, with_progress};
use crate::{
    access::keys::key_of,
    cancellation::dear,
    harness,
    jobs::app::{TestApp, iteration, send},
};

const STUDIES: &str = "/v1/studies/randomization";

async fn until_rest(app: &TestApp) {
    while app.state().pool.busy() > 0 {
        tokio::task::yield_now().await;
    }
}

async fn iterations(app: &TestApp, job: &str) -> usize {
    app.get(&format!("{job}/trace")).await.expect(200).json()["iterations"].as_array().unwrap().len()
}

/// A fit that takes minutes.
fn endless() -> Value {
    serde_json::from_slice(&dear::lp().bytes).unwrap()
}

/// A server whose events begin at once, with one worker.
async fn one_worker() -> TestApp {
    let settings = |settings: &mut flankfit::config::ServeSettings| {
        (settings.workers, settings.pace.look) = (1, Duration::ZERO);
    };
    TestApp::around(harness::TestApp::start_with(settings).await)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_share_that_is_done_grows_up_to_the_result() {
    let app = eager().await;
    let (shares, name, data) = Events::of(posted(&app, STUDIES, &study(1500))).await.into_end().await;
    assert_eq!(name, "result");
    assert!(shares.iter().any(|share| *share > 0.0 && *share < 1.0), "{shares:?}");
    assert_eq!(data, app.post(STUDIES, &study(1500)).await.expect(200).text);
}

/// A problem that is found at once is that of the plain request.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn errors_that_are_found_at_once_have_their_own_status() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.pace.look = super::PATIENCE).await);
    let job = app.job().await;
    let mut wrong = study(300);
    wrong["levels"] = json!([-1]);
    let cases = [
        (format!("{job}/iterations"), json!({"nodes": 1}), 422),
        ("/v1/jobs/0190b0de-0000-7000-8000-000000000000/iterations".to_owned(), slow_iteration(), 404),
        (STUDIES.to_owned(), wrong, 422),
        ("/v1/fits?no_such=1".to_owned(), iteration(), 422),
    ];
    for (path, body, status) in cases {
        let mut plain = app.post(&path, &body).await.expect(status).json();
        let refused = send(posted(&app, &path, &body)).await.expect(status);
        assert_eq!(refused.header("content-type"), Some("application/problem+json"));
        plain["request_id"] = json!(refused.header("x-request-id"));
        assert_eq!(refused.json(), plain, "{path}");
    }
    let foreign = with_progress(app.request(Method::POST, "/v1/fits")).header("content-type", "text/plain");
    send(foreign.body("x")).await.problem(415, "unsupported_media_type");
    // an operation that is quick has no events, and a client may prefer the plain answer
    send(posted(&app, "/v1/jobs", &json!({"name": "w"}))).await.problem(406, "not_acceptable");
    let fit: Value = serde_json::from_str(harness::CURVE).unwrap();
    for accept in ["text/event-stream;q=0.5, application/json", "application/json, text/event-stream", "*/*"] {
        let request = app.request(Method::POST, "/v1/fits").header("accept", accept).json(&fit);
        assert_eq!(send(request).await.expect(200).header("content-type"), Some("application/json"), "{accept}");
    }
    let preferred = app.request(Method::POST, "/v1/fits").header("accept", "text/event-stream, */*");
    result(preferred.json(&fit)).await;
}

/// An error of the computation is the last event.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn errors_of_the_computation_are_the_last_event() {
    let app = one_worker().await;
    let dependent = json!({
        "nodes": {"type": "matrix", "x": [[1, 1], [2, 2], [3, 3], [4, 4]], "y": [1, 2, 3, 4]},
        "model": {"type": "linear"}, "estimator": {"type": "lp", "p": 1.5}
    });
    let mut plain = app.post("/v1/fits", &dependent).await.expect(422).json();
    // it is not found at once
    let open = app.server().occupy_worker().await;
    let mut events = Events::of(posted(&app, "/v1/fits", &dependent)).await;
    events.begun().await;
    drop(open);
    plain["request_id"] = json!(events.response.headers()["x-request-id"].to_str().unwrap());
    let (_, name, data) = events.into_end().await;
    assert_eq!((name.as_str(), serde_json::from_str::<Value>(&data).unwrap()), ("problem", plain));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn closing_the_connection_cancels_and_stores_nothing() {
    let app = eager().await;
    let job = app.job().await;
    let mut most = Duration::MAX;
    for _ in 0..20 {
        let mut events = Events::of(posted(&app, &format!("{job}/iterations"), &endless())).await;
        events.begun().await;
        while app.state().pool.busy() == 0 {
            tokio::task::yield_now().await;
        }
        let left = Instant::now();
        drop(events);
        until_rest(&app).await;
        most = most.min(left.elapsed());
        if most < Duration::from_millis(200) {
            break;
        }
    }
    println!("at rest {most:?} after the client left");
    assert!(most < Duration::from_millis(200), "{most:?}");
    assert_eq!(iterations(&app, &job).await, 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_gives_the_result_again_after_a_cut() {
    let app = eager().await;
    let job = app.job().await;
    let path = format!("{job}/iterations");
    let keyed = |body: &Value| posted(&app, &path, body).header("idempotency-key", "k");
    // cut while it is computed: the key is free again once the work has ended
    let mut cut = Events::of(keyed(&endless())).await;
    cut.begun().await;
    drop(cut);
    until_rest(&app).await;
    let answered = loop {
        let response = keyed(&slow_iteration()).send().await.unwrap();
        if response.status() != 409 {
            break response;
        }
    };
    let (_, name, first) = Events::over(answered).into_end().await;
    assert_eq!(name, "result");
    // cut before the result was read: it is stored once, and given again
    let again = Events::of(keyed(&slow_iteration())).await.into_end().await;
    assert_eq!((again.1.as_str(), again.2), ("result", first.clone()));
    assert_eq!(app.post_keyed(&path, "k", &slow_iteration()).await.expect(201).text, first);
    app.post_keyed(&path, "k", &iteration()).await.problem(422, "idempotency_key_reused");
    assert_eq!(iterations(&app, &job).await, 1);
}

/// While all workers are busy nothing is reported; comments keep proxies awake, and the time of a
/// plain request does not apply.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn comments_continue_past_the_request_timeout() {
    let app = TestApp::around(
        harness::TestApp::start_with(|settings| {
            settings.workers = 1;
            settings.request_timeout = 1;
            settings.pace.comment = Duration::from_millis(20);
        })
        .await,
    );
    let open = app.server().occupy_worker().await;
    let begun = Instant::now();
    let mut events = Events::of(posted(&app, STUDIES, &study(40))).await;
    events.begun().await;
    while begun.elapsed() < Duration::from_millis(1500) {
        assert!(matches!(events.next().await, Some(Entry::Comment)));
    }
    drop(open);
    assert_eq!(events.into_end().await.1, "result");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_time_of_an_answer_with_progress_is_bounded() {
    let app = TestApp::around(
        harness::TestApp::start_with(|settings| {
            settings.progress_timeout = 1;
            settings.pace.look = Duration::ZERO;
        })
        .await,
    );
    let late = problem(posted(&app, "/v1/fits", &endless())).await;
    assert_eq!((&late["status"], &late["code"]), (&json!(503), &json!("request_timeout")));
    assert_eq!(late["detail"], "There was no response within 1 s.");
    until_rest(&app).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_work_of_a_revoked_key_ends() {
    let app = TestApp::around(
        harness::TestApp::start_with(|settings| {
            (settings.auth, settings.workers) = (flankfit::config::Authentication::Required, 1);
            settings.pace.look = Duration::ZERO;
        })
        .await,
    );
    let [admin, own] = [Role::Admin, Role::Engineer].map(|role| key_of(app.server(), "default", role));
    let (admin, own) = (admin.await, own.await);
    let open = app.server().occupy_worker().await;
    let mut events = Events::of(posted(&app, STUDIES, &study(40)).bearer_auth(&own)).await;
    events.begun().await;
    let refused = answered(&app, 401).await;
    let revoking = app.request(Method::DELETE, &format!("/v1/keys/{}", &own[4..20]));
    send(revoking.bearer_auth(&admin)).await.expect(204);
    let (_, name, data) = events.into_end().await;
    assert!(name == "problem" && data.contains("\"invalid_key\""), "{data}");
    drop(open);
    // it counts by its end
    assert!(answered(&app, 401).await > refused);
}

/// How many studies were answered with a status.
async fn answered(app: &TestApp, status: u16) -> f64 {
    let series = format!("flankfit_http_requests_total{{method=\"POST\",path=\"{STUDIES}\",status=\"{status}\"}} ");
    let metrics = app.get("/metrics").await.text;
    metrics.lines().find_map(|line| line.strip_prefix(&series)).map_or(0.0, |count| count.parse().unwrap())
}

/// A finished result is not lost because others have the memory.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_result_is_sent_even_if_memory_is_exhausted() {
    let settings = |settings: &mut flankfit::config::ServeSettings| {
        (settings.body_memory, settings.pace.look) = (1 << 20, Duration::ZERO);
    };
    let app = TestApp::around(harness::TestApp::start_with(settings).await);
    let mut events = Events::of(posted(&app, STUDIES, &study(1500))).await;
    while !matches!(events.next().await, Some(Entry::Event { data, .. }) if !data.contains("\"progress\":0.0")) {}
    let mut others = app.state().budget.permit();
    others.force(1 << 20);
    let (_, name, data) = events.into_end().await;
    assert!(name == "result" && data.len() > 4 << 10, "{name} {}", data.len());
}

/// The header is sent if the response is known before the events begin.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_replayed_result_is_marked() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.pace.look = super::PATIENCE).await);
    let path = format!("{}/iterations", app.job().await);
    for replayed in [None, Some("true")] {
        let events = Events::of(posted(&app, &path, &iteration()).header("idempotency-key", "k")).await;
        let header = events.response.headers().get("idempotency-replayed");
        assert_eq!(header.map(|value| value.to_str().unwrap()), replayed);
        assert_eq!(events.into_end().await.1, "result");
    }
}

/// A body is counted once in the budget, and its length need not be known.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_large_request_is_taken_as_it_is_without_progress() {
    let app = TestApp::around(harness::TestApp::start_with(|settings| settings.body_memory = 3 << 20).await);
    let text = format!("{}{}", " ".repeat(2 << 20), study(40));
    let request = || app.request(Method::POST, STUDIES).header("content-type", "application/json");
    let plain = send(request().body(text.clone())).await.expect(200);
    let length_unknown = || {
        let pieces = text.as_bytes().chunks(100_000).map(|piece| Frame::data(Bytes::from(piece.to_vec())));
        let pieces: Vec<_> = pieces.map(Ok::<_, std::io::Error>).collect();
        reqwest::Body::wrap(StreamBody::new(futures_util::stream::iter(pieces)))
    };
    for body in [reqwest::Body::from(text.clone()), length_unknown()] {
        while app.state().budget.held() > 0 {
            tokio::task::yield_now().await;
        }
        assert_eq!(result(with_progress(request()).body(body)).await, plain.text);
    }
}

/// A server that stops gives its requests their grace, and then ends them with a problem.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stopping_server_ends_its_work_with_a_problem() {
    let app = eager().await;
    let mut events = Events::of(posted(&app, "/v1/fits", &endless())).await;
    events.begun().await;
    app.state().pool.stop();
    let (_, name, data) = events.into_end().await;
    assert!(name == "problem" && data.contains("\"status\":503"), "{data}");
}
