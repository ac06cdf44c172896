//! Ids, health, metrics, keys, compression of responses, overload, shutdown.

use std::{io::Read, net::SocketAddr};

use flankfit::{
    app::App,
    config::{Digest, ServeSettings},
};
use reqwest::header;
use sha2::Digest as _;

use crate::harness::{CURVE, TestApp, WAITING_CURVE, ready, send};

#[tokio::test]
async fn every_answer_has_a_request_id() {
    let app = TestApp::start().await;
    for path in ["/healthz", "/readyz", "/metrics", "/openapi.json", "/docs/", "/nothing"] {
        let id = send(app.get(path)).await.header("x-request-id").to_owned();
        assert_eq!(id.len(), 36, "{path}");
        assert_eq!(id.as_bytes()[14], b'7', "UUIDv7: {id}");
    }
    let answer = send(app.get("/nothing").header("x-request-id", "line-4/shift-2")).await;
    assert_eq!(answer.header("x-request-id"), "line-4/shift-2");
    answer.problem(404, "not_found");
    for insane in ["", "two words", &"x".repeat(200)] {
        let answer = send(app.get("/healthz").header("x-request-id", insane)).await;
        assert_eq!(answer.header("x-request-id").len(), 36, "{insane}");
    }
}

#[tokio::test]
async fn health_and_readiness() {
    let app = TestApp::start().await;
    for answer in [send(app.get("/healthz")).await, ready(&app.get("/readyz")).await] {
        assert_eq!(answer.status, 200);
        assert_eq!(answer.json()["status"], "ok");
        assert_eq!(answer.json()["engine"], "flankfit 0.1.0");
    }
}

#[tokio::test]
async fn metrics_count_requests_by_route_and_status() {
    let app = TestApp::start().await;
    assert_eq!(app.fit(CURVE).await.status, 200);
    app.fit("{}").await.problem(422, "invalid_request");
    send(app.get("/some/url/nobody/has")).await.problem(404, "not_found");
    let answer = send(app.get("/metrics")).await;
    assert!(answer.header("content-type").starts_with("text/plain"));
    for line in [
        r#"flankfit_http_requests_total{method="POST",path="/v1/fits",status="200"}"#,
        r#"flankfit_http_requests_total{method="POST",path="/v1/fits",status="422"}"#,
        r#"path="unmatched",status="404""#,
        r#"flankfit_http_request_duration_seconds_bucket{method="POST",path="/v1/fits",status="200""#,
        r#"flankfit_fit_duration_seconds_bucket{size="le_100""#,
        // other tests of this process may have fits waiting
        "\nflankfit_fit_queue_depth ",
    ] {
        assert!(answer.text.contains(line), "{line}\n{}", answer.text);
    }
    assert!(!answer.text.contains("nobody"), "URLs are no labels");
}

#[tokio::test]
async fn keys_are_required_if_there_are_any() {
    let digest = Digest(sha2::Sha256::digest(b"a-long-random-key").into());
    let app = TestApp::start_with(|settings| settings.api_keys_sha256 = vec![digest]).await;
    let answer = app.fit(CURVE).await;
    answer.problem(401, "unauthorized");
    assert_eq!(answer.header("www-authenticate"), "Bearer");
    let wrong = send(app.post("/v1/fits", CURVE).bearer_auth("wrong")).await;
    wrong.problem(401, "invalid_key");
    assert_eq!(wrong.header("www-authenticate"), "Bearer error=\"invalid_token\"");
    assert_eq!(send(app.post("/v1/fits", CURVE).bearer_auth("a-long-random-key")).await.status, 200);
    assert_eq!(send(app.post("/v1/fits", CURVE).header("x-api-key", "a-long-random-key")).await.status, 200);
    assert_eq!(send(app.get("/healthz")).await.status, 200);
}

#[tokio::test]
async fn responses_are_compressed_on_request() {
    let app = TestApp::start().await;
    let plain = app.fit(CURVE).await;
    assert_eq!(plain.header("content-encoding"), "");
    for name in ["gzip", "zstd"] {
        let request = app.post("/v1/fits", CURVE).header(header::ACCEPT_ENCODING, name);
        let response = request.send().await.unwrap();
        assert_eq!(response.headers()["content-encoding"], name);
        assert_eq!(response.headers()["x-request-id"].len(), 36);
        let bytes = response.bytes().await.unwrap();
        assert!(bytes.len() < plain.text.len() * 2 / 3, "{name}: {} of {}", bytes.len(), plain.text.len());
        let mut text = String::new();
        match name {
            "gzip" => flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap(),
            _ => zstd::Decoder::new(&bytes[..]).unwrap().read_to_string(&mut text).unwrap(),
        };
        assert_eq!(text, plain.text);
    }
}

fn one_worker(settings: &mut ServeSettings) {
    settings.workers = 1;
    settings.queue = 1;
    settings.request_timeout = 1;
}

#[tokio::test]
async fn a_full_queue_returns_503_and_retry_after() {
    let app = TestApp::start_with(|settings| {
        one_worker(settings);
        settings.request_timeout = 60;
    })
    .await;
    let busy = app.occupy_worker().await;
    let waiting = tokio::spawn(send(app.post("/v1/fits", WAITING_CURVE)));
    app.until_waiting(1).await;
    assert!(send(app.get("/metrics")).await.text.contains("flankfit_fit_queue_depth"));
    let answer = app.fit(WAITING_CURVE).await;
    answer.problem(503, "overloaded");
    assert_eq!(answer.header("retry-after"), "1");
    // what is short is done all the same
    assert_eq!(app.fit(CURVE).await.status, 200);
    drop(busy);
    assert_eq!(waiting.await.unwrap().status, 200);
    assert_eq!(app.fit(WAITING_CURVE).await.status, 200);
}

#[tokio::test]
async fn an_answer_that_takes_too_long_is_503() {
    let app = TestApp::start_with(one_worker).await;
    let busy = app.occupy_worker().await;
    let answer = app.fit(WAITING_CURVE).await;
    answer.problem(503, "request_timeout");
    assert_eq!(answer.header("retry-after"), "5");
    drop(busy);
    let freed = std::time::Instant::now();
    // The abandoned request is skipped: it is not in anybody's way.
    let next = loop {
        let answer = app.fit(WAITING_CURVE).await;
        if answer.status != 503 {
            break answer;
        }
        // a busy machine may hold this one up for as long
        answer.problem(503, "request_timeout");
        assert!(freed.elapsed() < std::time::Duration::from_secs(60), "it is in the way");
    };
    assert_eq!(next.status, 200, "{}", next.text);
}

#[tokio::test]
async fn a_shutdown_finishes_only_accepted_requests() {
    let app = TestApp::start_with(|settings| {
        one_worker(settings);
        settings.request_timeout = 60;
    })
    .await;
    let address = app.address;
    let busy = app.occupy_worker().await;
    let waiting = tokio::spawn(send(app.post("/v1/fits", WAITING_CURVE)));
    app.until_waiting(1).await;
    let stopping = tokio::spawn(app.stop());
    while tokio::net::TcpStream::connect(address).await.is_ok() {
        tokio::task::yield_now().await;
    }
    assert!(!waiting.is_finished() && !stopping.is_finished());
    drop(busy);
    assert_eq!(waiting.await.unwrap().status, 200);
    stopping.await.unwrap();
}

#[tokio::test]
async fn a_shutdown_waits_no_longer_than_its_grace() {
    let app = TestApp::start_with(|settings| {
        one_worker(settings);
        settings.request_timeout = 60;
        settings.shutdown_grace = 0;
    })
    .await;
    let busy = app.occupy_worker().await;
    let waiting = tokio::spawn(app.post("/v1/fits", WAITING_CURVE).send());
    app.until_waiting(1).await;
    // with the worker still at work
    app.stop().await;
    let _cut_off_or_refused = waiting.await.unwrap();
    drop(busy);
}

#[tokio::test]
async fn a_taken_port_is_a_clear_error() {
    let app = TestApp::start().await;
    let settings = ServeSettings {
        bind: app.address,
        database_url: format!("sqlite://{}", app.directory.path().join("other.db").display()),
        ..ServeSettings::default()
    };
    match App::start(settings).await {
        Err(error) => {
            let said =
                format!("{} is taken by another program; choose another with --bind or FLANKFIT_BIND", app.address);
            assert_eq!(error.to_string(), said);
        }
        Ok(_) => panic!("the port is taken"),
    }
    let _: SocketAddr = app.address;
}
