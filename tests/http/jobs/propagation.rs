//! Separate servers on one PostgreSQL database: changes at one take effect at the other in time,
//! with or without notification, and requests that need no store continue without it.

use std::time::{Duration, Instant};

use flankfit::{
    config::{Authentication, MigrateMode, ServeSettings},
    jobs::Role,
};
use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use tokio::time::{sleep, timeout};

use super::{
    app::{Answer, iteration, send},
    events::Listener,
    kill,
    progress::{result, slow_iteration, with_progress},
    several::Replicas,
    socket,
    streams::{block, spec},
};
use crate::{
    access::keys::{key_of, key_on},
    harness::{CURVE, TestApp, figure},
    postgres::{Server, shell},
    program::program,
};

const STOP: &str = "$BIN/pg_ctl -D data -m immediate -w stop";
const START: &str = "$BIN/pg_ctl -D data -l log -w start";
const RESTART: &str = "$BIN/pg_ctl -D data -l log -m fast -w restart";
/// For so long something is waited for that has no time of its own.
const PATIENCE: Duration = Duration::from_secs(60);

/// Configures a direct URL behind which there is nobody, so that no notification arrives.
fn without_notifications(settings: &mut ServeSettings) {
    settings.postgres.database_direct_url = Some("postgres://nobody@127.0.0.1:1/nowhere".to_owned());
    settings.postgres.migrate = MigrateMode::Check;
}

fn run(server: &Server, script: &str) {
    assert!(shell(&server.folder, script).status().unwrap().success(), "{script}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_revoked_key_is_refused_at_the_other_server_within_five_seconds() {
    for notified in [true, false] {
        let replicas = Replicas::on_postgres_with(2, |settings| {
            settings.auth = Authentication::Auto;
            if !notified {
                without_notifications(settings);
            }
        })
        .await;
        let admin = key_on(&replicas.states[0], "default", Role::Admin).await;
        let reader = key_on(&replicas.states[0], "default", Role::Reader).await;
        let asked = |key: &str| send(replicas.request(1, Method::GET, "/v1/jobs").bearer_auth(key));
        for _ in 0..3 {
            asked(&reader).await.expect(200);
        }
        let place = format!("/v1/keys/{}", &reader[4..20]);
        send(replicas.request(0, Method::DELETE, &place).bearer_auth(&admin)).await.expect(204);
        let revoked = Instant::now();
        let refused = loop {
            let asked_after = revoked.elapsed();
            let answer = asked(&reader).await;
            if answer.status != 200 {
                break answer;
            }
            // what is asked later is refused, however long the answer takes
            assert!(asked_after < Duration::from_secs(5), "notified: {notified}");
            sleep(Duration::from_millis(20)).await;
        };
        refused.problem(401, "invalid_key");
        println!("notified: {notified}; refused after {:?}", revoked.elapsed());
        // the other keys go on
        asked(&admin).await.expect(200);
    }
}

/// Open connections at one server end when the key is revoked at the other: within thirty seconds,
/// with or without notification.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn open_connections_at_the_other_server_end_with_a_revoked_key() {
    const WITHIN: Duration = Duration::from_secs(30);
    for notified in [true, false] {
        let replicas = Replicas::on_postgres_with(2, |settings| {
            settings.auth = Authentication::Auto;
            if !notified {
                without_notifications(settings);
            }
        })
        .await;
        let admin = key_on(&replicas.states[0], "default", Role::Admin).await;
        let key = key_on(&replicas.states[0], "default", Role::Engineer).await;
        let made = async |path: &str, body: &Value| {
            let request = replicas.request(1, Method::POST, path).bearer_auth(&key).json(body);
            send(request).await.expect(201).header("location").unwrap().to_owned()
        };
        let job = made("/v1/jobs", &json!({"name": "wheel"})).await;
        let stream = made(&format!("{job}/streams"), &spec()).await;
        let events = replicas.request(1, Method::GET, &format!("{job}/events")).bearer_auth(&key);
        let mut listener = Listener::of(events, None).await.unwrap();
        assert!(listener.next().await.is_some(), "the stream was opened");
        let mut socket = socket::connect_with(&replicas.bases[1], &stream, &key).await;
        let revoked = Instant::now();
        let place = format!("/v1/keys/{}", &key[4..20]);
        send(replicas.request(0, Method::DELETE, &place).bearer_auth(&admin)).await.expect(204);
        let closed = timeout(WITHIN, socket::close(&mut socket)).await.expect("the WebSocket ends");
        assert_eq!(closed.map(u16::from), Some(1008), "notified: {notified}");
        let next = timeout(WITHIN, listener.next()).await.expect("the events end");
        assert!(next.is_none(), "notified: {notified}");
        assert!(revoked.elapsed() < WITHIN, "notified: {notified}; after {:?}", revoked.elapsed());
        println!("notified: {notified}; both ended after {:?}", revoked.elapsed());
    }
}

/// Responses kept under a key are the same at every server.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn stored_responses_are_the_same_on_every_server() {
    let replicas = Replicas::on_postgres(2).await;
    let path = format!("{}/iterations", replicas.job().await);
    let watched = result(with_progress(replicas.keyed(0, &path, "watched", &slow_iteration()))).await;
    let seen = |answer: &Answer| {
        let headers = ["location", "etag", "content-type"].map(|name| answer.header(name).map(str::to_owned));
        (headers, answer.text.clone())
    };
    let first = send(replicas.keyed(1, &path, "watched", &slow_iteration())).await.expect(201);
    assert!(first.header("location").is_some() && first.text == watched, "{watched}");
    // and of one that was plain from the beginning
    let plain = send(replicas.keyed(0, &path, "plain", &iteration())).await.expect(201);
    assert_eq!(plain.header("idempotency-replayed"), None);
    for (key, body, first) in [("watched", slow_iteration(), &first), ("plain", iteration(), &plain)] {
        for replica in [1, 0] {
            let kept = send(replicas.keyed(replica, &path, key, &body)).await.expect(201);
            assert_eq!(kept.header("idempotency-replayed"), Some("true"));
            assert_eq!(seen(&kept), seen(first), "{key} at {replica}");
        }
    }
    for (key, body) in [("watched", iteration()), ("plain", slow_iteration())] {
        send(replicas.keyed(1, &path, key, &body)).await.problem(422, "idempotency_key_reused");
    }
    let trace = replicas.get(1, &path.replace("iterations", "trace")).await.expect(200).json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 2);
}

/// Who was seen before computes on while the database is away; nobody else is let in, and the
/// server says that it can store nothing.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn fits_outlive_the_database() {
    let server = Server::start();
    let url = server.database().await;
    let app = TestApp::start_with(|settings| {
        settings.database_url.clone_from(&url);
        settings.auth = Authentication::Auto;
        settings.postgres.store_patience = 1;
    })
    .await;
    let (seen, unseen) = (key_of(&app, "default", Role::Engineer).await, key_of(&app, "default", Role::Engineer).await);
    let get = async |path: &str| app.get(path).send().await.unwrap().status().as_u16();
    let fit = async |key: &str| crate::harness::send(app.post("/v1/fits", CURVE).bearer_auth(key)).await;
    let first = fit(&seen).await;
    crate::harness::ready(&app.get("/readyz")).await;
    assert_eq!((first.status.as_u16(), get("/readyz?for=compute").await), (200, 200));

    run(&server, STOP);
    let stopped = Instant::now();
    while get("/readyz").await != 503 {
        assert!(stopped.elapsed() < PATIENCE, "it still says that it is ready");
        sleep(Duration::from_millis(50)).await;
    }
    // longer than a key is trusted while the store responds
    let stopped = Instant::now();
    while stopped.elapsed() < Duration::from_secs(6) {
        let answer = fit(&seen).await;
        assert_eq!((answer.status.as_u16(), &answer.text), (200, &first.text), "after {:?}", stopped.elapsed());
        assert_eq!((get("/readyz").await, get("/readyz?for=compute").await, get("/healthz").await), (503, 200, 200));
        sleep(Duration::from_millis(200)).await;
    }
    fit(&unseen).await.problem(503, "store_unavailable");
    let store = crate::harness::send(app.post("/v1/jobs", r#"{"name":"wheel"}"#).bearer_auth(&seen)).await;
    store.problem(503, "store_unavailable");

    run(&server, START);
    let started = Instant::now();
    while get("/readyz").await != 200 {
        assert!(started.elapsed() < PATIENCE, "it does not become ready again");
        sleep(Duration::from_millis(50)).await;
    }
    // a busy machine may take longer to connect anew than the store is waited for here
    let started = Instant::now();
    let patiently = async |request: RequestBuilder| loop {
        let answer = crate::harness::send(request.try_clone().unwrap()).await;
        if answer.status != 503 {
            return answer;
        }
        answer.problem(503, "store_unavailable");
        assert!(started.elapsed() < PATIENCE, "{}", answer.text);
    };
    assert_eq!(patiently(app.post("/v1/fits", CURVE).bearer_auth(&unseen)).await.status, 200);
    let stored = patiently(app.post("/v1/jobs", r#"{"name":"wheel"}"#).bearer_auth(&seen)).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
}

/// The first key on a PostgreSQL database that has nothing yet: it gets its schema, unless that is
/// another's task.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn the_first_key_makes_the_schema_of_an_empty_database() {
    let server = Server::shared();
    let url = server.url(&server.copy_of("template1").await);
    let create = |more: &[&str]| {
        let own =
            ["keys", "create", "--tenant", "plant-7", "--role", "admin", "--unsafe-store", "--database-url", &url];
        let (code, key, said) = program(&[&own[..], more].concat(), &[]);
        (code == Some(0), key, said)
    };
    let (done, key, said) = create(&["--migrate", "check"]);
    assert!(!done && key.is_empty() && said.contains("flankfit migrate"), "{said}");
    let (done, key, said) = create(&[]);
    assert!(done && key.len() == 94 && key.starts_with("ffk_") && key.ends_with('\n'), "{key}{said}");
    let app = TestApp::start_with(|settings| {
        settings.database_url.clone_from(&url);
        settings.auth = Authentication::Auto;
        settings.postgres.migrate = MigrateMode::Check;
    })
    .await;
    let who = crate::harness::send(app.get("/v1/whoami").bearer_auth(key.trim())).await;
    assert_eq!((who.status.as_u16(), &who.json()["tenant"]), (200, &json!("plant-7")), "{}", who.text);
    crate::harness::send(app.get("/v1/whoami")).await.problem(401, "unauthorized");
    // and a second one is no other schema
    assert!(create(&["--migrate", "check"]).0);
}

/// Two programs, each with metrics of its own.
struct Programs {
    client: Client,
    servers: [kill::Server; 2],
}

impl Programs {
    async fn ask(&self, replica: usize, method: Method, path: &str, body: Option<&Value>) -> Answer {
        let request = self.client.request(method, format!("{}{path}", self.servers[replica].base));
        send(body.into_iter().fold(request, |request, body| request.json(body))).await
    }

    /// The figure of a metric without labels.
    async fn figure(&self, replica: usize, metric: &str) -> Option<f64> {
        let text = self.ask(replica, Method::GET, "/metrics", None).await.expect(200).text;
        figure(&text, metric)
    }

    /// So many jobs that every writer has some.
    async fn write(&self) {
        for number in 0..24 {
            let job = json!({"name": format!("wheel {number}")});
            self.ask(0, Method::POST, "/v1/jobs", Some(&job)).await.expect(201);
        }
    }

    async fn ready_once(&self, status: u16) {
        let asked = Instant::now();
        while self.ask(0, Method::GET, "/readyz", None).await.status != status {
            assert!(asked.elapsed() < PATIENCE, "/readyz is never {status}");
            sleep(Duration::from_millis(50)).await;
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn metrics_show_the_state_of_store_and_streams() {
    let server = Server::start();
    let url = server.database().await;
    let servers = [kill::Server::start(&url), kill::Server::start(&url)];
    let plant = Programs { client: Client::builder().no_proxy().build().unwrap(), servers };
    plant.ready_once(200).await;
    assert_eq!(plant.figure(0, "flankfit_store_up").await, Some(1.0));
    // one machine, one clock
    let skew = plant.figure(0, "flankfit_clock_skew_seconds").await;
    assert!(skew.is_some_and(|skew| skew.abs() < 0.5), "{skew:?}");

    // a block that came to the other one, of which the first has not heard
    let job = plant.ask(0, Method::POST, "/v1/jobs", Some(&json!({"name": "wheel"}))).await.expect(201);
    let streams = format!("{}/streams", job.header("location").unwrap());
    let stream = plant.ask(0, Method::POST, &streams, Some(&spec())).await.expect(201);
    let nodes = format!("{}/nodes", stream.header("location").unwrap());
    assert_eq!(plant.figure(0, "flankfit_stream_catch_ups_total").await.unwrap_or(0.0), 0.0);
    for (sequence, replica) in [(1, 0), (2, 1), (3, 0)] {
        let from = 40 * (sequence as usize - 1);
        plant.ask(replica, Method::POST, &nodes, Some(&block(sequence, from..from + 40))).await.expect(200);
    }
    assert_eq!(plant.figure(0, "flankfit_stream_catch_ups_total").await, Some(1.0));
    assert_eq!(plant.figure(1, "flankfit_stream_catch_ups_total").await.unwrap_or(0.0), 0.0);

    // each writer's connection is gone, so its next transaction is tried again
    plant.write().await;
    let before = plant.figure(0, "flankfit_store_retries_total").await.unwrap_or(0.0);
    run(&server, RESTART);
    plant.write().await;
    let after = plant.figure(0, "flankfit_store_retries_total").await;
    assert!(after.is_some_and(|after| after > before), "{before}, then {after:?}");

    run(&server, STOP);
    plant.ready_once(503).await;
    assert_eq!(plant.figure(0, "flankfit_store_up").await, Some(0.0));
    run(&server, START);
    plant.ready_once(200).await;
    assert_eq!(plant.figure(0, "flankfit_store_up").await, Some(1.0));
    plant.servers.into_iter().for_each(kill::Server::kill);
}
