//! Idempotency-Key.

use reqwest::{
    Method,
    multipart::{Form, Part},
};
use serde_json::{Value, json};
use tokio::task::JoinSet;

use super::app::{TestApp, iteration, send};

#[tokio::test]
async fn a_repeated_request_gets_the_first_answer_also_after_a_restart() {
    let mut app = TestApp::start().await;
    let created = app.post_keyed("/v1/jobs", "one", &json!({"name": "wheel"})).await.expect(201);
    let job = created.header("location").unwrap().to_owned();
    let add = format!("{job}/iterations");
    let added = app.post_keyed(&add, "one", &iteration()).await.expect(201);
    let refit = json!({"model": {"type": "polynomial", "degree": 1}, "reason": "coarser"});
    let fits = format!("{add}/1/fits");
    let fitted = app.post_keyed(&fits, "one", &refit).await.expect(201);
    // whatever is chosen and decided afterwards
    let chosen = json!({"fit_id": fitted.json()["id"], "reason": "smoother"});
    send(app.request(Method::PUT, &format!("{add}/1/chosen-fit")).json(&chosen)).await.expect(200);
    let decided = json!({"decision": "accepted"});
    send(app.request(Method::PATCH, &format!("{add}/1")).json(&decided)).await.expect(200);
    for _ in 0..2 {
        for (path, body, first) in [
            ("/v1/jobs", json!({"name": "wheel"}), &created),
            (&add, iteration(), &added),
            (&fits, refit.clone(), &fitted),
        ] {
            let again = app.post_keyed(path, "one", &body).await.expect(201);
            assert_eq!(again.text, first.text);
            assert_eq!(again.header("location"), first.header("location"));
            assert_eq!(again.header("etag"), first.header("etag"));
            assert_eq!(again.header("idempotency-replayed"), Some("true"));
        }
        app.restart().await;
    }
    let trace = app.get(&format!("{job}/trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
    assert_eq!(trace["iterations"][0]["fits"].as_array().unwrap().len(), 2);
    assert_eq!(app.get("/v1/jobs").await.json()["items"].as_array().unwrap().len(), 1);
    app.stop().await;
}

#[tokio::test]
async fn a_key_is_for_one_request_only_and_a_refused_one_does_not_use_it_up() {
    let mut app = TestApp::start().await;
    app.post_keyed("/v1/jobs", "k", &json!({"nome": "wheel"})).await.problem(422, "invalid_request");
    app.post_keyed("/v1/jobs", "k", &json!({"name": "wheel"})).await.expect(201);
    app.post_keyed("/v1/jobs", "k", &json!({"name": "pinion"})).await.problem(422, "idempotency_key_reused");
    app.post_keyed("/v1/jobs", "other", &json!({"name": "pinion"})).await.expect(201);
    app.post_keyed("/v1/jobs", &"x".repeat(300), &json!({"name": "w"})).await.problem(400, "malformed_request");
    let twice = app.request(Method::POST, "/v1/jobs").json(&json!({"name": "third"}));
    let twice = twice.header("idempotency-key", "a").header("idempotency-key", "b");
    send(twice).await.problem(400, "malformed_request");
    assert_eq!(app.get("/v1/jobs").await.json()["items"].as_array().unwrap().len(), 2);
    app.stop().await;
}

#[tokio::test]
async fn a_forms_boundary_does_not_count() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let post = async || {
        let form = Form::new()
            .part("spec", Part::text(r#"{"model":{"type":"polynomial","degree":1}}"#))
            .part("nodes", Part::text("x,y\n0,1\n1,2\n2,2.5\n3,4\n"));
        let boundary = form.boundary().to_owned();
        let request = app.request(Method::POST, &format!("{job}/iterations")).header("Idempotency-Key", "f");
        (boundary, send(request.multipart(form)).await.expect(201))
    };
    let (first, second) = (post().await, post().await);
    assert_ne!(first.0, second.0);
    assert_eq!(first.1.text, second.1.text);
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn at_the_same_time_one_request_stores_and_the_others_wait_or_see_its_answer() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut requests = JoinSet::new();
    for _ in 0..16 {
        let request = app.request(Method::POST, &format!("{job}/iterations")).header("Idempotency-Key", "same");
        requests.spawn(send(request.json(&iteration())));
    }
    let mut bodies = std::collections::HashSet::new();
    for answer in requests.join_all().await {
        match answer.status.as_u16() {
            201 => {
                bodies.insert(answer.text);
            }
            _ => {
                answer.problem(409, "idempotency_key_in_use");
                assert_eq!(answer.header("retry-after"), Some("1"));
            }
        }
    }
    assert_eq!(bodies.len(), 1);
    let trace: Value = app.get(&format!("{job}/trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 1);
    app.stop().await;
}
