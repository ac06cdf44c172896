//! Metrics by their values. Servers of one process share its metrics, so each of these is a process
//! of its own.

use std::time::{Duration, Instant};

use reqwest::{Client, RequestBuilder};
use tokio::time::sleep;

use super::{
    issuer::{Issuer, SigningKey},
    talkative::Talkative,
};
use crate::{
    database::in_file,
    harness::{figure, ready, send},
    plant::proxy::free_address,
    program::program,
};

/// For so long something is waited for that has no time of its own.
const PATIENCE: Duration = Duration::from_secs(60);
const SEAL_AGE: &str = "flankfit_audit_seal_age_seconds";
const SEAL_INTERVAL: &str = "flankfit_audit_seal_interval_seconds";

/// A server and who asks it.
struct Asked {
    server: Talkative,
    client: Client,
    folder: tempfile::TempDir,
}

impl Asked {
    fn start(arguments: &[&str]) -> Self {
        Self::start_in(tempfile::tempdir().unwrap(), arguments)
    }

    fn start_in(folder: tempfile::TempDir, arguments: &[&str]) -> Self {
        let server = Talkative::start(&folder.path().join("test.db"), arguments);
        Asked { server, client: Client::builder().no_proxy().build().unwrap(), folder }
    }

    fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(format!("{}{path}", self.server.base))
    }

    async fn new_job(&self) {
        let request = self.client.post(format!("{}/v1/jobs", self.server.base));
        let made = send(request.header("content-type", "application/json").body(r#"{"name":"wheel"}"#)).await;
        assert_eq!(made.status, 201, "{}", made.text);
    }

    async fn figure(&self, series: &str) -> Option<f64> {
        figure(&send(self.get("/metrics")).await.text, series)
    }

    /// Waits until a series has a figure that is wanted.
    async fn until(&self, series: &str, is_wanted: impl Fn(f64) -> bool) {
        let begun = Instant::now();
        loop {
            let figure = self.figure(series).await;
            if figure.is_some_and(&is_wanted) {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "{series}: {figure:?}");
            sleep(Duration::from_millis(50)).await;
        }
    }
}

/// Requests to the versioned interface, by outcome.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    ok: f64,
    missing: f64,
    invalid: f64,
    forbidden: f64,
    none: f64,
}

async fn counts(asked: &Asked) -> Counts {
    let metrics = send(asked.get("/metrics")).await.text;
    // a counter that has not counted yet is absent
    let of = |name: &str| figure(&metrics, &format!("flankfit_auth_total{{outcome=\"{name}\"}}")).unwrap_or(0.0);
    Counts {
        ok: of("ok"),
        missing: of("missing"),
        invalid: of("invalid"),
        forbidden: of("forbidden"),
        none: of("none"),
    }
}

#[tokio::test]
async fn callers_are_counted_by_the_kind_of_their_key() {
    let folder = tempfile::tempdir().unwrap();
    let url = in_file(&folder.path().join("test.db"));
    let create = ["keys", "create", "--tenant", "default", "--role", "reader", "--database-url", &url];
    let (code, key, said) = program(&create, &[]);
    assert_eq!(code, Some(0), "{said}");
    let asked = Asked::start_in(folder, &["--auth", "required"]);
    let refusals = r#"flankfit_shed_total{reason="refusals"}"#;
    assert_eq!(counts(&asked).await, Counts::default());
    for _ in 0..3 {
        assert_eq!(send(asked.get("/v1/jobs").bearer_auth(key.trim())).await.status, 200);
    }
    for _ in 0..2 {
        send(asked.get("/v1/jobs")).await.problem(401, "unauthorized");
    }
    for _ in 0..4 {
        send(asked.get("/v1/jobs").bearer_auth("wrong")).await.problem(401, "invalid_key");
    }
    // let in, but not to this
    send(asked.get("/v1/keys").bearer_auth(key.trim())).await.problem(403, "forbidden");
    // no key is required here
    assert_eq!(send(asked.get("/healthz").bearer_auth("wrong")).await.status, 200);
    let so_far = Counts { ok: 4.0, missing: 2.0, invalid: 4.0, forbidden: 1.0, none: 0.0 };
    assert_eq!(counts(&asked).await, so_far);
    assert_eq!(asked.figure(refusals).await.unwrap_or(0.0), 0.0);
    // and who goes on guessing is turned away
    let mut guessed = 1.0;
    while send(asked.get("/v1/jobs").bearer_auth("wrong")).await.status == 401 {
        guessed += 1.0;
        assert!(guessed < 1000.0, "nobody is turned away");
    }
    assert_eq!(asked.figure(refusals).await, Some(1.0));
    assert_eq!(counts(&asked).await, Counts { invalid: so_far.invalid + guessed, ..so_far });
}

#[tokio::test]
async fn callers_of_an_open_server_are_counted_too() {
    let asked = Asked::start(&["--auth", "off"]);
    assert_eq!(counts(&asked).await, Counts::default());
    for _ in 0..3 {
        assert_eq!(send(asked.get("/v1/jobs")).await.status, 200);
    }
    assert_eq!(counts(&asked).await, Counts { none: 3.0, ..Counts::default() });
}

/// Nobody requests readiness here.
#[tokio::test]
async fn the_store_is_checked_without_readiness_requests() {
    let asked = Asked::start(&[]);
    // a store that takes longer than a second is asked again
    asked.until("flankfit_store_up", |figure| figure == 1.0).await;
}

#[tokio::test]
async fn draining_is_a_metric() {
    // longer than this test: what is left of it is killed
    let asked = Asked::start(&["--drain-delay", "600"]);
    assert_eq!(asked.figure("flankfit_draining").await, Some(0.0));
    ready(&asked.get("/readyz")).await;
    asked.server.terminate();
    asked.until("flankfit_draining", |figure| figure == 1.0).await;
    send(asked.get("/readyz")).await.problem(503, "draining");
}

/// The age grows while seals cannot be written, and is nothing once they are.
#[tokio::test]
async fn the_age_of_the_last_seal_is_a_metric() {
    let folder = tempfile::tempdir().unwrap();
    let seals = folder.path().join("seals");
    std::fs::create_dir(&seals).unwrap();
    let file = seals.join("file");
    let arguments = ["--audit-seal-seconds", "1", "--audit-seal-file", file.to_str().unwrap()];
    let asked = Asked::start_in(folder, &arguments);
    asked.until(SEAL_AGE, |age| (0.0..60.0).contains(&age)).await;
    assert_eq!(asked.figure(SEAL_INTERVAL).await, Some(1.0));
    let away = asked.folder.path().join("away");
    std::fs::rename(&seals, &away).unwrap();
    asked.new_job().await;
    let begun = Instant::now();
    while !asked.server.said().contains("could not be appended") {
        assert!(begun.elapsed() < PATIENCE, "{}", asked.server.said());
        sleep(Duration::from_millis(50)).await;
    }
    asked.until(SEAL_AGE, |age| age > 6.0).await;
    std::fs::rename(&away, &seals).unwrap();
    asked.until(SEAL_AGE, |age| age < 5.0).await;
    assert!(std::fs::read_to_string(&file).unwrap().contains("\"last_entry\""));
}

#[tokio::test]
async fn availability_of_the_identity_provider_is_a_metric() {
    let there = Issuer::start();
    there.publish(&[&SigningKey::es256("one")]);
    let nobody = format!("http://{}/realms/plant", free_address());
    for (issuer, is_up) in [(&there.url, 1.0), (&nobody, 0.0)] {
        let asked = Asked::start(&["--oidc-issuer", issuer, "--oidc-audience", "flankfit"]);
        asked.until("flankfit_identity_provider_up", |figure| figure == is_up).await;
    }
}
