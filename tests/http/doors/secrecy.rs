//! A key is told once: it is in no log, no metric, no problem, no help and no database.

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _},
    path::Path,
    process::{Child, Command, Stdio},
    sync::{Arc, Mutex},
};

use serde_json::{Value, json};

use crate::database::in_file;

/// A server that logs everything, and what it has said.
struct Talkative {
    child: Child,
    base: String,
    said: Arc<Mutex<String>>,
}

impl Talkative {
    fn start(database: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_flankfit"))
            .args(["serve", "--bind", "127.0.0.1:0", "--log-format", "json", "--log", "trace", "--database-url"])
            .arg(in_file(database))
            .env_clear()
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let said = Arc::<Mutex<String>>::default();
        let mut line = String::new();
        let address = loop {
            line.clear();
            assert_ne!(log.read_line(&mut line).unwrap(), 0, "the server ended before it listened");
            said.lock().unwrap().push_str(&line);
            let entry: Value = serde_json::from_str(&line).unwrap_or_default();
            if let Some(address) = entry["address"].as_str() {
                break address.to_owned();
            }
        };
        let heard = said.clone();
        std::thread::spawn(move || {
            let mut line = String::new();
            while log.read_line(&mut line).is_ok_and(|length| length > 0) {
                heard.lock().unwrap().push_str(&line);
                line.clear();
            }
        });
        Talkative { child, base: format!("http://{address}"), said }
    }
}

/// Whether some bytes hold the secret part of a key, whole or as binary.
fn holds(bytes: &[u8], key: &str) -> bool {
    let secret = &key[21..85];
    let binary: Vec<u8> = (0..32).map(|i| u8::from_str_radix(&secret[2 * i..2 * i + 2], 16).unwrap()).collect();
    [secret.as_bytes(), &binary].iter().any(|wanted| bytes.windows(wanted.len()).any(|window| window == *wanted))
}

#[tokio::test]
async fn a_secret_is_told_once_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("test.db");
    let made = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["keys", "create", "--tenant", "default", "--role", "admin", "--database-url", &in_file(&database)])
        .env_clear()
        .output()
        .unwrap();
    let admin = String::from_utf8(made.stdout).unwrap().trim().to_owned();
    let mut server = Talkative::start(&database);
    let client = reqwest::Client::new();
    let mut answers = String::new();
    let mut asked = async |request: reqwest::RequestBuilder| {
        let answer = request.send().await.unwrap();
        let (status, headers) = (answer.status().as_u16(), format!("{:?}", answer.headers()));
        let text = answer.text().await.unwrap();
        answers.push_str(&headers);
        (status, text)
    };
    let url = |path: &str| format!("{}{path}", server.base);
    let make = || {
        client.post(url("/v1/keys")).header("idempotency-key", "one").json(&json!({"name": "canary", "role": "reader"}))
    };
    let (status, told) = asked(make().bearer_auth(&admin)).await;
    assert_eq!(status, 201, "{told}");
    let canary = serde_json::from_str::<Value>(&told).unwrap()["key"].as_str().unwrap().to_owned();
    assert!(holds(told.as_bytes(), &canary), "this once");
    // every way in which it is sent, right and wrong, and what comes back
    let mut texts = String::new();
    for request in [
        make().bearer_auth(&admin),
        client.get(url("/v1/keys")).bearer_auth(&admin),
        client.get(url("/v1/jobs")).bearer_auth(&canary),
        client.get(url("/v1/jobs")).header("x-api-key", &canary),
        client.get(url("/v1/jobs")).header("authorization", format!("Basic {canary}")),
        client.get(url("/v1/jobs")).bearer_auth(format!("{canary}0")),
        client.delete(url("/v1/jobs/0190b0de-0000-7000-8000-000000000000")).bearer_auth(&canary),
        client.post(url("/v1/fits")).bearer_auth(&canary).body("{"),
        client.post(url("/v1/fits")).bearer_auth(&canary).json(&json!({"nodes": 1})),
        client.get(url("/metrics")),
        client.get(url("/readyz")),
    ] {
        texts.push_str(&asked(request).await.1);
    }
    assert!(texts.contains("flankfit_auth_total") && texts.contains(&canary[4..20]), "{texts}");
    let help = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["serve", "--help"])
        .env("FLANKFIT_API_KEYS_SHA256", &canary)
        .output()
        .unwrap();
    texts.push_str(&String::from_utf8_lossy(&help.stdout));
    let told = Command::new("kill").args(["-TERM", &server.child.id().to_string()]).status().unwrap();
    assert!(told.success() && server.child.wait().unwrap().success());
    let said = server.said.lock().unwrap().clone();
    assert!(said.contains("DEBUG") && said.contains(&format!("key-{}", &canary[4..20])), "everything was logged");
    for (what, bytes) in [("answers", texts.as_bytes()), ("headers", answers.as_bytes()), ("log", said.as_bytes())] {
        assert!(!holds(bytes, &canary) && !holds(bytes, &admin), "{what}");
    }
    let mut files = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let mut bytes = Vec::new();
        fs::File::open(entry.unwrap().path()).unwrap().read_to_end(&mut bytes).unwrap();
        assert!(!holds(&bytes, &canary) && !holds(&bytes, &admin), "the database");
        files += usize::from(bytes.windows(16).any(|window| window == &canary.as_bytes()[4..20]));
    }
    assert!(files > 0, "the id of the key is there");
}
