//! Requests that somebody got wrong in whatever way: never a 5xx, every 4xx a problem.

use std::sync::OnceLock;

use axum::{
    Router,
    body::Body,
    http::{Method, Request},
};
use flankfit::{
    api::examples::REQUEST_EXAMPLES,
    app::App,
    config::{Authentication, ServeSettings},
    http::router,
};
use http_body_util::BodyExt;
use proptest::prelude::*;
use tokio::runtime::Runtime;
use tower::ServiceExt;

/// One router for all cases: what one request does must not touch the next.
fn service() -> &'static (Runtime, Router, tempfile::TempDir) {
    static SERVICE: OnceLock<(Runtime, Router, tempfile::TempDir)> = OnceLock::new();
    SERVICE.get_or_init(|| {
        let runtime = Runtime::new().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let settings = ServeSettings {
            bind: "127.0.0.1:0".parse().unwrap(),
            database_url: format!("sqlite://{}", folder.path().join("mutations.db").display()),
            workers: 2,
            auth: Authentication::Off,
            body_limit: 64 * 1024,
            ..ServeSettings::default()
        };
        let app = runtime.block_on(App::start(settings)).unwrap();
        (runtime, router(app.state().clone()), folder)
    })
}

/// Status, content type and body of an answer.
fn answer(request: Request<Body>) -> (u16, String, Vec<u8>) {
    let (runtime, router, _) = service();
    runtime.block_on(async {
        let response = router.clone().oneshot(request).await.unwrap();
        let status = response.status().as_u16();
        let media = response.headers().get("content-type").map_or("", |value| value.to_str().unwrap()).to_owned();
        (status, media, response.into_body().collect().await.unwrap().to_bytes().to_vec())
    })
}

fn check(request: Request<Body>) -> Result<(), TestCaseError> {
    let shown = format!("{request:?}");
    let (status, media, body) = answer(request);
    let text = String::from_utf8_lossy(&body);
    prop_assert!(status < 500, "{shown}: {status} {text}");
    if status >= 400 {
        prop_assert_eq!(&media, "application/problem+json", "{}", shown);
        let problem: serde_json::Value =
            serde_json::from_slice(&body).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(&problem["status"], status);
        prop_assert!(problem["request_id"].is_string());
    } else if status == 200 {
        prop_assert!(!text.contains("null"), "{shown}: {text}");
    }
    Ok(())
}

fn post(body: impl Into<Body>) -> Request<Body> {
    Request::post("/v1/fits").header("content-type", "application/json").body(body.into()).unwrap()
}

/// Replacements for a value.
fn replacement() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("null".to_owned()),
        Just("true".to_owned()),
        Just("{}".to_owned()),
        Just("[]".to_owned()),
        Just("[[]]".to_owned()),
        Just("\"\"".to_owned()),
        Just("\"text\"".to_owned()),
        Just("-1".to_owned()),
        Just("0".to_owned()),
        Just("1e308".to_owned()),
        Just("-1e400".to_owned()),
        Just("5e-324".to_owned()),
        Just("18446744073709551615".to_owned()),
        Just("99999999999999999999999".to_owned()),
        Just("NaN".to_owned()),
        "[0-9]{1,3}(\\.[0-9]{1,3})?(e-?[0-9]{1,3})?",
        any::<f64>().prop_map(|value| format!("{value:e}")),
    ]
}

/// The beginnings and ends of the numbers, words and strings of a text.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut begin = None;
    for (i, byte) in text.bytes().enumerate() {
        let inside = byte.is_ascii_alphanumeric() || b"\"_.-+".contains(&byte);
        match (inside, begin) {
            (true, None) => begin = Some(i),
            (false, Some(from)) => {
                found.push((from, i));
                begin = None;
            }
            _ => {}
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    #[test]
    fn values_are_replaced(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), replacement()), 1..4),
    ) {
        let mut text = which.get(REQUEST_EXAMPLES).text.to_owned();
        for (place, value) in changes {
            let tokens = tokens(&text);
            // `{}` has none
            if !tokens.is_empty() {
                let (begin, end) = *place.get(&tokens);
                text.replace_range(begin..end, &value);
            }
        }
        check(post(text))?;
    }

    #[test]
    fn bytes_are_changed(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = which.get(REQUEST_EXAMPLES).text.as_bytes().to_vec();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        check(post(bytes))?;
    }

    #[test]
    fn heads_are_changed(
        method in prop::sample::select(vec!["GET", "POST", "PUT", "PATCH", "DELETE", "HEAD", "OPTIONS", "BREW"]),
        path in prop_oneof![Just("/v1/fits".to_owned()), "/(v1|docs|healthz|v1/fits)?/?[a-z0-9%.]{0,8}"],
        media in prop_oneof![
            Just("application/json".to_owned()),
            Just("multipart/form-data; boundary=x".to_owned()),
            "[a-z/;= +\"]{0,20}",
        ],
        encoding in prop_oneof![Just("identity".to_owned()), Just("gzip".to_owned()), Just("zstd".to_owned()),
            "[a-z,]{0,8}"],
        id in "[ -~]{0,40}",
        body in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let Ok(uri) = path.parse::<axum::http::Uri>() else { return Ok(()) };
        let request = Request::builder()
            .method(Method::from_bytes(method.as_bytes()).unwrap())
            .uri(uri)
            .header("content-type", media)
            .header("content-encoding", encoding)
            .header("x-request-id", id)
            .body(Body::from(body))
            .unwrap();
        let head = request.method() == Method::HEAD;
        if head {
            let (status, _, _) = answer(request);
            prop_assert!(status < 500);
        } else {
            check(request)?;
        }
    }
}
