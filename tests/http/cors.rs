//! Web pages of other origins.

use std::collections::BTreeSet;

use flankfit::{
    config::{Digest, ServeSettings},
    http::openapi::openapi_json,
};
use reqwest::Method;
use sha2::Digest as _;

use crate::{
    harness::{Answer, CURVE, TestApp, send},
    schema::with_responses,
};

const CELL: &str = "https://cell.example";

/// Settings as the command line reads them.
fn with_origins(origins: &'static str) -> impl FnOnce(&mut ServeSettings) {
    move |settings| settings.cors_origins = flankfit::config::parse_origins(origins).unwrap()
}

/// Headers of the contract's responses, of which a page sees only the exposed ones.
fn documented_headers() -> BTreeSet<String> {
    let document = with_responses(openapi_json());
    let operations =
        document["paths"].as_object().unwrap().values().flat_map(|path| path.as_object().unwrap().values());
    let responses = operations.flat_map(|operation| operation["responses"].as_object().unwrap().values());
    let headers = responses.filter_map(|response| response["headers"].as_object());
    let names: BTreeSet<_> = headers.flat_map(|headers| headers.keys()).map(|name| name.to_lowercase()).collect();
    assert!(names.contains("idempotency-replayed") && names.contains("etag"), "{names:?}");
    names
}

async fn preflight(app: &TestApp, origin: &str, wanted: &str) -> Answer {
    let request = app.client.request(Method::OPTIONS, app.url("/v1/fits"));
    let request = request.header("origin", origin).header("access-control-request-method", "POST");
    send(request.header("access-control-request-headers", wanted)).await
}

#[tokio::test]
async fn an_allowed_origin_may_call_and_read_the_headers() {
    let app = TestApp::start_with(with_origins("http://localhost:3000, https://cell.example:443")).await;
    for (request, status) in [(app.post("/v1/fits", CURVE), 200), (app.get("/v1/nothing"), 404)] {
        let answer = send(request.header("origin", CELL)).await;
        assert_eq!(answer.status.as_u16(), status);
        assert_eq!(answer.header("access-control-allow-origin"), CELL);
        assert_eq!(answer.header("access-control-allow-credentials"), "", "no cookies");
        let exposed = answer.header("access-control-expose-headers").to_ascii_lowercase();
        for name in
            documented_headers().iter().map(String::as_str).chain(["allow", "content-disposition", "traceparent"])
        {
            assert!(exposed.split(',').any(|exposed| exposed.trim() == name), "{name}: {exposed}");
        }
        let vary: Vec<_> = answer.headers.get_all("vary").iter().map(|value| value.to_str().unwrap()).collect();
        assert!(vary.join(",").to_ascii_lowercase().contains("origin"), "{vary:?}");
    }
}

#[tokio::test]
async fn other_origins_get_no_cors_headers() {
    let app = TestApp::start_with(with_origins(CELL)).await;
    for other in ["https://other.example", "http://cell.example", "https://cell.example.evil", "null"] {
        let answer = send(app.post("/v1/fits", CURVE).header("origin", other)).await;
        // it is the browser that refuses; nothing is lost by answering
        assert_eq!((answer.status.as_u16(), answer.header("access-control-allow-origin")), (200, ""), "{other}");
        assert_eq!(preflight(&app, other, "content-type").await.header("access-control-allow-origin"), "", "{other}");
    }
}

#[tokio::test]
async fn preflights_need_no_key_and_list_the_allowed_headers() {
    let digest = Digest(sha2::Sha256::digest(b"key").into());
    let app = TestApp::start_with(|settings| {
        with_origins(CELL)(settings);
        settings.api_keys_sha256 = vec![digest];
    })
    .await;
    let wanted = "content-type,content-encoding,authorization,x-api-key,idempotency-key,if-match,if-none-match,\
                  last-event-id,x-request-id,traceparent,tracestate";
    let answer = preflight(&app, CELL, wanted).await;
    assert_eq!(answer.status, 200);
    assert_eq!(answer.header("access-control-allow-origin"), CELL);
    assert_eq!(answer.header("x-request-id").len(), 36, "what a layer answers has an id too");
    let request = app.client.request(Method::OPTIONS, app.url("/v1/fits")).header("origin", CELL);
    let named = send(request.header("access-control-request-method", "POST").header("x-request-id", "mine")).await;
    assert_eq!(named.header("x-request-id"), "mine");
    let allowed = answer.header("access-control-allow-headers").to_ascii_lowercase();
    for name in wanted.split(',') {
        assert!(allowed.split(',').any(|allowed| allowed.trim() == name), "{name}: {allowed}");
    }
    for method in ["GET", "POST", "PUT", "PATCH", "DELETE"] {
        assert!(answer.header("access-control-allow-methods").contains(method), "{method}");
    }
    // the request itself needs one, and its refusal can be read
    let answer = send(app.post("/v1/fits", CURVE).header("origin", CELL)).await;
    answer.problem(401, "unauthorized");
    assert_eq!(answer.header("access-control-allow-origin"), CELL);
    let answer = send(app.post("/v1/fits", CURVE).header("origin", CELL).header("x-api-key", "key")).await;
    assert_eq!((answer.status.as_u16(), answer.header("access-control-allow-origin")), (200, CELL));
}

#[tokio::test]
async fn without_origins_nothing_is_allowed() {
    let app = TestApp::start().await;
    let answer = send(app.post("/v1/fits", CURVE).header("origin", CELL)).await;
    assert_eq!((answer.status.as_u16(), answer.header("access-control-allow-origin")), (200, ""));
    preflight(&app, CELL, "content-type").await.problem(405, "method_not_allowed");
}
