//! Who does operations, whose they are, and what they may take.

use std::{
    sync::mpsc,
    time::{Duration, Instant},
};

use flankfit::{
    config::ServeSettings,
    http::{self, AppState},
    jobs::Role,
};
use jiff::{SignedDuration, Timestamp};
use reqwest::Method;
use serde_json::json;
use tokio::{sync::oneshot, time::sleep};

use super::{PATIENCE, begun, later, once, result, slow_iteration, study, trimmed};
use crate::{
    doors::keys::key_of,
    harness,
    jobs::{
        app::{TestApp, send},
        several::Replicas,
    },
};

/// A server that stops gives back what it does, and the next one on the database goes on with it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_restart_goes_on_with_what_was_begun() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = "/v1/studies/randomization";
    // no worker is free: the operation stays running however long the next requests take
    let open = occupied(app.state(), 2).await;
    let long = begun(later(&app, path, &study(1500))).await;
    let stored = begun(later(&app, &format!("{job}/iterations"), &slow_iteration())).await;
    once(&app, &long, |told| told["state"] == "running").await;
    drop(open);
    app.restart().await;
    assert_eq!(result(&app, &stored).await.expect(201).json()["number"], 1);
    let done = result(&app, &long).await.expect(200);
    assert_eq!(done.text, app.post(path, &study(1500)).await.expect(200).text);
    let told = app.get(&long).await.json();
    assert_eq!(told["attempts"], 1, "what was given back counts for nothing: {told}");
    let trace = app.get(&format!("{job}/trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
}

/// Servers without a runner keep what they were asked; another does it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn lost_servers_leave_their_operations_to_others() {
    let replicas = Replicas::on_sqlite(2).await;
    let begin = |key: &'static str| {
        let request = replicas.request(0, Method::POST, "/v1/studies/randomization").header("Prefer", "respond-async");
        begun(request.header("Idempotency-Key", key).json(&study(50)))
    };
    let state = &replicas.states[1];
    let lost = SignedDuration::from_secs(-1);
    let lose = async || {
        let now = state.jobs.now();
        state.jobs.tasks().claim(state.jobs.fresh_id(now), now, lost).await.unwrap().unwrap().attempts
    };
    let (one, again) = (begin("one").await, begin("again").await);
    // the first was begun once, by a server that is no more; the other three times
    assert_eq!(lose().await, 1);
    let tasks = state.jobs.tasks();
    let mut attempts = Vec::new();
    for _ in 0..6 {
        let now = state.jobs.now();
        let taken = tasks.claim(state.jobs.fresh_id(now), now, lost).await.unwrap().unwrap();
        if taken.key == "one" {
            tasks.give_back(taken.lease, "2200-01-01T00:00:00Z".parse().unwrap(), false).await.unwrap();
        } else {
            attempts.push(taken.attempts);
        }
        if attempts.len() == 3 {
            break;
        }
    }
    assert_eq!(attempts, [1, 2, 3]);
    let runner = tokio::spawn(http::run_operations(state.clone()));
    let asked = |path: String| send(replicas.request(0, Method::GET, &path).header("Prefer", "wait=30"));
    let interrupted = asked(format!("{again}/result")).await;
    interrupted.problem(500, "interrupted");
    let told = asked(again).await.expect(200).json();
    assert_eq!((&told["state"], &told["problem"]["code"]), (&json!("failed"), &json!("interrupted")));
    assert_eq!(replicas.get(1, &one).await.expect(200).json()["state"], "queued");
    let fresh = begin("fresh").await;
    assert_eq!(asked(format!("{fresh}/result")).await.expect(200).json()["repetitions"], 50);
    state.shutdown.begin();
    runner.await.unwrap();
}

/// Keeps workers of a server busy until what comes back is dropped.
pub async fn occupied(state: &AppState, workers: usize) -> Vec<mpsc::Sender<()>> {
    let mut open = Vec::new();
    for _ in 0..workers {
        let (own, gate) = mpsc::channel::<()>();
        let (begun, busy) = oneshot::channel();
        let state = state.clone();
        let work = move || {
            let _ = begun.send(());
            let _ = gate.recv();
        };
        tokio::spawn(async move { state.pool.run(work).await });
        busy.await.unwrap();
        open.push(own);
    }
    open
}

/// Whoever does an operation keeps it by renewing its lease of 10 s, however long it takes.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_operation_stays_with_its_server_longer_than_a_lease() {
    let replicas = Replicas::on_sqlite(2).await;
    let [first, second] = [0, 1].map(|replica: usize| replicas.states[replica].clone());
    let runner = |state: &AppState| tokio::spawn(http::run_operations(state.clone()));
    // the first one takes it, and has no worker to do it yet
    let open = occupied(&first, first.settings.worker_count()).await;
    let mut runners = vec![runner(&first)];
    let request = replicas.request(1, Method::POST, "/v1/studies/randomization").header("Prefer", "respond-async");
    let operation = begun(request.json(&study(50))).await;
    let told = async || replicas.get(1, &operation).await.expect(200).json();
    let asked = Instant::now();
    while told().await["state"] != "running" {
        assert!(asked.elapsed() < PATIENCE, "nobody begins");
        sleep(Duration::from_millis(20)).await;
    }
    // the second one looks every second for what is nobody's
    runners.push(runner(&second));
    let asked = Instant::now();
    while asked.elapsed() < Duration::from_secs(15) {
        let now = told().await;
        assert_eq!((&now["state"], &now["attempts"]), (&json!("running"), &json!(1)), "{now}");
        sleep(Duration::from_millis(200)).await;
    }
    drop(open);
    let result = replicas.request(1, Method::GET, &format!("{operation}/result")).header("Prefer", "wait=60");
    assert_eq!(send(result).await.expect(200).json()["repetitions"], 50);
    let ended = told().await;
    assert_eq!((&ended["state"], &ended["attempts"]), (&json!("succeeded"), &json!(1)), "{ended}");
    let at = |name: &str| ended[name].as_str().unwrap().parse::<Timestamp>().unwrap();
    assert!(at("ended_at").duration_since(at("begun_at")) > SignedDuration::from_secs(10), "{ended}");
    for state in [first, second] {
        state.shutdown.begin();
    }
    for runner in runners {
        runner.await.unwrap();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn operations_have_their_time_and_their_room() {
    let change = |settings: &mut ServeSettings| {
        settings.operation_timeout = 1;
        settings.operation_bytes = 6_000;
    };
    let app = TestApp::around(harness::TestApp::start_with(change).await);
    let path = "/v1/studies/randomization";
    let slow = begun(later(&app, path, &study(8000))).await;
    let late = result(&app, &slow).await;
    late.problem(500, "operation_timeout");
    assert_eq!(late.header("retry-after"), None, "it is final");
    assert!(late.text.contains("within 1 s"), "{}", late.text);
    assert_eq!(app.get(&slow).await.json()["state"], "failed");
    // each is kept until its hour is over or it is deleted
    let mut kept = Vec::new();
    let refused = loop {
        let answer = send(later(&app, path, &study(40))).await;
        if answer.status == 429 {
            break answer;
        }
        kept.push(answer.expect(202).header("location").unwrap().to_owned());
        assert!(kept.len() < 30);
    };
    refused.problem(429, "too_many_requests");
    assert_eq!(refused.header("retry-after"), Some("10"));
    for operation in kept {
        result(&app, &operation).await;
        app.delete(&operation).await.expect(204);
    }
    begun(later(&app, path, &study(40))).await;
}

/// Who could make the request may ask after it, in its tenant.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn operations_are_of_their_tenant_and_of_who_could_make_them() {
    let server = harness::TestApp::start_with(|settings| {
        settings.auth = flankfit::config::Authentication::Required;
    })
    .await;
    let engineer = key_of(&server, "default", Role::Engineer).await;
    let reader = key_of(&server, "default", Role::Reader).await;
    let other = key_of(&server, "other", Role::Engineer).await;
    let app = TestApp::around(server);
    let ask = |method: Method, path: &str, key: &str| send(app.request(method, path).bearer_auth(key));
    let job = send(app.request(Method::POST, "/v1/jobs").bearer_auth(&engineer).json(&json!({"name": "w"}))).await;
    let job = job.expect(201).header("location").unwrap().to_owned();
    let path = format!("{job}/iterations");
    let stored = begun(later(&app, &path, &slow_iteration()).bearer_auth(&engineer)).await;
    let computed = begun(later(&app, "/v1/studies/randomization", &study(50)).bearer_auth(&reader)).await;
    send(later(&app, &path, &slow_iteration()).bearer_auth(&reader)).await.problem(403, "forbidden");
    for path in [stored.clone(), format!("{stored}/result")] {
        let refused = ask(Method::GET, &path, &reader).await;
        refused.problem(403, "forbidden");
        assert!(refused.text.contains("`measure`"), "{}", refused.text);
        ask(Method::GET, &path, &other).await.problem(404, "not_found");
    }
    ask(Method::DELETE, &stored, &reader).await.problem(403, "forbidden");
    ask(Method::DELETE, &stored, &other).await.problem(404, "not_found");
    ask(Method::GET, &computed, &engineer).await.expect(200);
    let seen = async |key: &str| ask(Method::GET, "/v1/operations", key).await.expect(200).json()["items"].clone();
    let count = async |key: &str| seen(key).await.as_array().unwrap().len();
    assert_eq!((count(&engineer).await, count(&reader).await, count(&other).await), (2, 1, 0));
    let waited = app.request(Method::GET, &format!("{stored}/result")).header("Prefer", "wait=60");
    send(waited.bearer_auth(&engineer)).await.expect(201);
    // whoever asked stands in the audit, with the request that was asked
    let audit = ask(Method::GET, &format!("{job}/audit"), &key_auditor(&app).await).await.expect(200).json();
    let entries = audit["items"].as_array().unwrap();
    let last = entries.last().unwrap();
    assert_eq!(last["actor"], entries[0]["actor"]);
    assert!(last["request_id"].is_string() && last["peer"].is_string(), "{last}");
}

/// A key that has ended, or a suspended tenant, ends the operations whose requests it let in: what
/// runs and what waits.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn operations_end_with_what_let_their_requests_in() {
    let server = harness::TestApp::start_with(|settings| {
        (settings.auth, settings.workers) = (flankfit::config::Authentication::Required, 2);
    })
    .await;
    let admin = key_of(&server, "default", Role::Admin).await;
    let root = key_of(&server, "default", Role::Root).await;
    let app = TestApp::around(server);
    let ask = async |method: Method, path: &str, key: &str, body: &serde_json::Value| {
        send(app.request(method, path).bearer_auth(key).json(body)).await
    };
    ask(Method::POST, "/v1/tenants", &root, &json!({"name": "other"})).await.expect(201);
    for (tenant, suspends) in [("default", false), ("other", true)] {
        let [theirs, reader] = [Role::Engineer, Role::Reader].map(|role| key_of(app.server(), tenant, role));
        let (theirs, reader) = (theirs.await, reader.await);
        let job = ask(Method::POST, "/v1/jobs", &theirs, &json!({"name": "w"})).await.expect(201);
        let job = job.header("location").unwrap().to_owned();
        // one worker does operations: the first runs, the second waits
        let mut operations = Vec::new();
        for body in [trimmed(200), slow_iteration()] {
            operations.push(begun(later(&app, &format!("{job}/iterations"), &body).bearer_auth(&theirs)).await);
        }
        let running = async || ask(Method::GET, &operations[0], &theirs, &json!({})).await.json()["state"] == "running";
        while !running().await {
            sleep(Duration::from_millis(20)).await;
        }
        let ended = Instant::now();
        if suspends {
            let answer = ask(Method::PATCH, "/v1/tenants/other", &root, &json!({"suspended": true})).await.expect(200);
            assert_eq!(answer.json()["suspended"], true);
        } else {
            ask(Method::DELETE, &format!("/v1/keys/{}", &theirs[4..20]), &admin, &json!({})).await.expect(204);
        }
        let tasks = async || {
            let caller = flankfit::jobs::Caller {
                tenant: flankfit::jobs::Tenant::named(tenant).unwrap(),
                actor: "test".into(),
                origin: Default::default(),
            };
            let jobs = app.server().state.jobs.of(&caller);
            let mut states = Vec::new();
            for operation in &operations {
                let id = operation.rsplit('/').next().unwrap().parse().unwrap();
                let task = jobs.task(id).await.unwrap();
                states.push((task.state, task.status));
            }
            states
        };
        while tasks().await.iter().any(|(state, _)| !state.is_end()) {
            assert!(ended.elapsed() < PATIENCE, "{tenant}");
            sleep(Duration::from_millis(50)).await;
        }
        assert_eq!(tasks().await, [(flankfit::jobs::TaskState::Failed, Some(403)); 2], "{tenant}");
        if suspends {
            ask(Method::PATCH, "/v1/tenants/other", &root, &json!({"suspended": false})).await.expect(200);
        }
        let trace = ask(Method::GET, &format!("{job}/trace"), &reader, &json!({})).await.expect(200).json();
        assert_eq!(trace["iterations"], json!([]), "nothing is stored");
        let engineer = key_of(app.server(), tenant, Role::Engineer).await;
        let told = ask(Method::GET, &operations[1], &engineer, &json!({})).await.expect(200).json();
        assert_eq!(told["problem"]["code"], "forbidden", "{told}");
    }
}

async fn key_auditor(app: &TestApp) -> String {
    key_of(app.server(), "default", Role::Auditor).await
}
