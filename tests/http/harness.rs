//! A server of its own for every test: a free port, a database file in a directory that goes away.

use std::{
    net::SocketAddr,
    sync::mpsc,
    time::{Duration, Instant},
};

use flankfit::{
    app::App,
    config::{Authentication, ServeSettings},
    http::AppState,
};
use reqwest::{Client, RequestBuilder, Response, StatusCode, header};
use serde_json::Value;
use tempfile::TempDir;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    sync::oneshot,
    task::JoinHandle,
};

use crate::database;

pub struct TestApp {
    pub address: SocketAddr,
    /// Address of the listener for operation, if there is one.
    pub operation: Option<SocketAddr>,
    pub client: Client,
    /// Directory of the database.
    pub directory: TempDir,
    /// State that the server's handlers share, for tests that must delay something.
    pub state: AppState,
    stop: oneshot::Sender<()>,
    server: JoinHandle<()>,
}

/// A server that was asked to stop.
pub struct Stopping {
    pub address: SocketAddr,
    pub client: Client,
    pub server: JoinHandle<()>,
    _directory: TempDir,
}

/// An answer, read to its end.
#[derive(Debug)]
pub struct Answer {
    pub status: StatusCode,
    pub headers: header::HeaderMap,
    pub text: String,
}

impl TestApp {
    pub async fn start() -> Self {
        Self::start_with(|_| {}).await
    }

    /// A server with other settings.
    pub async fn start_with(change: impl FnOnce(&mut ServeSettings)) -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory");
        Self::start_in(directory, change).await
    }

    /// A server on a file, for tests that reach into it.
    pub async fn start_on_file() -> Self {
        Self::start_with_file(tempfile::tempdir().expect("a temporary directory")).await
    }

    /// The same on a file that may be there already.
    pub async fn start_with_file(directory: TempDir) -> Self {
        let url = database::in_file(&directory.path().join("test.db"));
        Self::start_in(directory, |settings| settings.database_url = url).await
    }

    /// A server on a database that may be there already.
    pub async fn start_in(directory: TempDir, change: impl FnOnce(&mut ServeSettings)) -> Self {
        let mut settings = ServeSettings {
            bind: SocketAddr::from(([127, 0, 0, 1], 0)),
            database_url: database::url(directory.path()).await,
            workers: 2,
            ..ServeSettings::default()
        };
        // the PostgreSQL server of the tests syncs nothing
        settings.postgres.unsafe_store = true;
        // nobody has a key, unless a test gives some
        settings.auth = Authentication::Off;
        change(&mut settings);
        if !settings.api_keys_sha256.is_empty() {
            settings.auth = Authentication::Required;
        }
        let app = App::start(settings).await.expect("the server starts");
        let address = app.address().expect("an address");
        let operation = app.operation_address().map(|address| address.expect("an address"));
        let state = app.state().clone();
        let (stop, stopped) = oneshot::channel();
        let server = tokio::spawn(app.serve(async move {
            let _ = stopped.await;
        }));
        let client = Client::builder().no_proxy().no_gzip().build().expect("a client");
        TestApp { address, operation, client, directory, state, stop, server }
    }

    /// Asks the server to stop, which it does while others still talk to it.
    pub fn begin_stop(self) -> Stopping {
        let _ = self.stop.send(());
        Stopping { address: self.address, client: self.client, server: self.server, _directory: self.directory }
    }

    /// Stops the server gracefully and hands over the directory for the next one.
    pub async fn stop(self) -> TempDir {
        let _ = self.stop.send(());
        // Idle connections of the client would be waited for.
        drop(self.client);
        self.server.await.expect("the server ends");
        self.directory
    }

    /// Keeps a worker busy until the returned sender is dropped.
    pub async fn occupy_worker(&self) -> mpsc::Sender<()> {
        let (open, gate) = mpsc::channel();
        let (begun, busy) = oneshot::channel();
        let state = self.state.clone();
        tokio::spawn(async move {
            let work = move || {
                let _ = begun.send(());
                let _ = gate.recv();
            };
            state.pool.run(work).await
        });
        busy.await.expect("a worker");
        open
    }

    /// Returns when so many fits wait for a worker.
    pub async fn until_waiting(&self, count: usize) {
        while self.state.pool.waiting() < count {
            tokio::task::yield_now().await;
        }
    }

    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(self.url(path))
    }

    /// A POST of JSON text.
    pub fn post(&self, path: &str, text: impl Into<reqwest::Body>) -> RequestBuilder {
        self.client.post(self.url(path)).header(header::CONTENT_TYPE, "application/json").body(text)
    }

    pub fn put(&self, path: &str, text: impl Into<reqwest::Body>) -> RequestBuilder {
        self.client.put(self.url(path)).header("content-type", "application/json").body(text)
    }

    pub async fn fit(&self, text: &str) -> Answer {
        send(self.post("/v1/fits", text.to_owned())).await
    }
}

/// Response of a server to these bytes, until it closes the connection.
pub async fn raw(address: SocketAddr, request: &str) -> String {
    let mut stream = TcpStream::connect(address).await.expect("a connection");
    stream.write_all(request.as_bytes()).await.expect("the request is sent");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.expect("an answer");
    String::from_utf8_lossy(&answer).into_owned()
}

/// Value of a series among metrics, named with its labels; `None` if it is absent.
pub fn figure(metrics: &str, series: &str) -> Option<f64> {
    metrics.lines().find_map(|line| line.strip_prefix(series)?.strip_prefix(' ')?.parse().ok())
}

pub async fn send(request: RequestBuilder) -> Answer {
    Answer::read(request.send().await.expect("an answer")).await
}

/// Repeats a request about a working store until it succeeds: a busy machine may take longer than
/// the second that the store has.
pub async fn ready(request: &RequestBuilder) -> Answer {
    let begun = Instant::now();
    loop {
        let answer = send(request.try_clone().expect("no stream")).await;
        if answer.status != 503 || begun.elapsed() > Duration::from_secs(60) {
            assert_eq!(answer.status, 200, "{}", answer.text);
            return answer;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

impl Answer {
    pub async fn read(response: Response) -> Self {
        let (status, headers) = (response.status(), response.headers().clone());
        Answer { status, headers, text: response.text().await.expect("a body") }
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap_or_else(|error| panic!("{error}: {}", self.text))
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().expect("text"))
    }

    /// Checks that this is a complete problem of this status and code, and hands over its body.
    #[track_caller]
    pub fn problem(&self, status: u16, code: &str) -> Value {
        assert_eq!(self.status.as_u16(), status, "{}", self.text);
        assert_eq!(self.header("content-type"), "application/problem+json");
        let body = self.json();
        assert_eq!(body["status"], status);
        assert_eq!(body["code"], code);
        assert_eq!(body["type"], format!("urn:flankfit:problem:{code}"));
        assert_eq!(body["request_id"], self.header("x-request-id"));
        for key in ["title", "detail"] {
            assert!(body[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {body}");
        }
        body
    }

    /// The pointers of a 422.
    #[track_caller]
    pub fn pointers(&self) -> Vec<String> {
        let body = self.problem(422, "invalid_request");
        let errors = body["errors"].as_array().expect("errors");
        errors.iter().map(|error| error["pointer"].as_str().unwrap_or("?").to_owned()).collect()
    }
}

/// A small request that succeeds.
pub const CURVE: &str =
    r#"{"nodes":{"type":"curve","x":[0,1,2,3],"y":[1,3.1,4.9,7.2]},"model":{"type":"polynomial","degree":1}}"#;

/// One of a kind that is always left to the workers.
pub const WAITING_CURVE: &str = r#"{"nodes":{"type":"curve","x":[0,1,2,3],"y":[1,3.1,4.9,7.2]},
    "model":{"type":"polynomial","degree":1},"estimator":{"type":"rank"}}"#;
