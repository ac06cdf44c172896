//! `kill -9` under concurrent writers: everything acknowledged with 201 is there afterwards, whole.

use std::{
    io::{BufRead, BufReader},
    net::{IpAddr, Ipv4Addr, SocketAddr},
    process::{Child, Command, Stdio},
    sync::{Arc, Mutex},
};

use reqwest::Client;
use serde_json::{Value, json};
use sqlx::{ConnectOptions, Connection, sqlite::SqliteConnectOptions};
use tokio::sync::Notify;

use super::app::{alone, iteration, send};
use crate::database::{self, in_file};

const ROUNDS: usize = 12;
const WRITERS: usize = 8;
const ANY_PORT: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// Errors logged by servers of this process: the reasons for missing responses.
pub static ERRORS: Mutex<Vec<String>> = Mutex::new(Vec::new());

pub struct Server {
    child: Child,
    pub base: String,
}

impl Server {
    /// Starts the built program on a free port, which is in its log.
    pub fn start(database_url: &str) -> Self {
        Self::start_at(ANY_PORT, database_url, &[])
    }

    /// The same at an address, with further arguments.
    pub fn start_at(address: SocketAddr, database_url: &str, arguments: &[&str]) -> Self {
        // the PostgreSQL server of the tests syncs nothing
        let arguments = [&["--unsafe-store"], arguments].concat();
        Self::start_by(Command::new(env!("CARGO_BIN_EXE_flankfit")), address, database_url, &arguments)
    }

    /// The same on a file, with further arguments.
    pub fn start_with(database: &std::path::Path, arguments: &[&str]) -> Self {
        Self::start_by(Command::new(env!("CARGO_BIN_EXE_flankfit")), ANY_PORT, &in_file(database), arguments)
    }

    /// The same within a limit of the shell.
    #[cfg(unix)]
    pub fn start_within(limit: &str, database: &std::path::Path) -> Self {
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", &format!("{limit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_flankfit")]);
        Self::start_by(shell, ANY_PORT, &in_file(database), &[])
    }

    fn start_by(mut command: Command, address: SocketAddr, database_url: &str, arguments: &[&str]) -> Self {
        let mut child = command
            .args(["serve", "--log-format", "json", "--log", "info", "--auth", "off"])
            .args(["--database-url", database_url, "--bind"])
            .arg(address.to_string())
            .args(arguments)
            .env_clear()
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        let address = loop {
            line.clear();
            assert_ne!(log.read_line(&mut line).unwrap(), 0, "the server ended before it listened");
            let entry: Value = serde_json::from_str(&line).unwrap_or_default();
            if let Some(address) = entry["address"].as_str() {
                break address.to_owned();
            }
        };
        // The log must go on being read, or the server would block on a full pipe.
        std::thread::spawn(move || {
            let errors = log.lines().map_while(Result::ok).filter(|line| line.contains("\"level\":\"ERROR\""));
            errors.for_each(|line| ERRORS.lock().unwrap().push(line));
        });
        Server { child, base: format!("http://{address}") }
    }

    /// Id of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Asks the process to stop, as a service manager does.
    pub fn terminate(&self) {
        self.signal("-TERM");
    }

    fn signal(&self, signal: &str) {
        let status = Command::new("kill").args([signal, &self.id().to_string()]).status().unwrap();
        assert!(status.success());
    }

    /// Exit status of the process, if it has ended.
    pub fn ended(&mut self) -> Option<std::process::ExitStatus> {
        self.child.try_wait().unwrap()
    }

    pub fn kill(mut self) {
        // On Unix this is SIGKILL.
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// A disk that takes no more is a refusal and a server that says that it is not ready, not its end.
#[cfg(unix)]
#[tokio::test]
async fn a_full_disk_is_not_the_end() {
    let directory = tempfile::tempdir().unwrap();
    // its files cannot become longer than 4,096 blocks of the shell
    let server = Server::start_within("ulimit -f 4096", &directory.path().join("jobs.db"));
    let client = Client::new();
    let status = |path: &'static str| {
        let request = client.get(format!("{}{path}", server.base));
        async move { request.send().await.unwrap().status().as_u16() }
    };
    crate::harness::ready(&client.get(format!("{}/readyz", server.base))).await;
    let tags: std::collections::BTreeMap<_, _> = (0..50).map(|i| (format!("t{i}"), "x".repeat(50))).collect();
    let refusal = loop {
        let job = json!({"name": "w", "tags": tags});
        let answer = client.post(format!("{}/v1/jobs", server.base)).json(&job).send().await.unwrap();
        if answer.status() != 201 {
            break answer.json::<Value>().await.unwrap();
        }
    };
    assert_eq!((&refusal["status"], &refusal["code"]), (&json!(503), &json!("store_unavailable")), "{refusal}");
    // what was written last may have been believed for a second
    while status("/readyz").await != 503 {
        tokio::task::yield_now().await;
    }
    assert_eq!((status("/healthz").await, status("/v1/jobs").await), (200, 200), "what is stored can be read");
    server.kill();
}

/// With fewer handles than there are idle clients, an honest one is served, and the store has its
/// files.
#[cfg(unix)]
#[tokio::test]
async fn idle_clients_do_not_take_all_handles() {
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start_within("ulimit -n 256", &directory.path().join("jobs.db"));
    let address = server.base.trim_start_matches("http://").to_owned();
    let mut idle = Vec::new();
    for _ in 0..300 {
        idle.push(tokio::net::TcpStream::connect(&address).await.unwrap());
    }
    for _ in 0..3 {
        let client = Client::new();
        let job = client.post(format!("{}/v1/jobs", server.base)).json(&json!({"name": "w"})).send().await.unwrap();
        assert_eq!(job.status(), 201);
    }
    server.kill();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn acknowledged_changes_survive_a_kill() {
    let directory = tempfile::tempdir().unwrap();
    let database = database::url(directory.path()).await;
    let answered: Arc<Mutex<Vec<Value>>> = Arc::default();
    let news = Arc::new(Notify::new());
    let mut job = String::new();
    let mut checked = 0;
    for round in 0..ROUNDS {
        let server = Server::start(&database);
        let client = Client::new();
        if job.is_empty() {
            let created =
                send(client.post(format!("{}/v1/jobs", server.base)).json(&json!({"name": "w"}))).await.expect(201);
            job = created.header("location").unwrap().to_owned();
        }
        let so_far = answered.lock().unwrap().clone();
        check(&client, &server.base, &job, &so_far, &mut checked).await;

        let url = format!("{}{job}/iterations", server.base);
        let before = answered.lock().unwrap().len();
        let writers: Vec<_> = (0..WRITERS)
            .map(|_| {
                let (client, url, answered, news) = (client.clone(), url.clone(), answered.clone(), news.clone());
                tokio::spawn(async move {
                    // Until the connection breaks.
                    while let Ok(response) = client.post(&url).json(&iteration()).send().await {
                        let created = response.status() == reqwest::StatusCode::CREATED;
                        let Ok(text) = response.text().await else { break };
                        assert!(created, "{text}");
                        answered.lock().unwrap().push(serde_json::from_str(&text).unwrap());
                        news.notify_one();
                    }
                })
            })
            .collect();
        // Another number of responses, and another moment within a write, each time.
        let enough = before + 5 + 17 * round % 60;
        loop {
            let another = news.notified();
            if answered.lock().unwrap().len() >= enough {
                break;
            }
            another.await;
        }
        server.kill();
        for writer in writers {
            writer.await.unwrap();
        }
        assert!(answered.lock().unwrap().len() >= enough);

        let Some(file) = database.strip_prefix("sqlite://") else { continue };
        let mut own = SqliteConnectOptions::new().filename(file).connect().await.unwrap();
        let findings: Vec<String> = sqlx::query_scalar("PRAGMA integrity_check").fetch_all(&mut own).await.unwrap();
        assert_eq!(findings, ["ok"]);
        let strays: Vec<String> = sqlx::query_scalar("PRAGMA foreign_key_check").fetch_all(&mut own).await.unwrap();
        assert!(strays.is_empty(), "{strays:?}");
        own.close().await.unwrap();
    }
    let server = Server::start(&database);
    let all = answered.lock().unwrap().clone();
    check(&Client::new(), &server.base, &job, &all, &mut checked).await;
    assert_eq!(checked, all.len());
    server.kill();
}

/// Everything acknowledged is returned as in its response, and the numbers have no gap.
async fn check(client: &Client, base: &str, job: &str, answered: &[Value], checked: &mut usize) {
    let mut iterations = Vec::new();
    let mut cursor = String::new();
    loop {
        let trace = send(client.get(format!("{base}{job}/trace?limit=200{cursor}"))).await.expect(200).json();
        iterations.extend(trace["iterations"].as_array().unwrap().iter().cloned());
        let Some(next) = trace["next_cursor"].as_str() else { break };
        cursor = format!("&cursor={next}");
    }
    for (index, iteration) in iterations.iter().enumerate() {
        assert_eq!(iteration["number"], index + 1);
        assert_eq!((&iteration["fits"][0]["chosen"], iteration["fits"].as_array().unwrap().len()), (&json!(true), 1));
    }
    assert!(iterations.len() >= answered.len());
    for acknowledged in &answered[*checked..] {
        let number = acknowledged["number"].as_u64().unwrap();
        let fit = alone(acknowledged, "/fits/0");
        let place = format!("{base}{job}/iterations/{number}/fits/{}", fit["id"].as_str().unwrap());
        assert_eq!(send(client.get(place)).await.expect(200).json(), fit);
    }
    *checked = answered.len();
}
