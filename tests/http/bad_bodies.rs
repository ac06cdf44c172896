//! Bodies that cannot be read, paths that are not there, limits.

use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use reqwest::header;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
};

use crate::harness::{CURVE, TestApp, send};

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[tokio::test]
async fn text_that_is_not_json_is_400_with_its_place() {
    let app = TestApp::start().await;
    for (text, place, word) in [
        ("", "Line 1, column 1", "ends"),
        ("{\n \"nodes\": nope}", "Line 2, column 11", "a value"),
        ("{\"nodes\":{\"type\":\"grid\",\"z\":[[1,NaN]]}}", "column 33", "missing"),
        ("{\"nodes\":{\"type\":\"grid\",\"z\":[[1,-Infinity]]}}", "column 33", "missing"),
        ("{\"model\":{\"a\":nan}}", "column 15", "missing"),
        ("{\"nodes\":{\"x\":[01]}}", "column 16", "superfluous"),
        ("{\"nodes\":{\"x\":[1.]}}", "column 18", "decimal"),
        ("{\"nodes\":{\"x\":[.5]}}", "column 16", "value"),
        ("{\"nodes\":{\"x\":[+1]}}", "column 16", "value"),
        ("{\"nodes\":{\"x\":[0x1]}}", "column 17", "`,` or `]`"),
        ("{\"nodes\":{\"x\":[1,]}}", "column 18", "value"),
        ("{\"nodes\":{\"x\":[1 2]}}", "column 18", "`,` or `]`"),
        ("{\"nodes\":{\"x\":[1", "column 17", "ends"),
        ("{} {}", "column 4", "follows"),
        ("nonsense", "Line 1, column 1", "a value"),
        ("{\"nodes\":{}}}", "Line 1, column 13", "follows"),
        ("\u{feff}{}", "Line 1, column 1", "a value"),
    ] {
        let body = app.fit(text).await.problem(400, "malformed_body");
        let detail = body["detail"].as_str().unwrap();
        assert!(detail.contains(place) && detail.contains(word), "{text}: {detail}");
    }
    let deep = format!("{{\"model\":{}1{}}}", "[".repeat(50), "]".repeat(50));
    app.fit(&deep).await.problem(400, "malformed_body");
    send(app.post("/v1/fits", b"{\"\xff\":1}".to_vec())).await.problem(400, "malformed_body");
    let body = send(app.post("/v1/fits", vec![0xff, 0xfe])).await.problem(400, "malformed_body");
    assert!(body["detail"].as_str().unwrap().contains("0xff"));
}

#[tokio::test]
async fn tokens_for_missing_numbers_are_explained() {
    let app = TestApp::start().await;
    for token in ["NaN", "nan", "Infinity", "-Infinity"] {
        let text = format!(
            r#"{{"nodes":{{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,{token}],[3,4]]}},"model":{{"type":"polynomial","degree":1}}}}"#
        );
        let body = app.fit(&text).await.problem(400, "malformed_body");
        let detail = body["detail"].as_str().unwrap();
        assert!(detail.contains("null") && detail.contains("valid"), "{detail}");
    }
}

#[tokio::test]
async fn other_media_types_are_415() {
    let app = TestApp::start().await;
    let url = app.url("/v1/fits");
    for media in ["text/plain", "application/xml", "application/x-www-form-urlencoded", "nonsense"] {
        let answer = send(app.client.post(&url).header(header::CONTENT_TYPE, media).body(CURVE)).await;
        answer.problem(415, "unsupported_media_type");
    }
    send(app.client.post(&url).body(CURVE)).await.problem(415, "unsupported_media_type");
    send(app.post("/v1/fits", CURVE).header(header::CONTENT_ENCODING, "br"))
        .await
        .problem(415, "unsupported_media_type");
    // curl's default media type
    let media = "application/x-www-form-urlencoded";
    let answer = send(app.client.post(&url).header(header::CONTENT_TYPE, media).body(CURVE)).await;
    let detail = answer.problem(415, "unsupported_media_type")["detail"].clone();
    assert!(detail.as_str().unwrap().contains("-H 'content-type: application/json'"), "{detail}");
    let json = ["application/json; charset=utf-8", "Application/JSON", "application/vnd.flank+json"];
    for media in json.into_iter().chain(["application/octet-stream"]) {
        let answer = send(app.client.post(&url).header(header::CONTENT_TYPE, media).body(CURVE)).await;
        assert_eq!(answer.status, 200, "{media}");
    }
}

#[tokio::test]
async fn paths_and_methods_that_are_not_there() {
    let app = TestApp::start().await;
    send(app.get("/v1/nothing")).await.problem(404, "not_found");
    send(app.get("/%ff%00")).await.problem(404, "not_found");
    let answer = send(app.get("/v1/fits")).await;
    answer.problem(405, "method_not_allowed");
    assert_eq!(answer.header("allow"), "POST");
    send(app.client.delete(app.url("/healthz"))).await.problem(405, "method_not_allowed");
}

#[tokio::test]
async fn compressed_requests_are_read() {
    let app = TestApp::start().await;
    let plain = app.fit(CURVE).await;
    let compressed: [(&str, Vec<u8>); 3] = [
        ("gzip", gzip(CURVE.as_bytes())),
        ("x-gzip", gzip(CURVE.as_bytes())),
        ("zstd", zstd::encode_all(CURVE.as_bytes(), 3).unwrap()),
    ];
    for (name, body) in compressed {
        let answer = send(app.post("/v1/fits", body).header(header::CONTENT_ENCODING, name)).await;
        assert_eq!((answer.status.as_u16(), &answer.text), (200, &plain.text), "{name}");
    }
}

#[tokio::test]
async fn broken_compression_is_400() {
    let app = TestApp::start().await;
    for (name, whole) in [("gzip", gzip(CURVE.as_bytes())), ("zstd", zstd::encode_all(CURVE.as_bytes(), 3).unwrap())] {
        for body in [whole[..whole.len() - 5].to_vec(), whole[..7].to_vec(), b"neither".to_vec()] {
            let answer = send(app.post("/v1/fits", body).header(header::CONTENT_ENCODING, name)).await;
            answer.problem(400, "malformed_body");
        }
    }
}

#[tokio::test]
async fn the_limit_counts_decompressed_bytes() {
    let app = TestApp::start_with(|settings| settings.body_limit = 10_000).await;
    let padded = |length: usize| format!("{CURVE}{}", " ".repeat(length - CURVE.len()));
    assert_eq!(app.fit(&padded(10_000)).await.status, 200);
    app.fit(&padded(10_001)).await.problem(413, "body_too_large");
    for (name, body) in [
        ("gzip", gzip(padded(10_001).as_bytes())),
        ("zstd", zstd::encode_all(padded(10_001).as_bytes(), 3).unwrap()),
        // A bomb: 200 MB of white space in some 200 kB (which exceeds this limit even as it is) and
        // 2 MB in 2 kB.
        ("gzip", gzip(&vec![b' '; 200_000_000])),
        ("gzip", gzip(&vec![b' '; 2_000_000])),
    ] {
        let answer = send(app.post("/v1/fits", body).header(header::CONTENT_ENCODING, name)).await;
        answer.problem(413, "body_too_large");
    }
    // Without a declared length.
    let chunk = format!("3e8\r\n{}\r\n", " ".repeat(1000));
    let head =
        "POST /v1/fits HTTP/1.1\r\nhost: [::1]\r\ncontent-type: application/json\r\ntransfer-encoding: chunked\r\n\r\n";
    assert_eq!(raw(&app, &format!("{head}{}", chunk.repeat(20))).await, "HTTP/1.1 413");
}

/// Sends bytes and reads the beginning of the answer.
async fn raw(app: &TestApp, text: &str) -> String {
    let mut stream = TcpStream::connect(app.address).await.unwrap();
    stream.write_all(text.as_bytes()).await.unwrap();
    let mut answer = vec![0; 12];
    stream.read_exact(&mut answer).await.unwrap();
    String::from_utf8(answer).unwrap()
}

#[tokio::test]
async fn a_body_that_does_not_come_is_408() {
    let app = TestApp::start_with(|settings| settings.body_timeout = 1).await;
    let head = "POST /v1/fits HTTP/1.1\r\nhost: [::1]\r\ncontent-type: application/json\r\ncontent-length: 99\r\n\r\n{";
    assert_eq!(raw(&app, head).await, "HTTP/1.1 408");
}
