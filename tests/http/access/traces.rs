//! Spans of requests, as a collector gets them.

use std::{
    collections::BTreeSet,
    io::Read as _,
    process::Command,
    sync::mpsc,
    time::{Duration, Instant},
};

use reqwest::Method;
use serde_json::{Value, json};
use sqlx::{ConnectOptions as _, sqlite::SqliteConnectOptions};
use uuid::Uuid;

use super::{
    collector::{Collector, Span},
    issuer::{Issuer, SigningKey},
    talkative::Talkative,
};
use crate::{database::in_file, harness::CURVE, plant::proxy::free_address};

const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
const PARENT: &str = "00f067aa0ba902b7";

const SERVER: u64 = 2;
const CLIENT: u64 = 3;

fn traceparent(sampled: bool) -> String {
    format!("00-{TRACE}-{PARENT}-0{}", u8::from(sampled))
}

/// Trace, span and flags of an answer.
fn named(answer: &reqwest::Response) -> (String, String, String) {
    let text = answer.headers()["traceparent"].to_str().unwrap();
    let [version, trace, span, flags] = text.split('-').collect::<Vec<_>>()[..] else { panic!("{text}") };
    assert_eq!(version, "00");
    (trace.into(), span.into(), flags.into())
}

/// The spans below another.
fn below<'a>(spans: &'a [Span], parent: &Span) -> Vec<&'a Span> {
    spans.iter().filter(|span| span.parent == parent.id).collect()
}

fn names(spans: &[&Span]) -> BTreeSet<String> {
    spans.iter().map(|span| span.name.clone()).collect()
}

fn server_port(base: &str) -> &str {
    base.rsplit(':').next().unwrap()
}

/// A fit that no connection's thread does.
fn long_fit() -> Value {
    let x: Vec<f64> = (0..20_000).map(f64::from).collect();
    json!({"nodes": {"type": "curve", "x": x, "y": x}, "model": {"type": "polynomial", "degree": 5}})
}

#[tokio::test]
async fn spans_of_a_request_come_to_the_collector() {
    const CANARY: &str = "canary-3141592653";
    let folder = tempfile::tempdir().unwrap();
    let (collector, issuer, key) = (Collector::start(), Issuer::start(), SigningKey::es256("one"));
    issuer.publish(&[&key]);
    let server = Talkative::start(
        &folder.path().join("test.db"),
        &[
            "--otlp-endpoint",
            &collector.url,
            "--otlp-sample",
            "1",
            "--auth",
            "off",
            "--oidc-issuer",
            &issuer.url,
            "--oidc-audience",
            "flankfit",
        ],
    );
    let (client, base) = (reqwest::Client::new(), server.base.clone());
    let url = |path: &str| format!("{base}{path}");
    let within = |request: reqwest::RequestBuilder| {
        request.header("traceparent", traceparent(true)).bearer_auth(CANARY).header("x-api-key", CANARY)
    };
    let fit = within(client.post(url("/v1/fits")).json(&long_fit())).send().await.unwrap();
    assert_eq!(fit.status(), 200);
    let (trace, fit_span, flags) = named(&fit);
    assert_eq!((trace.as_str(), flags.as_str()), (TRACE, "01"));
    assert_ne!(fit_span, PARENT);
    let short = within(client.post(url("/v1/fits")).header("content-type", "application/json").body(CURVE));
    let (_, short_span, _) = named(&short.send().await.unwrap());
    let job = within(client.post(url("/v1/jobs")).json(&json!({"name": CANARY}))).send().await.unwrap();
    let place = job.headers()["location"].to_str().unwrap().to_owned();
    let (_, job_span, _) = named(&job);
    let read = within(client.get(url(&format!("/v1/jobs?q={CANARY}")))).send().await.unwrap();
    let (_, read_span, _) = named(&read);
    let unknown = within(client.get(url(&format!("{place}x/{CANARY}")))).send().await.unwrap();
    assert_eq!(unknown.status(), 404);
    let (_, unknown_span, _) = named(&unknown);
    let brewed = within(client.request(Method::from_bytes(b"BREW").unwrap(), url("/v1/fits"))).send().await.unwrap();
    assert_eq!(brewed.status(), 405);
    let (_, brewed_span, _) = named(&brewed);
    // who decides nothing begins a trace of its own
    let (own, own_span, _) = named(&client.get(url("/healthz")).send().await.unwrap());
    assert_ne!(own, TRACE);
    for span in [&fit_span, &short_span, &job_span, &read_span, &unknown_span, &brewed_span, &own_span] {
        collector.until_got(span).await;
    }
    let said = server.end();
    let spans = collector.spans();
    let of = |id: &str| spans.iter().find(|span| span.id == id).unwrap_or_else(|| panic!("{id} in {spans:#?}"));
    let fit = of(&fit_span);
    assert_eq!((fit.trace.as_str(), fit.parent.as_str(), fit.kind, fit.status), (TRACE, PARENT, SERVER, 0));
    assert_eq!(fit.name, "POST /v1/fits");
    for (name, value) in
        [("http.request.method", "POST"), ("http.route", "/v1/fits"), ("http.response.status_code", "200 as a number")]
    {
        assert_eq!(fit.attribute(name), value, "{fit:?}");
    }
    let port = server_port(&base);
    for (name, value) in [
        ("url.scheme", "http"),
        ("server.address", "127.0.0.1"),
        ("server.port", format!("{port} as a number").as_str()),
    ] {
        assert_eq!(fit.attribute(name), value, "{fit:?}");
    }
    assert_eq!(names(&below(&spans, fit)), BTreeSet::from(["queue".into(), "compute".into()]));
    for one in below(&spans, fit) {
        assert!(fit.begun <= one.begun && one.begun <= one.ended && one.ended <= fit.ended, "{one:?} in {fit:?}");
        assert_eq!(one.trace, TRACE);
    }
    let computing = below(&spans, fit).into_iter().find(|span| span.name == "compute").unwrap();
    assert!(computing.ended - computing.begun > 100_000, "{computing:?}");
    assert_eq!(names(&below(&spans, of(&short_span))), BTreeSet::from(["compute".into()]));
    let stored = below(&spans, of(&job_span));
    let insert = stored.iter().find(|span| span.name == "InsertJob").unwrap_or_else(|| panic!("{stored:?}"));
    assert_eq!((insert.kind, insert.attribute("db.operation.name")), (CLIENT, "InsertJob"));
    assert_eq!(insert.attribute("db.system.name"), "sqlite");
    assert_eq!(of(&job_span).attribute("http.response.status_code"), "201 as a number");
    assert_eq!(of(&read_span).name, "GET /v1/jobs");
    assert!(names(&below(&spans, of(&read_span))).contains("ListJobs"));
    assert_eq!((of(&unknown_span).name.as_str(), of(&unknown_span).status), ("GET", 0));
    let brewed = of(&brewed_span);
    assert_eq!((brewed.name.as_str(), brewed.attribute("http.request.method")), ("HTTP /v1/fits", "_OTHER"));
    assert_eq!((of(&own_span).trace.as_str(), of(&own_span).parent.as_str()), (own.as_str(), ""));
    assert!(spans.iter().all(|span| span.events == 0), "log lines are in the log");

    assert_eq!(collector.resource("service.name"), "flankfit");
    let process: Uuid = collector.resource("service.instance.id").parse().unwrap();
    assert_eq!(process.get_version_num(), 4, "drawn");
    assert!(collector.heads().iter().all(|head| head.starts_with("POST /v1/traces HTTP/1.1\r\n")));
    let sent = collector.bytes();
    assert!(!sent.windows(CANARY.len()).any(|window| window == CANARY.as_bytes()));
    assert!(!sent.windows(36).any(|window| place.as_bytes().ends_with(window)), "routes are unfilled");
    // nor is anything of spans in the log
    assert!(said.contains("\"answered\"") && !said.contains("flankfit::trace") && !said.contains("\"spans\":[{"));
}

#[tokio::test]
async fn the_root_of_a_trace_decides_on_sampling() {
    let folder = tempfile::tempdir().unwrap();
    for sample in ["0", "1"] {
        let collector = Collector::start();
        let database = folder.path().join(format!("{sample}.db"));
        let server = Talkative::start(&database, &["--otlp-endpoint", &collector.url, "--otlp-sample", sample]);
        let client = reqwest::Client::new();
        let ask = async |parent: Option<String>| {
            let request = client.get(format!("{}/v1/jobs", server.base));
            let request = parent.into_iter().fold(request, |request, parent| request.header("traceparent", parent));
            named(&request.send().await.unwrap())
        };
        let (trace, refused, flags) = ask(Some(traceparent(false))).await;
        assert_eq!((trace.as_str(), flags.as_str()), (TRACE, "00"), "the trace goes on, unsampled");
        let (_, wanted, flags) = ask(Some(traceparent(true))).await;
        assert_eq!(flags, "01");
        let (_, own, flags) = ask(None).await;
        assert_eq!(flags == "01", sample == "1");
        let (trace, _, _) = ask(Some("00-nonsense".into())).await;
        assert_ne!(trace, TRACE);
        let twice = client.get(format!("{}/v1/jobs", server.base));
        let twice = twice.header("traceparent", traceparent(true)).header("traceparent", traceparent(true));
        assert_ne!(named(&twice.send().await.unwrap()).0, TRACE, "of two it is not known which one holds");
        let (_, last, _) = ask(Some(traceparent(true))).await;
        for span in [Some(&wanted), Some(&own).filter(|_| sample == "1"), Some(&last)].into_iter().flatten() {
            collector.until_got(span).await;
        }
        server.end();
        let got: BTreeSet<String> = collector.spans().into_iter().map(|span| span.id).collect();
        assert!(got.contains(&wanted) && !got.contains(&refused), "{sample}");
        assert_eq!(got.contains(&own), sample == "1");
    }
}

/// The server is a link of the chain: what it asks of others names the span that asks.
#[tokio::test]
async fn requests_of_the_server_carry_the_trace_on() {
    let folder = tempfile::tempdir().unwrap();
    let (collector, issuer, key) = (Collector::start(), Issuer::start(), SigningKey::es256("one"));
    let other = SigningKey::es256("other");
    issuer.publish(&[&other]);
    let arguments = ["--otlp-endpoint", &collector.url, "--oidc-issuer", &issuer.url, "--oidc-audience", "flankfit"];
    let server = Talkative::start(&folder.path().join("test.db"), &arguments);
    while issuer.asked().is_empty() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(!issuer.asked()[0].to_ascii_lowercase().contains("traceparent"), "nobody asked for it");
    let whoami = || reqwest::Client::new().get(format!("{}/v1/whoami", server.base));
    // the requested keys are the known ones, before there are others
    let known = whoami().bearer_auth(issuer.token(&other, json!({"role": "reader"}))).send().await.unwrap();
    assert_eq!((known.status().as_u16(), issuer.asked().len()), (200, 1));
    issuer.publish(&[&key]);
    let token = issuer.token(&key, json!({"role": "reader"}));
    let answer = whoami().bearer_auth(&token).header("traceparent", traceparent(true)).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    let (_, asked, _) = named(&answer);
    collector.until_got(&asked).await;
    server.end();
    let spans = collector.spans();
    let outgoing = spans.iter().find(|span| span.name == "GET" && span.parent == asked).unwrap();
    assert_eq!((outgoing.trace.as_str(), outgoing.kind), (TRACE, CLIENT));
    let keys = spans.iter().find(|span| span.parent == asked && span.attribute("url.full").ends_with("/keys")).unwrap();
    assert_eq!(keys.attribute("http.response.status_code"), "200 as a number");
    assert_eq!(keys.attribute("url.full"), issuer.url.replace("/realms/plant", "/keys"));
    let heads = issuer.asked();
    let head = heads.last().unwrap().to_ascii_lowercase();
    assert!(head.contains(&format!("traceparent: 00-{TRACE}-{}-01", keys.id)), "{head}");
    let sent = String::from_utf8_lossy(&collector.bytes()).into_owned();
    assert!(token.split('.').all(|part| !sent.contains(part)) && !sent.contains("jane.doe"));
}

/// Number of spans counted as lost.
async fn dropped(base: &str) -> u64 {
    let text = reqwest::get(format!("{base}/metrics")).await.unwrap().text().await.unwrap();
    let name = "flankfit_trace_spans_dropped_total ";
    text.lines().find_map(|line| line.strip_prefix(name)?.parse().ok()).unwrap_or_else(|| panic!("{text}"))
}

/// Waits until spans are counted that the collector did not take.
async fn until_dropped(base: &str) {
    let begun = Instant::now();
    while dropped(base).await == 0 {
        assert!(begun.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// A collector that is away costs spans and nothing else.
#[tokio::test]
async fn dropped_spans_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = format!("http://{}", free_address());
    let arguments = ["--otlp-endpoint", &endpoint, "--otlp-sample", "1"];
    let server = Talkative::start(&folder.path().join("test.db"), &arguments);
    until_dropped(&server.base).await;
    let fit = reqwest::Client::new()
        .post(format!("{}/v1/fits", server.base))
        .header("content-type", "application/json")
        .body(CURVE);
    assert_eq!(fit.send().await.unwrap().status(), 200);
    let said = server.end();
    assert_eq!(said.matches("does not take spans").count(), 1, "said once");
    assert!(said.lines().any(|line| line.contains("does not take spans") && line.contains("refused")), "and why");
}

/// A failure of the store is an error of its span and of the request's.
#[tokio::test]
async fn spans_have_the_error_that_caused_them() {
    let folder = tempfile::tempdir().unwrap();
    let (collector, database) = (Collector::start(), folder.path().join("test.db"));
    let arguments = ["--otlp-endpoint", &collector.url, "--otlp-sample", "1", "--auth", "off"];
    let server = Talkative::start(&database, &arguments);
    let url = format!("{}/v1/jobs", server.base);
    let missing = reqwest::get(format!("{url}/{}", Uuid::nil())).await.unwrap();
    assert_eq!(missing.status(), 404);
    let mut own = SqliteConnectOptions::new().filename(&database).connect().await.unwrap();
    sqlx::raw_sql("ALTER TABLE jobs RENAME TO lost").execute(&mut own).await.unwrap();
    let failed = reqwest::get(&url).await.unwrap();
    assert_eq!(failed.status(), 500);
    for answer in [&missing, &failed] {
        collector.until_got(&named(answer).1).await;
    }
    server.end();
    let spans = collector.spans();
    let of = |answer| spans.iter().find(|span| span.id == named(answer).1).unwrap();
    for (answer, operation, error, store) in [(&missing, "GetJob", "", ""), (&failed, "ListJobs", "500", "internal")] {
        let span = of(answer);
        let stored = below(&spans, span).into_iter().find(|span| span.name == operation).unwrap();
        let status = if error.is_empty() { 0 } else { 2 };
        assert_eq!((span.status, span.attribute("error.type")), (status, error), "{span:?}");
        assert_eq!((stored.status, stored.attribute("error.type")), (status, store), "{stored:?}");
    }
}

/// Settings of OpenTelemetry in the environment: the key of the collector, and names of the
/// process.
#[tokio::test]
async fn the_environment_names_keys_and_processes() {
    const CANARY: &str = "canary-2718281828";
    let folder = tempfile::tempdir().unwrap();
    let collector = Collector::start();
    let key = format!("x-collector-key={CANARY}");
    let environment = [
        ("OTEL_EXPORTER_OTLP_HEADERS", key.as_str()),
        ("OTEL_SERVICE_NAME", "wheels"),
        ("OTEL_RESOURCE_ATTRIBUTES", "service.instance.id=one,deployment.environment.name=plant"),
    ];
    let arguments = ["--otlp-endpoint", &collector.url, "--otlp-sample", "1"];
    let server = Talkative::within(&environment, &folder.path().join("test.db"), &arguments);
    let answer = reqwest::get(format!("{}/healthz", server.base)).await.unwrap();
    collector.until_got(&named(&answer).1).await;
    let said = server.end();
    let heads = collector.heads();
    assert!(!heads.is_empty() && heads.iter().all(|head| head.contains(&format!("x-collector-key: {CANARY}\r\n"))));
    assert!(!said.contains(CANARY));
    for (name, value) in
        [("service.name", "wheels"), ("service.instance.id", "one"), ("deployment.environment.name", "plant")]
    {
        assert_eq!(collector.resource(name), value);
    }
    assert_eq!(collector.resource("service.version"), env!("CARGO_PKG_VERSION"));
}

/// A collector that accepts requests and never responds; each request is reported on the channel.
fn silent_collector() -> (String, mpsc::Receiver<()>) {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("http://{}", listener.local_addr().unwrap());
    let (sender, asked) = mpsc::channel();
    std::thread::spawn(move || {
        let mut held = Vec::new();
        for mut stream in listener.incoming().flatten() {
            if stream.read_exact(&mut [0]).is_ok() && sender.send(()).is_err() {
                return;
            }
            held.push(stream);
        }
    });
    (endpoint, asked)
}

/// One that says nothing holds up neither requests nor the end.
#[tokio::test]
async fn a_silent_collector_delays_no_request() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, asked) = silent_collector();
    let arguments = ["--otlp-endpoint", &endpoint, "--otlp-sample", "1", "--auth", "off"];
    let server = Talkative::start(&folder.path().join("test.db"), &arguments);
    let (client, url) = (reqwest::Client::new(), format!("{}/v1/fits", server.base));
    let fit = async || {
        let answer = client.post(&url).header("content-type", "application/json").body(CURVE).send().await.unwrap();
        assert_eq!(answer.status(), 200);
    };
    fit().await;
    asked.recv_timeout(Duration::from_secs(60)).unwrap();
    // All of these responses are sent while the collector has the first spans and is waited for:
    // they are not counted as lost before.
    let mut answered = 0;
    while dropped(&server.base).await == 0 {
        fit().await;
        answered += 1;
    }
    assert!(answered > 10, "{answered}");
    // the last ones have two seconds
    fit().await;
    let begun = Instant::now();
    server.end();
    // with the delays of a busy machine
    assert!(begun.elapsed() < Duration::from_secs(30), "{:?}", begun.elapsed());
}

/// The work goes on below the span of its request when the answer has begun.
#[tokio::test]
async fn an_answer_with_progress_is_one_trace() {
    let folder = tempfile::tempdir().unwrap();
    let collector = Collector::start();
    let arguments = ["--otlp-endpoint", &collector.url, "--otlp-sample", "1", "--auth", "off"];
    let server = Talkative::start(&folder.path().join("test.db"), &arguments);
    let fit = reqwest::Client::new().post(format!("{}/v1/fits", server.base)).json(&long_fit());
    let answer =
        fit.header("accept", "text/event-stream").header("traceparent", traceparent(true)).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    let (_, answering, _) = named(&answer);
    let text = answer.text().await.unwrap();
    assert!(text.contains("event: result"), "{text}");
    collector.until_got(&answering).await;
    server.end();
    let spans = collector.spans();
    let asked = spans.iter().find(|span| span.id == answering).unwrap();
    assert!(asked.trace == TRACE && names(&below(&spans, asked)).contains("compute"));
}

/// The last spans are sent at the end, by TLS to whoever shows a certificate of the authorities.
#[tokio::test]
async fn spans_go_by_tls_and_before_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let (collector, certificate) = Collector::by_tls();
    let file = folder.path().join("ca.pem");
    std::fs::write(&file, certificate).unwrap();
    for known in [true, false] {
        let mut arguments = vec!["--otlp-endpoint", &collector.url, "--otlp-sample", "1"];
        if known {
            arguments.extend(["--otlp-ca", file.to_str().unwrap()]);
        }
        let server = Talkative::start(&folder.path().join(format!("{known}.db")), &arguments);
        let ask = async || named(&reqwest::get(format!("{}/healthz", server.base)).await.unwrap()).1;
        let got = |span: &str| collector.spans().iter().any(|got| got.id == span);
        let first = ask().await;
        if known {
            // the connection is there, so that the end has no more to do than to send
            collector.until_got(&first).await;
        } else {
            until_dropped(&server.base).await;
        }
        let last = ask().await;
        let said = server.end();
        assert_eq!((got(&first), got(&last)), (known, known), "{said}");
        let why = said.lines().find(|line| line.contains("does not take spans"));
        assert_eq!(why.map(|line| line.contains("certificate")), (!known).then_some(true), "{said}");
    }
}

/// An error of a setting is one sentence, and nothing starts.
#[test]
fn settings_of_traces_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let ca = folder.path().join("none.pem");
    let ca = ca.to_str().unwrap();
    for (arguments, environment, why) in [
        (vec!["--otlp-sample", "1.5"], None, "write a number from 0 to 1"),
        (vec!["--otlp-sample=-0.1"], None, "write a number from 0 to 1"),
        (vec![], Some(("FLANKFIT_OTLP_SAMPLE", "NaN")), "write a number from 0 to 1"),
        (vec![], Some(("FLANKFIT_OTLP_ENDPOINT", "collector:4317")), "write a URL such as http://collector:4318"),
        (vec!["--otlp-endpoint", "https://u:canary@collector"], None, "write a URL without query, fragment and user"),
        (vec!["--otlp-ca", ca], None, "--otlp-endpoint"),
        (vec!["--otlp-endpoint", "https://collector", "--otlp-ca", ca], None, "--otlp-ca: cannot read"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_flankfit"))
            .args(["serve", "--bind", "127.0.0.1:0", "--database-url", &in_file(&folder.path().join("test.db"))])
            .args(&arguments)
            .env_clear()
            .envs(environment)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(why), "{arguments:?} {environment:?}: {said}");
        assert!(!said.contains("canary") && !said.contains("listening"), "{said}");
    }
}

#[tokio::test]
async fn without_a_collector_there_are_no_traces() {
    let folder = tempfile::tempdir().unwrap();
    let server = Talkative::start(&folder.path().join("test.db"), &[]);
    let request = reqwest::Client::new().get(format!("{}/healthz", server.base));
    let answer = request.header("traceparent", traceparent(true)).send().await.unwrap();
    assert!(!answer.headers().contains_key("traceparent"));
    assert!(!server.end().contains(TRACE));
}
