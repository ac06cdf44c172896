//! A key is returned once: it is in no log, no metric, no span, no problem, no help and no
//! database.

use std::{
    fs,
    io::Read as _,
    process::{Command, Stdio},
};

use flankfit::{config::Authentication, jobs::Role};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use super::{
    collector::Collector,
    issuer::{Issuer, SigningKey},
    keys::key_of,
    talkative::Talkative,
};
use crate::{
    database::in_file,
    harness::{TestApp, send},
    postgres::{Server, shell},
    program::program,
};

/// True if some bytes hold the secret part of a key, whole or as binary.
fn holds(bytes: &[u8], key: &str) -> bool {
    let secret = &key[21..85];
    let binary: Vec<u8> = (0..32).map(|i| u8::from_str_radix(&secret[2 * i..2 * i + 2], 16).unwrap()).collect();
    [secret.as_bytes(), &binary].iter().any(|wanted| bytes.windows(wanted.len()).any(|window| window == *wanted))
}

#[tokio::test]
async fn a_secret_is_returned_once_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("test.db");
    let made = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["keys", "create", "--tenant", "default", "--role", "admin", "--database-url", &in_file(&database)])
        .env_clear()
        .output()
        .unwrap();
    let admin = String::from_utf8(made.stdout).unwrap().trim().to_owned();
    let collector = Collector::start();
    let server = Talkative::start(&database, &["--otlp-endpoint", &collector.url, "--otlp-sample", "1"]);
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
    let (status, created) = asked(make().bearer_auth(&admin)).await;
    assert_eq!(status, 201, "{created}");
    let canary = serde_json::from_str::<Value>(&created).unwrap()["key"].as_str().unwrap().to_owned();
    assert!(holds(created.as_bytes(), &canary), "this once");
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
    // the last one, behind all others
    collector.until(|spans| spans.iter().any(|span| span.name == "GET /readyz")).await;
    assert!(collector.spans().len() > 12, "every request was traced");
    let said = server.end();
    assert!(said.contains("DEBUG") && said.contains(&format!("key-{}", &canary[4..20])), "everything was logged");
    let spans = collector.bytes();
    for (what, bytes) in [
        ("answers", texts.as_bytes()),
        ("headers", answers.as_bytes()),
        ("log", said.as_bytes()),
        ("spans", &spans[..]),
    ] {
        assert!(!holds(bytes, &canary) && !holds(bytes, &admin), "{what}");
    }
    assert!(!spans.windows(16).any(|window| window == &canary.as_bytes()[4..20]), "nor do spans say whose it is");
    let mut files = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let mut bytes = Vec::new();
        fs::File::open(entry.unwrap().path()).unwrap().read_to_end(&mut bytes).unwrap();
        assert!(!holds(&bytes, &canary) && !holds(&bytes, &admin), "the database");
        files += usize::from(bytes.windows(16).any(|window| window == &canary.as_bytes()[4..20]));
    }
    assert!(files > 0, "the id of the key is there");
}

/// Bytes as `pg_dump` writes them.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_dump_of_the_database_holds_no_secret() {
    let server = Server::shared();
    let name = server.with_schema().await;
    let app = TestApp::start_with(|settings| {
        settings.database_url = server.url(&name);
        settings.auth = Authentication::Auto;
    })
    .await;
    let admin = key_of(&app, "default", Role::Admin).await;
    let ask = async |path: &str, body: Value| {
        let answer = send(app.post(path, body.to_string()).bearer_auth(&admin).header("idempotency-key", "one")).await;
        assert_eq!(answer.status, 201, "{}", answer.text);
        answer.json()["key"].as_str().unwrap().to_owned()
    };
    let canary = ask("/v1/keys", json!({"name": "canary", "role": "engineer"})).await;
    let rotated = ask(&format!("/v1/keys/{}/rotate", &canary[4..20]), json!({"overlap_seconds": 600})).await;
    for key in [&canary, &rotated] {
        let stored = send(app.post("/v1/jobs", r#"{"name":"wheel"}"#).bearer_auth(key)).await;
        assert_eq!(stored.status, 201, "{}", stored.text);
    }
    let mut dump = shell(&server.folder, &format!("$BIN/pg_dump -h \"$PWD\" -U owner {name}"));
    let dump = dump.stdout(Stdio::piped()).output().unwrap();
    assert!(dump.status.success());
    let text = String::from_utf8(dump.stdout).unwrap();
    for key in [&admin, &canary, &rotated] {
        let digest: [u8; 32] = Sha256::digest(key.as_bytes()).into();
        assert!(text.contains(&hex(&digest)), "its digest is there");
        // in digits, which are those of its bytes as well, and as the bytes of these digits
        assert!(!text.contains(&key[21..85]) && !text.contains(&hex(&key.as_bytes()[21..85])), "and it is not");
    }
    app.stop().await;
}

/// The parts of a token that nobody else must have: who has its claims alone cannot use them, but
/// they are nobody's business either.
fn parts(token: &str) -> Vec<&str> {
    token.split('.').skip(1).filter(|part| !part.is_empty()).collect()
}

#[tokio::test]
async fn a_token_appears_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("test.db");
    let (issuer, key) = (Issuer::start(), SigningKey::es256("one"));
    issuer.publish(&[&key]);
    let collector = Collector::start();
    let sampled = ["--otlp-endpoint", &collector.url, "--otlp-sample", "1"];
    let arguments = [&["--oidc-issuer", &issuer.url, "--oidc-audience", "flankfit"][..], &sampled].concat();
    let server = Talkative::start(&database, &arguments);
    let client = reqwest::Client::new();
    let url = |path: &str| format!("{}{path}", server.base);
    let good = issuer.token(&key, json!({"role": "engineer"}));
    let expired = issuer.token(&key, json!({"role": "engineer", "exp": 1_700_000_000}));
    let strange = issuer.token(&SigningKey::es256("two"), json!({"role": "engineer"}));
    let mut heard = String::new();
    for token in [&good, &expired, &strange, &format!("{good}x")] {
        for request in [
            client.get(url("/v1/whoami")).bearer_auth(token),
            client.post(url("/v1/jobs")).bearer_auth(token).json(&json!({"name": "wheel"})),
            client.post(url("/v1/fits")).bearer_auth(token).body("{"),
            client.get(url("/v1/jobs")).header("x-api-key", token),
            client.get(url("/metrics")).bearer_auth(token),
        ] {
            let answer = request.send().await.unwrap();
            heard.push_str(&format!("{} {:?}", answer.status(), answer.headers()));
            heard.push_str(&answer.text().await.unwrap());
        }
    }
    assert!(heard.contains("jane.doe") && heard.contains("invalid_key"), "{heard}");
    collector.until(|spans| spans.iter().any(|span| span.name == "GET /v1/whoami")).await;
    let said = server.end();
    assert!(said.contains("DEBUG") && said.contains("jane.doe") && said.contains("it has expired"), "{said}");
    let spans = String::from_utf8_lossy(&collector.bytes()).into_owned();
    assert!(spans.contains("/v1/whoami") && !spans.contains("jane.doe"), "who asks is in no span");
    for token in [&good, &expired, &strange] {
        for part in parts(token) {
            assert!(!heard.contains(part) && !said.contains(part) && !spans.contains(part), "{part}");
            for entry in fs::read_dir(folder.path()).unwrap() {
                let bytes = fs::read(entry.unwrap().path()).unwrap();
                assert!(!bytes.windows(part.len()).any(|window| window == part.as_bytes()), "the database");
            }
        }
    }
}

/// The program with these arguments, where each variable that may lead to a secret holds one.
fn output_of(arguments: &[&str], environment: &[(&str, &str)]) -> (Option<i32>, String) {
    let (code, out, err) = program(arguments, environment);
    (code, out + &err)
}

const PASSWORD: &str = "canary-2718281828";

#[test]
fn help_shows_no_secret() {
    let url = format!("postgres://u:{PASSWORD}@h/d");
    let variables: Vec<(&str, &str)> = [
        "FLANKFIT_DATABASE_URL",
        "FLANKFIT_DATABASE_DIRECT_URL",
        "FLANKFIT_API_KEYS_SHA256",
        "FLANKFIT_OIDC_ISSUER",
        "FLANKFIT_OIDC_JWKS_URL",
        "FLANKFIT_OTLP_ENDPOINT",
        "OTEL_EXPORTER_OTLP_HEADERS",
    ]
    .map(|name| (name, url.as_str()))
    .into();
    let (_, all) = output_of(&["--help"], &variables);
    let commands = all.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap();
    // continuation lines are indented further
    let commands = commands.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    let commands: Vec<&str> = commands.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.contains(&"backup") && commands.contains(&"healthcheck"), "{commands:?}");
    let mut shown = all.clone();
    for command in commands.iter().filter(|command| **command != "help") {
        let (code, help) = output_of(&[command, "--help"], &variables);
        assert_eq!(code, Some(0), "{help}");
        shown.push_str(&help);
    }
    for arguments in [&["keys", "create", "--help"][..], &["audit", "verify", "--help"], &["-h"]] {
        shown.push_str(&output_of(arguments, &variables).1);
    }
    for (name, _) in &variables {
        assert!(shown.contains(name), "{name}");
    }
    assert!(!shown.contains(PASSWORD), "{shown}");
}

/// Whatever is wrong with a URL, it is not repeated.
#[test]
fn errors_show_no_password() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    let archive = folder.path().join("archive");
    std::fs::write(&archive, "").unwrap();
    let (file, archive) = (file.to_str().unwrap(), archive.to_str().unwrap());
    let urls = ["postgre", "Postgres", "mysql", "sqlite"].map(|scheme| format!("{scheme}://u:{PASSWORD}@h/d"));
    let wrong_port = format!("postgres://u:{PASSWORD}@h:port/d");
    let slash = format!("postgres://u:12/{PASSWORD}@127.0.0.1/d");
    // nobody listens at port 1
    let away = format!("postgres://u:{PASSWORD}@127.0.0.1:1/d?passwrd={PASSWORD}");
    for url in urls.iter().chain([&wrong_port, &slash, &away]) {
        let url = url.as_str();
        for arguments in [
            &["serve", "--bind", "127.0.0.1:0", "--log", "trace", "--store-patience", "1", "--database-url", url][..],
            &["backup", file, "--database-url", url],
            &["export", file, "--database-url", url],
            &["import", archive, "--database-url", url],
            &["purge", "--older-than", "9", "--database-url", url],
            &["migrate", "--database-url", url],
            &["audit", "verify", "--database-url", url],
            &["keys", "create", "--role", "root", "--database-url", url],
        ] {
            let (code, said) = output_of(arguments, &[]);
            assert!(code.is_some_and(|code| code != 0) && !said.is_empty(), "{arguments:?}: {said}");
            assert!(!said.contains(PASSWORD), "{arguments:?}: {said}");
        }
    }
    let key = format!("ffk_{PASSWORD}");
    let issuer = format!("https://u:{PASSWORD}@id.example");
    type Variables<'a> = &'a [(&'a str, &'a str)];
    let joined = format!("--databse-url={issuer}");
    let others: [(&[&str], Variables<'_>); 13] = [
        (&["serve", "--api-keys-sha256", &key], &[]),
        (&["serve"], &[("FLANKFIT_API_KEYS_SHA256", key.as_str())]),
        (&["serve", "--oidc-audience", "a", "--oidc-issuer", &issuer], &[]),
        (&["serve", "--oidc-audience", "a"], &[("FLANKFIT_OIDC_ISSUER", issuer.as_str())]),
        (&["serve", "--oidc-audience", "a", "--oidc-issuer", "https://id.example", "--oidc-jwks-url", &issuer], &[]),
        (&["serve", "--otlp-endpoint", &issuer], &[]),
        (&["serve", "--otlp-endpoint", "http://127.0.0.1:1", "--otlp-headers", PASSWORD], &[]),
        (&["migrate", &issuer], &[]),
        (&["serve", "--databse-url", &issuer], &[]),
        (&["serve", &joined], &[]),
        (&[&issuer], &[]),
        (&["purge", "--older-than", &issuer], &[]),
        (&["export", "to", &issuer], &[]),
    ];
    for (arguments, variables) in others {
        let (code, said) = output_of(arguments, variables);
        assert!(code.is_some_and(|code| code != 0) && !said.is_empty(), "{arguments:?}: {said}");
        assert!(!said.contains(PASSWORD), "{arguments:?}: {said}");
    }
}
