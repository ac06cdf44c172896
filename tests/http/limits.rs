//! Limits of what a server holds: bodies, unsent responses, connections, clients that do not read
//! or send.

use std::io::Write;

use reqwest::header;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpSocket, TcpStream},
};

use crate::harness::{CURVE, TestApp, WAITING_CURVE, raw, send};

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(text).unwrap();
    encoder.finish().unwrap()
}

/// Returns when the server's budget is as it should be.
async fn until_held(app: &TestApp, wanted: impl Fn(usize) -> bool) {
    let asked = std::time::Instant::now();
    while !wanted(app.state.budget.held()) {
        assert!(asked.elapsed().as_secs() < 60, "{} bytes are held", app.state.budget.held());
        // others have the processor meanwhile
        tokio::time::sleep(std::time::Duration::from_millis(1)).await;
    }
}

/// A request for a fit of a certain length whose body has not come in full.
async fn unfinished(app: &TestApp, length: usize, sent: usize) -> TcpStream {
    let mut stream = TcpStream::connect(app.address).await.unwrap();
    let head = format!(
        "POST /v1/fits HTTP/1.1\r\nHost: [::1]\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(&vec![b' '; sent]).await.unwrap();
    stream
}

#[tokio::test]
async fn bodies_share_a_budget() {
    let app = TestApp::start_with(|settings| settings.body_memory = 1 << 20).await;
    // what would never fit is too large: by its own length, by that of what is in it, and by the
    // numbers it holds
    let blank = |length: usize| [vec![b' '; length], CURVE.as_bytes().to_vec()].concat();
    send(app.post("/v1/fits", blank(1 << 20))).await.problem(413, "body_too_large");
    let packed = app.post("/v1/fits", gzip(&blank(1 << 20))).header(header::CONTENT_ENCODING, "gzip");
    send(packed).await.problem(413, "body_too_large");
    let numbers = format!("{{\"nodes\":{{\"type\":\"curve\",\"x\":[0{}]", ",0".repeat(40_000));
    send(app.post("/v1/fits", numbers)).await.problem(413, "body_too_large");
    until_held(&app, |held| held == 0).await;
    // a request that fits the budget waits for nobody: others hold the memory
    let slow = unfinished(&app, 700_000, 600_000).await;
    until_held(&app, |held| held == 600_000).await;
    let answer = send(app.post("/v1/fits", blank(500_000))).await;
    answer.problem(503, "overloaded");
    assert_eq!(answer.header("retry-after"), "1");
    let packed = app.post("/v1/fits", gzip(&blank(500_000))).header(header::CONTENT_ENCODING, "gzip");
    send(packed).await.problem(503, "overloaded");
    assert_eq!(app.fit(CURVE).await.status, 200, "there is some room for small ones");
    drop(slow);
    until_held(&app, |held| held == 0).await;
    // what all tests of this process have counted is longer than this server may answer
    let metrics = send(TestApp::start().await.get("/metrics")).await.text;
    assert!(metrics.contains("flankfit_shed_total{reason=\"body_memory\"}"), "{metrics}");
    assert!(metrics.contains("\nflankfit_body_memory_bytes "), "{metrics}");
    until_held(&app, |held| held == 0).await;
    assert_eq!(send(app.post("/v1/fits", blank(500_000))).await.status, 200);
}

/// A declared length is a promise that costs nobody else anything.
#[tokio::test]
async fn a_client_that_declares_and_does_not_send_holds_nothing() {
    let app = TestApp::start_with(|settings| settings.body_memory = 1 << 20).await;
    let _promised = [unfinished(&app, 900_000, 1000).await, unfinished(&app, 900_000, 1000).await];
    until_held(&app, |held| held == 2000).await;
    let body = [vec![b' '; 800_000], CURVE.as_bytes().to_vec()].concat();
    assert_eq!(send(app.post("/v1/fits", body)).await.status, 200);
}

/// Whatever the endpoint, a compressed body is unpacked by a worker.
#[tokio::test]
async fn unpacking_is_work() {
    let app = TestApp::start_with(|settings| settings.workers = 1).await;
    let job = send(app.post("/v1/jobs", r#"{"name":"z52"}"#)).await.header("location").to_owned();
    let iteration = send(app.post(&format!("{job}/iterations"), CURVE)).await;
    let fit = iteration.json()["fits"][0]["id"].as_str().unwrap().to_owned();
    let iteration = iteration.header("location").to_owned();
    let choice = format!(r#"{{"fit_id":"{fit}"}}"#);
    let decision = r#"{"decision":"accepted"}"#;
    for (method, path, body) in [
        ("PATCH", job.clone(), r#"{"name":"z53"}"#),
        ("PATCH", iteration.clone(), decision),
        ("PUT", format!("{iteration}/chosen-fit"), &choice),
        ("POST", "/v1/jobs".into(), r#"{"name":"z54"}"#),
        ("POST", "/v1/fits".into(), CURVE),
        ("POST", "/v1/gears/tolerances".into(), "{}"),
    ] {
        let busy = app.occupy_worker().await;
        let request = app.client.request(method.parse().unwrap(), app.url(&path)).body(gzip(body.as_bytes()));
        let request = request.header(header::CONTENT_TYPE, "application/json").header(header::CONTENT_ENCODING, "gzip");
        let waiting = tokio::spawn(send(request));
        app.until_waiting(1).await;
        drop(busy);
        let answer = waiting.await.unwrap();
        assert!(answer.status.is_success() || answer.status == 422, "{method} {path}: {}", answer.text);
    }
    // a small body has a small limit
    let bomb = gzip(&vec![b' '; 2 << 20]);
    let request = app.client.patch(app.url(&job)).body(bomb);
    let request = request.header(header::CONTENT_TYPE, "application/json").header(header::CONTENT_ENCODING, "gzip");
    send(request).await.problem(413, "body_too_large");
    until_held(&app, |held| held == 0).await;
}

/// With a key, too, a body waits for a worker as it came, and is unpacked once.
#[tokio::test]
async fn a_body_with_a_key_waits_packed() {
    let app = TestApp::start_with(|settings| settings.workers = 1).await;
    let job = send(app.post("/v1/jobs", r#"{"name":"z52"}"#)).await.header("location").to_owned();
    let packed = gzip(&[vec![b' '; 1 << 20], CURVE.as_bytes().to_vec()].concat());
    let length = packed.len();
    let place = format!("{job}/iterations");
    let request = || {
        let request = app.post(&place, packed.clone()).header(header::CONTENT_ENCODING, "gzip");
        request.header("idempotency-key", "k")
    };
    let busy = app.occupy_worker().await;
    let waiting = tokio::spawn(send(request()));
    app.until_waiting(1).await;
    // the memory of the job may have been released a moment later
    until_held(&app, |held| held == length).await;
    drop(busy);
    let first = waiting.await.unwrap();
    assert_eq!(first.status, 201, "{}", first.text);
    until_held(&app, |held| held == 0).await;
    // the key is known by what the body says, however it was sent
    let again = send(request()).await;
    assert_eq!((again.status.as_u16(), again.header("idempotency-replayed")), (201, "true"));
    let plain = [vec![b' '; 1 << 20], CURVE.as_bytes().to_vec()].concat();
    let plain = send(app.post(&place, plain).header("idempotency-key", "k")).await;
    assert_eq!((plain.text.as_str(), plain.header("idempotency-replayed")), (first.text.as_str(), "true"));
    send(app.post(&place, CURVE).header("idempotency-key", "k")).await.problem(422, "idempotency_key_reused");
}

/// A window that no content encoding may have would be held by each worker.
#[tokio::test]
async fn windows_of_zstd_are_bounded() {
    let app = TestApp::start().await;
    let pack = |log: u32| {
        let mut encoder = zstd::Encoder::new(Vec::new(), 1).unwrap();
        encoder.window_log(log).unwrap();
        encoder.write_all(CURVE.as_bytes()).unwrap();
        encoder.finish().unwrap()
    };
    for (log, status) in [(23, 200), (27, 400)] {
        let request = app.post("/v1/fits", pack(log)).header(header::CONTENT_ENCODING, "zstd");
        assert_eq!(send(request).await.status.as_u16(), status, "{log}");
    }
}

/// Facets of a patch, about 250 bytes for each of two for each quadrilateral.
fn export(samples: usize) -> String {
    let points = "[[[0,0,0],[0,1,1],[0,2,0]],[[1,0,1],[1,1,3],[1,2,1]],[[2,0,0],[2,1,1],[2,2,0]]]";
    let surface = format!(r#"{{"type":"bezier","control_points":{points}}}"#);
    format!(r#"{{"surface":{surface},"format":"stl_text","samples":[{samples},{samples}]}}"#)
}

/// A client that requests a large file and reads nothing of it.
async fn unread(app: &TestApp, body: &str) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let mut stream = socket.connect(app.address).await.unwrap();
    stream.write_all(posted("/v1/surfaces/export", body).as_bytes()).await.unwrap();
    stream
}

/// A POST of JSON on a connection of its own.
fn posted(path: &str, body: &str) -> String {
    let head = "Host: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n";
    format!("POST {path} HTTP/1.1\r\n{head}Content-Length: {}\r\n\r\n{body}", body.len())
}

/// A large file is made as it is read: what waits for its client is what the file is made of, no
/// text, and no worker.
#[tokio::test]
async fn a_file_is_made_as_it_is_read() {
    let app = TestApp::start_with(|settings| settings.workers = 1).await;
    let small = send(app.post("/v1/surfaces/export", export(3))).await;
    assert_eq!((small.status.as_u16(), small.header("content-length")), (200, small.text.len().to_string().as_str()));
    // four of them are not read, and the only worker is there for others
    let waiting = [(); 4].map(|()| export(150));
    let mut streams = Vec::new();
    for body in &waiting {
        streams.push(unread(&app, body).await);
    }
    let mesh = 151 * 151 * (24 + 16 + 4);
    until_held(&app, |held| held == 4 * mesh).await;
    assert_eq!(app.fit(CURVE).await.status, 200);
    // when it is read, it is whole
    let whole = send(app.post("/v1/surfaces/export", export(150))).await;
    assert_eq!((whole.status.as_u16(), whole.header("content-length")), (200, ""));
    assert!(whole.text.starts_with("solid ") && whole.text.trim_end().ends_with("endsolid surface"));
    assert_eq!(whole.text.matches("endfacet").count(), 2 * 150 * 150);
    drop(streams);
    until_held(&app, |held| held == 0).await;
    // errors are found before the file begins, and what exceeds the budget is refused
    assert_eq!(send(app.post("/v1/surfaces/export", export(0))).await.pointers(), ["/samples"]);
    let app = TestApp::start_with(|settings| settings.body_memory = 1 << 20).await;
    send(app.post("/v1/surfaces/export", export(200))).await.problem(413, "body_too_large");
    assert_eq!(send(app.post("/v1/surfaces/export", export(100))).await.status, 200);
}

/// The result of a short request is reserved in the budget before it is computed.
#[tokio::test]
async fn memory_is_reserved_before_the_computation() {
    let app = TestApp::start_with(|settings| settings.body_memory = 1 << 20).await;
    let gear = r#"{"teeth":40,"normal_module_mm":2}"#;
    let profile =
        |steps: usize| format!(r#"{{"gear":{gear},"steps":{{"involute":{steps},"fillet":10,"tip":10,"root":10}}}}"#);
    // little of the tool cuts between these radii
    let envelope = |steps: usize| {
        let tool = format!(r#"{{"points":[[-1.5708,-1.25],[-1.24,-1.25],[-0.42,1]],"steps":{steps}}}"#);
        let motion = r#"{"type":"rack","pitch_radius_mm":26}"#;
        format!(r#"{{"tool":{tool},"motion":{motion},"radius_range_mm":[26.0,26.01]}}"#)
    };
    let line = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>().join(",");
    let knots = |count: usize| format!("[0,0,{},{1},{1}]", line(count - 2, &|k| (k + 1).to_string()), count - 1);
    let surface = |format: &str, side: usize| {
        let row = |i: usize| format!("[{}]", line(side, &|j| format!("[{i},{j},{}]", (i * j) % 7)));
        let (knots, points) = (knots(side), line(side, &row));
        let surface =
            format!(r#"{{"type":"b_spline","degree":[1,1],"knots":[{knots},{knots}],"control_points":[{points}]}}"#);
        format!(r#"{{"surface":{surface},"format":"{format}"}}"#)
    };
    let curve = |format: &str, count: usize| {
        let points = line(count, &|k| format!("[{k},{}]", k % 7));
        let curve = format!(r#"{{"type":"b_spline","degree":1,"knots":{},"control_points":[{points}]}}"#, knots(count));
        format!(r#"{{"curve":{curve},"format":"{format}"}}"#)
    };
    for (path, small, large) in [
        ("/v1/gears/profile", profile(500), profile(4_000)),
        ("/v1/gears/envelope", envelope(500), envelope(15_000)),
        ("/v1/surfaces/export", surface("iges", 10), surface("iges", 35)),
        ("/v1/surfaces/export", surface("step", 10), surface("step", 35)),
        ("/v1/curves/export", curve("iges", 100), curve("iges", 1_200)),
        ("/v1/curves/export", curve("step", 100), curve("step", 1_200)),
    ] {
        let answer = send(app.post(path, small)).await;
        assert_eq!(answer.status, 200, "{path}: {}", answer.text);
        send(app.post(path, large.clone())).await.problem(413, "body_too_large");
        // it is no answer that would not fit
        let roomy = TestApp::start().await;
        let answer = send(roomy.post(path, large)).await;
        assert!(
            answer.status == 200 && answer.text.len() < 900_000,
            "{path}: {} {:.300}",
            answer.text.len(),
            answer.text
        );
        roomy.stop().await;
    }
    until_held(&app, |held| held == 0).await;
}

#[tokio::test]
async fn a_client_that_does_not_read_is_let_go() {
    let app = TestApp::start_with(|settings| settings.write_timeout = 1).await;
    let mut stream = unread(&app, &export(300)).await;
    until_held(&app, |held| held > 1 << 20).await;
    until_held(&app, |held| held == 0).await;
    let mut rest = Vec::new();
    let ended = stream.read_to_end(&mut rest).await;
    assert!(ended.is_err() || !String::from_utf8_lossy(&rest).contains("endsolid"), "{} bytes", rest.len());
}

#[tokio::test]
async fn an_early_refusal_closes_its_connection_and_is_read() {
    let app = TestApp::start_with(|settings| settings.body_limit = 1 << 20).await;
    let post = |path: &str, head: &str, length: usize, body: &[u8]| {
        let head = format!("POST {path} HTTP/1.1\r\nHost: [::1]\r\n{head}Content-Length: {length}\r\n\r\n");
        [head.as_bytes(), body].concat()
    };
    let json = "Content-Type: application/json\r\n";
    for (status, request) in [
        ("413", post("/v1/fits", json, 2 << 20, &vec![b' '; 1 << 20])),
        ("404", post("/v1/nothing", json, 1 << 20, &vec![b' '; 512 << 10])),
        ("415", post("/v1/fits", "Content-Encoding: br\r\n", 1 << 20, &vec![b' '; 512 << 10])),
        ("404", post("/v1/nothing", "Expect: 100-continue\r\n", 100, b"")),
    ] {
        let mut stream = TcpStream::connect(app.address).await.unwrap();
        stream.write_all(&request).await.unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).await.expect("the answer is not lost with the connection");
        let answer = String::from_utf8(answer).unwrap();
        assert_eq!(answer.split(' ').nth(1), Some(status), "{answer}");
        assert!(answer.to_ascii_lowercase().contains("\r\nconnection: close\r\n"), "{answer}");
    }
    // a short rest is read, and the connection goes on
    let short = post("/v1/nothing", json, 1000, &[b' '; 1000]);
    let last = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    let both = String::from_utf8([&short[..], last].concat()).unwrap();
    let answers = raw(app.address, &both).await;
    assert!(answers.contains(" 404 ") && answers.contains("\"status\":\"ok\""), "{answers}");
}

#[tokio::test]
async fn idle_connections_give_way() {
    let app = TestApp::start_with(|settings| settings.max_connections = 3).await;
    let mut idle = Vec::new();
    for _ in 0..20 {
        idle.push(TcpStream::connect(app.address).await.unwrap());
    }
    // an honest client among them is served
    let fit = posted("/v1/fits", WAITING_CURVE);
    for _ in 0..3 {
        assert!(raw(app.address, &fit).await.starts_with("HTTP/1.1 200 "));
    }
    let mut first = idle.remove(0);
    assert_eq!(first.read(&mut [0; 10]).await.unwrap_or(0), 0, "it was closed");
    // requests that are worked on are not interrupted; who comes then waits
    let busy = [app.occupy_worker().await, app.occupy_worker().await];
    let ask = |fit: String, address| tokio::spawn(async move { raw(address, &fit).await });
    let waiting: Vec<_> = (0..3).map(|_| ask(fit.clone(), app.address)).collect();
    app.until_waiting(3).await;
    let fourth = ask(fit.clone(), app.address);
    drop(busy);
    for answer in waiting.into_iter().chain([fourth]) {
        let answer = answer.await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    }
}

#[tokio::test]
async fn checks_are_answered_while_every_connection_is_at_work() {
    let app = TestApp::start_with(|settings| settings.max_connections = 16).await;
    let fit = posted("/v1/fits", CURVE);
    // three quarters may stay open
    let mut listening = Vec::new();
    for _ in 0..12 {
        let mut stream = TcpStream::connect(app.address).await.unwrap();
        stream.write_all(b"GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n").await.unwrap();
        let mut received = Vec::new();
        while !received.ends_with(b"retry: 2000\n\n\r\n") {
            assert_ne!(stream.read_buf(&mut received).await.unwrap(), 0, "{}", String::from_utf8_lossy(&received));
        }
        listening.push(stream);
    }
    let another = "GET /v1/events HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    let answer = raw(app.address, another).await;
    assert!(answer.starts_with("HTTP/1.1 503 ") && answer.contains("12 event streams"), "{answer}");
    // bodies that come slowly take all of the others but two
    let slow = [unfinished(&app, 1000, 1).await, unfinished(&app, 1000, 1).await];
    until_held(&app, |held| held > 0).await;
    let refused = async || raw(app.address, &fit).await;
    let mut answer = refused().await;
    while answer.starts_with("HTTP/1.1 200 ") {
        answer = refused().await;
    }
    assert!(answer.starts_with("HTTP/1.1 503 ") && answer.contains("\"overloaded\""), "{answer}");
    assert!(answer.to_ascii_lowercase().contains("retry-after: 1\r\n"), "{answer}");
    for check in ["/healthz", "/readyz"] {
        let answer = raw(app.address, &format!("GET {check} HTTP/1.1\r\nHost: localhost\r\n\r\n")).await;
        assert!(answer.starts_with("HTTP/1.1 200 "), "{check}: {answer}");
    }
    drop((listening, slow));
    let mut answer = refused().await;
    while answer.starts_with("HTTP/1.1 503 ") {
        answer = refused().await;
    }
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
}
