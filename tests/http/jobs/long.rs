//! Requests that are answered later: `Prefer: respond-async`.

use std::time::{Duration, Instant};

use flankfit::{config::ServeSettings, http, jobs::Role};
use jiff::SignedDuration;
use reqwest::{Method, RequestBuilder};
use serde_json::{Value, json};

use super::{
    app::{Answer, TestApp, iteration, send},
    events::Listener,
    several::Replicas,
};
use crate::{doors::keys::key_of, harness};

const STUDY: &str = include_str!("../../../examples/requests/study_flank.json");
/// For so long an operation is waited for.
const PATIENCE: Duration = Duration::from_secs(60);

/// A study of so many repetitions: thousands take seconds.
pub fn study(repetitions: u32) -> Value {
    let mut request: Value = serde_json::from_str(STUDY).unwrap();
    request["repetitions"] = json!(repetitions);
    request
}

/// An iteration that takes a while.
pub fn slow_iteration() -> Value {
    let mut request = iteration();
    request["estimator"] = json!({"type": "lp", "p": 1.5});
    request
}

/// An iteration that takes longer than some servers of a test live.
pub fn robust_iteration() -> Value {
    trimmed(40)
}

/// A fit of trimmed squares: of 40 × 40 nodes it takes seconds, of 150 × 150 many more.
pub fn trimmed(side: usize) -> Value {
    let axis = |count: usize| (0..count).map(|i| i as f64).collect::<Vec<_>>();
    let height = |i: usize, j: usize| (3.0 * i as f64 + 7.0 * j as f64).sin();
    let heights: Vec<Vec<f64>> = (0..side).map(|i| (0..side).map(|j| height(i, j)).collect()).collect();
    json!({
        "nodes": {"type": "grid", "u": axis(side), "v": axis(side), "z": heights},
        "model": {"type": "polynomial", "degree": [5, 5], "basis": "chebyshev"},
        "estimator": {"type": "least_trimmed_squares", "coverage": 0.75}
    })
}

fn later(app: &TestApp, path: &str, body: &Value) -> RequestBuilder {
    app.request(Method::POST, path).header("Prefer", "respond-async").json(body)
}

/// Begins an operation: its path.
pub async fn begun(request: RequestBuilder) -> String {
    let answer = send(request).await.expect(202);
    assert_eq!((answer.header("preference-applied"), answer.header("retry-after")), (Some("respond-async"), Some("1")));
    let path = answer.header("location").unwrap().to_owned();
    assert_eq!(path, format!("/v1/operations/{}", answer.json()["id"].as_str().unwrap()));
    path
}

/// The operation once it stands so.
async fn once(app: &TestApp, path: &str, seen: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let operation = app.get(path).await.expect(200).json();
        if seen(&operation) {
            return operation;
        }
        assert!(begun.elapsed() < PATIENCE, "{operation}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

async fn result(app: &TestApp, path: &str) -> Answer {
    send(app.request(Method::GET, &format!("{path}/result")).header("Prefer", "wait=60")).await
}

fn example(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// What differs between two answers: whose they are, and when.
const OF_ONE_ANSWER: [&str; 3] = ["x-request-id", "date", "preference-applied"];

#[track_caller]
fn same(later: &Answer, plain: &Answer) {
    assert_eq!((later.status, &later.text), (plain.status, &plain.text));
    let headers = |answer: &Answer| {
        let kept = answer.headers.iter().filter(|(name, _)| !OF_ONE_ANSWER.contains(&name.as_str()));
        let mut kept: Vec<_> = kept.map(|(name, value)| (name.to_string(), value.clone())).collect();
        kept.sort();
        kept
    };
    assert_eq!(headers(later), headers(plain));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_answer_is_the_one_that_the_plain_request_has() {
    let app = TestApp::start().await;
    let requests = [
        ("/v1/fits", example(include_str!("../../../examples/requests/fit_least_trimmed.json"))),
        ("/v1/studies/randomization", study(300)),
        ("/v1/surfaces/export", example(include_str!("../../../examples/requests/surface_export.json"))),
        ("/v1/simulations/closed-loop", example(include_str!("../../../examples/requests/closed_loop.json"))),
    ];
    for (path, mut body) in requests {
        if path.ends_with("closed-loop") {
            body["store"] = json!(false);
        }
        let plain = app.post(path, &body).await.expect(200);
        let operation = begun(later(&app, path, &body)).await;
        same(&result(&app, &operation).await, &plain);
        let told = app.get(&operation).await.expect(200).json();
        assert_eq!(
            (&told["state"], &told["progress"], &told["status"]),
            (&json!("succeeded"), &json!(1.0), &json!(200))
        );
        assert_eq!((&told["attempts"], told["ended_at"].is_string()), (&json!(1), true), "{told}");
        assert_eq!(told["request"], format!("POST {path}"));
        // its answer stays the same, however often it is asked for
        same(&result(&app, &operation).await, &plain);
    }
    let list = app.get("/v1/operations?limit=3").await.expect(200).json();
    assert_eq!((list["items"].as_array().unwrap().len(), list["next_cursor"].is_string()), (3, true));
    let rest = app.get(&format!("/v1/operations?cursor={}", list["next_cursor"].as_str().unwrap())).await.json();
    assert_eq!((rest["items"].as_array().unwrap().len(), rest.get("next_cursor")), (1, None));
    assert_eq!(rest["items"][0]["request"], "POST /v1/fits");
    drop(app);
}

/// An iteration, a refit and a surface are stored once, and told of to who listens to the job.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_stored_is_there_when_the_operation_has_ended() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let mut heard = Listener::of(app.request(Method::GET, &format!("{job}/events")), None).await.unwrap();
    let operation = begun(later(&app, &format!("{job}/iterations"), &slow_iteration())).await;
    let made = result(&app, &operation).await.expect(201);
    assert_eq!(made.header("location"), Some(format!("{job}/iterations/1").as_str()));
    assert_eq!((made.header("etag"), made.json()["number"].as_u64()), (Some("\"1\""), Some(1)));
    let mut events = Vec::new();
    while events.len() < 3 {
        events.push(heard.next().await.unwrap());
    }
    let id = operation.rsplit('/').next().unwrap();
    let told: Vec<_> = events.iter().map(|(_, name, data)| (name.as_str(), data["operation_state"].as_str())).collect();
    assert_eq!(told.iter().filter(|one| **one == ("operation", Some("queued"))).count(), 1, "{events:?}");
    assert_eq!(told.iter().filter(|one| **one == ("operation", Some("succeeded"))).count(), 1, "{events:?}");
    assert!(events.iter().filter(|event| event.1 == "operation").all(|event| event.2["operation_id"] == id));
    // the stored fit is the one that was answered, and can be computed again
    let fit = &made.json()["fits"][0];
    let place = format!("{job}/iterations/1/fits/{}", fit["id"].as_str().unwrap());
    assert_eq!(app.get(&place).await.expect(200).json(), *fit);
    assert_eq!(app.post(&format!("{place}/replay"), &json!({})).await.expect(200).json()["identical"], true);
    let refit = json!({"model": {"type": "polynomial", "degree": [3, 3]}, "estimator": {"type": "lp", "p": 1.5}});
    let operation = begun(later(&app, &format!("{job}/iterations/1/fits"), &refit)).await;
    let answer = result(&app, &operation).await.expect(201);
    assert!(answer.header("location").unwrap().starts_with(&format!("{job}/iterations/1/fits/")));
    assert_eq!(app.get(answer.header("location").unwrap()).await.expect(200).text, answer.text);
    let trace = app.get(&format!("{job}/trace")).await.expect(200).json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
    assert_eq!(trace["iterations"][0]["fits"].as_array().unwrap().len(), 2);
    assert_eq!(app.get(&format!("{job}/audit/verify")).await.expect(200).json()["intact"], true);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_of_the_request_are_told_at_once() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let mut few = iteration();
    few["model"] = json!({"type": "polynomial", "degree": [40, 40]});
    let mut wrong = study(300);
    wrong["levels"] = json!([-1]);
    let cases = [
        (format!("{job}/iterations"), json!({"nodes": 1}), 422),
        (format!("{job}/iterations"), few, 422),
        ("/v1/jobs/0190b0de-0000-7000-8000-000000000000/iterations".to_owned(), slow_iteration(), 404),
        (format!("{job}/iterations/7/fits"), json!({"model": {"type": "linear"}}), 404),
        ("/v1/studies/randomization".to_owned(), wrong, 422),
        ("/v1/fits?no_such=1".to_owned(), iteration(), 422),
        ("/v1/simulations/closed-loop".to_owned(), json!({"corrections": 1000}), 422),
    ];
    for (path, body, status) in cases {
        let plain = app.post(&path, &body).await.expect(status);
        let answer = send(later(&app, &path, &body)).await.expect(status);
        let without_id = |answer: &Answer| {
            let mut problem = answer.json();
            problem.as_object_mut().unwrap().remove("request_id");
            problem
        };
        assert_eq!(without_id(&answer), without_id(&plain), "{path}");
    }
    let foreign = app.request(Method::POST, "/v1/fits").header("Prefer", "respond-async").body("x");
    send(foreign.header("content-type", "text/plain")).await.expect(415);
    let torn = app.request(Method::POST, "/v1/fits").header("Prefer", "respond-async").body("{");
    send(torn.header("content-type", "application/json")).await.expect(400);
    // what takes no computing is answered at once, and what knows no preference goes its way
    send(later(&app, "/v1/jobs", &json!({"name": "w"}))).await.expect(201);
    let none = app.get("/v1/operations").await.expect(200).json();
    assert_eq!(none["items"], json!([]), "nothing was begun");
    app.get("/v1/operations/0190b0de-0000-7000-8000-000000000000").await.problem(404, "not_found");
    app.get("/v1/operations/0190b0de-0000-7000-8000-000000000000/result").await.problem(404, "not_found");
}

/// What is found by computing is the answer of an operation that failed.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_computing_refuses_is_the_result() {
    let app = TestApp::start().await;
    let dependent = json!({
        "nodes": {"type": "matrix", "x": [[1, 1], [2, 2], [3, 3], [4, 4]], "y": [1, 2, 3, 4]},
        "model": {"type": "linear"}, "estimator": {"type": "lp", "p": 1.5}
    });
    let plain = app.post("/v1/fits", &dependent).await.expect(422);
    let operation = begun(later(&app, "/v1/fits", &dependent)).await;
    let failed = result(&app, &operation).await.expect(422);
    assert_eq!(failed.header("content-type"), Some("application/problem+json"));
    let (told, expected) = (failed.json(), plain.json());
    assert_eq!(
        (&told["code"], &told["detail"], &told["errors"]),
        (&expected["code"], &expected["detail"], &expected["errors"])
    );
    assert_eq!(told["request_id"], failed.header("x-request-id").unwrap());
    let operation = app.get(&operation).await.expect(200).json();
    assert_eq!((&operation["state"], &operation["status"]), (&json!("failed"), &json!(422)));
    assert_eq!(operation["problem"]["detail"], expected["detail"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_would_wait_has_the_answer_within_that_time_or_is_told_where() {
    let app = TestApp::start().await;
    let asked = |path: &str, wait: &str, body: &Value| {
        let prefer = format!("respond-async, wait={wait}");
        send(app.request(Method::POST, path).header("Prefer", prefer).json(body))
    };
    let quick = asked("/v1/studies/randomization", "60", &study(50)).await.expect(200);
    assert_eq!(quick.header("preference-applied"), Some("wait=60"));
    same(&quick, &app.post("/v1/studies/randomization", &study(50)).await.expect(200));
    let begun = Instant::now();
    let slow = asked("/v1/fits", "1", &trimmed(150)).await.expect(202);
    assert!((1..8).contains(&begun.elapsed().as_secs()), "{:?}", begun.elapsed());
    let operation = slow.header("location").unwrap().to_owned();
    let begun = Instant::now();
    let running = send(app.request(Method::GET, &operation).header("Prefer", "wait=1")).await.expect(200);
    assert!(begun.elapsed() >= Duration::from_secs(1));
    assert_eq!((&running.json()["state"], running.header("preference-applied")), (&json!("running"), Some("wait=1")));
    let answer = app.get(&format!("{operation}/result")).await;
    answer.problem(409, "operation_running");
    assert_eq!(answer.header("retry-after"), Some("1"));
    app.delete(&operation).await.expect(204);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_key_is_one_operation() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/iterations");
    let keyed = |key: &str, body: &Value| later(&app, &path, body).header("Idempotency-Key", key);
    let first = begun(keyed("k", &slow_iteration())).await;
    let again = send(keyed("k", &slow_iteration())).await.expect(202);
    assert_eq!((again.header("location"), again.header("idempotency-replayed")), (Some(first.as_str()), Some("true")));
    send(keyed("k", &iteration())).await.problem(422, "idempotency_key_reused");
    let made = result(&app, &first).await.expect(201);
    // the plain request with the key has the same answer, also when the operation is forgotten
    let plain = app.post_keyed(&path, "k", &slow_iteration()).await.expect(201);
    assert_eq!((plain.header("idempotency-replayed"), &plain.text), (Some("true"), &made.text));
    app.delete(&first).await.expect(204);
    app.get(&first).await.expect(404);
    let kept = send(keyed("k", &slow_iteration())).await.expect(201);
    assert_eq!((kept.header("idempotency-replayed"), &kept.text), (Some("true"), &made.text));
    // many at once begin one, and one is stored
    let asked = (0..12).map(|_| send(keyed("many", &slow_iteration())));
    let places: Vec<String> = futures_util::future::join_all(asked)
        .await
        .into_iter()
        .filter(|answer| answer.status != 409)
        .map(|answer| answer.expect(202).header("location").unwrap().to_owned())
        .collect();
    assert!(!places.is_empty() && places.iter().all(|place| *place == places[0]), "{places:?}");
    assert_eq!(result(&app, &places[0]).await.expect(201).json()["number"], 2);
    let trace = app.get(&format!("{job}/trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 2);
    // what stores nothing has keys, too
    let fit = json!({"nodes": super::app::nodes(), "model": {"type": "polynomial", "degree": [2, 2]}});
    let places = [(); 2].map(|()| later(&app, "/v1/fits", &fit).header("Idempotency-Key", "k"));
    let [one, two] = places.map(|request| async { send(request).await });
    let (one, two) = (one.await, two.await);
    if one.status == 202 {
        assert_eq!(one.expect(202).header("location"), two.expect(202).header("location"));
    }
}

/// A cancelled operation has its key no longer, be it that its work has not come to its end yet:
/// neither here nor for the plain request.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cancelled_operation_frees_its_key() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/iterations");
    let keyed = |body: &Value| later(&app, &path, body).header("Idempotency-Key", "k");
    let first = begun(keyed(&trimmed(150))).await;
    once(&app, &first, |told| told["state"] == "running").await;
    app.post_keyed(&path, "k", &iteration()).await.problem(409, "idempotency_key_in_use");
    app.delete(&first).await.expect(204);
    // at once, with another body
    let second = begun(keyed(&trimmed(120))).await;
    assert_ne!(first, second);
    once(&app, &second, |told| told["state"] == "running").await;
    app.delete(&second).await.expect(204);
    let plain = app.post_keyed(&path, "k", &iteration()).await.expect(201);
    assert_eq!(plain.header("idempotency-replayed"), None);
    let again = app.post_keyed(&path, "k", &iteration()).await.expect(201);
    assert_eq!((again.header("idempotency-replayed"), &again.text), (Some("true"), &plain.text));
    // what was cancelled stores nothing, also later
    for operation in [first, second] {
        result(&app, &operation).await.problem(410, "operation_cancelled");
    }
    let trace = app.get(&format!("{job}/trace")).await.expect(200).json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cancelled_operation_ends_at_once_and_stores_nothing() {
    let app = TestApp::start().await;
    let operation = begun(later(&app, "/v1/studies/randomization", &study(8000))).await;
    let running = once(&app, &operation, |told| told["progress"].as_f64() > Some(0.02)).await;
    assert_eq!(running["state"], "running");
    let seen = once(&app, &operation, |told| told["remaining_seconds"].is_number()).await;
    assert!(
        seen["progress"].as_f64() >= running["progress"].as_f64() && seen["remaining_seconds"].as_f64() > Some(0.0)
    );
    let left = Instant::now();
    app.delete(&operation).await.expect(204);
    while app.state().pool.busy() > 0 {
        assert!(left.elapsed() < Duration::from_secs(4), "the worker goes on");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(app.get(&operation).await.expect(200).json()["state"], "cancelled");
    result(&app, &operation).await.problem(410, "operation_cancelled");
    app.delete(&operation).await.expect(204);
    app.get(&operation).await.problem(404, "not_found");
    app.delete(&operation).await.problem(404, "not_found");
}

/// A server that stops gives back what it does, and the next one on the database goes on with it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_restart_goes_on_with_what_was_begun() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = "/v1/studies/randomization";
    let long = begun(later(&app, path, &study(1500))).await;
    let stored = begun(later(&app, &format!("{job}/iterations"), &slow_iteration())).await;
    once(&app, &long, |told| told["state"] == "running").await;
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
    late.problem(503, "request_timeout");
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

async fn key_auditor(app: &TestApp) -> String {
    key_of(app.server(), "default", Role::Auditor).await
}
