//! When an operation is answered, with what, and what it leaves behind.

use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::{Value, json};

use super::{begun, kinds::example, later, once, result, same, slow_iteration, study, trimmed};
use crate::jobs::{
    app::{Answer, TestApp, alone, iteration, send},
    events::Listener,
};

/// An iteration and a refit are stored once, and told of to who listens to the job.
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
    let fit = alone(&made.json(), "/fits/0");
    let place = format!("{job}/iterations/1/fits/{}", fit["id"].as_str().unwrap());
    assert_eq!(app.get(&place).await.expect(200).json(), fit);
    assert_eq!(app.post(&format!("{place}/replay"), &json!({})).await.expect(200).json()["identical"], true);
    let refit = json!({"model": {"type": "polynomial", "degree": [3, 3]}, "estimator": {"type": "lp", "p": 1.5}});
    let operation = begun(later(&app, &format!("{job}/iterations/1/fits"), &refit)).await;
    let answer = result(&app, &operation).await.expect(201);
    assert!(answer.header("location").unwrap().starts_with(&format!("{job}/iterations/1/fits/")));
    assert_eq!(app.get(answer.header("location").unwrap()).await.expect(200).text, answer.text);
    let trace = app.get(&format!("{job}/trace")).await.expect(200).json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
    assert_eq!(trace["iterations"][0]["fits"].as_array().unwrap().len(), 2);
    assert_eq!(app.get(&crate::jobs::audit::verify_of(&job)).await.expect(200).json()["intact"], true);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_of_the_request_are_told_at_once() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let mut few = iteration();
    few["model"] = json!({"type": "polynomial", "degree": [40, 40]});
    let mut wrong = study(300);
    wrong["levels"] = json!([-1]);
    let mut skew = example("surface_sections");
    skew["families"][1]["normal"] = json!([1, 1, 0]);
    let cases = [
        (format!("{job}/iterations"), json!({"nodes": 1}), 422),
        (format!("{job}/iterations"), few, 422),
        ("/v1/jobs/0190b0de-0000-7000-8000-000000000000/iterations".to_owned(), slow_iteration(), 404),
        (format!("{job}/iterations/7/fits"), json!({"model": {"type": "linear"}}), 404),
        ("/v1/studies/randomization".to_owned(), wrong, 422),
        ("/v1/fits?no_such=1".to_owned(), iteration(), 422),
        ("/v1/simulations/closed-loop".to_owned(), json!({"corrections": 1000}), 422),
        ("/v1/surfaces/sections".to_owned(), skew, 422),
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
    let slow = asked("/v1/fits", "1", &trimmed(200)).await.expect(202);
    assert!((1..30).contains(&begun.elapsed().as_secs()), "{:?}", begun.elapsed());
    let operation = slow.header("location").unwrap().to_owned();
    once(&app, &operation, |told| told["state"] == "running").await;
    let begun = Instant::now();
    let running = send(app.request(Method::GET, &operation).header("Prefer", "wait=1")).await.expect(200);
    assert!(begun.elapsed() >= Duration::from_secs(1));
    assert_eq!((&running.json()["state"], running.header("preference-applied")), (&json!("running"), Some("wait=1")));
    let answer = app.get(&format!("{operation}/result")).await;
    answer.problem(409, "operation_running");
    assert_eq!(answer.header("retry-after"), Some("1"));
    app.delete(&operation).await.expect(204);
}
