//! The idempotency key of an operation, and its end before its time.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{begun, later, once, result, slow_iteration, trimmed};
use crate::jobs::app::{self, TestApp, iteration, send};

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
    let fit = json!({"nodes": app::nodes(), "model": {"type": "polynomial", "degree": [2, 2]}});
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
    let first = begun(keyed(&trimmed(200))).await;
    // it has the key once its work has begun, a little after it is said to run
    once(&app, &first, |told| told["progress"].as_f64() > Some(0.0)).await;
    app.post_keyed(&path, "k", &iteration()).await.problem(409, "idempotency_key_in_use");
    app.delete(&first).await.expect(204);
    // at once, with another body
    let second = begun(keyed(&trimmed(180))).await;
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
    let operation = begun(later(&app, "/v1/fits", &trimmed(200))).await;
    let running = once(&app, &operation, |told| told["progress"].as_f64() > Some(0.02)).await;
    assert_eq!(running["state"], "running");
    let seen = once(&app, &operation, |told| told["remaining_seconds"].is_number()).await;
    assert!(
        seen["progress"].as_f64() >= running["progress"].as_f64() && seen["remaining_seconds"].as_f64() > Some(0.0)
    );
    // alone it would go on for some twenty seconds
    let left = Instant::now();
    app.delete(&operation).await.expect(204);
    while app.state().pool.busy() > 0 {
        assert!(left.elapsed() < Duration::from_secs(6), "the worker goes on");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(app.get(&operation).await.expect(200).json()["state"], "cancelled");
    result(&app, &operation).await.problem(410, "operation_cancelled");
    app.delete(&operation).await.expect(204);
    app.get(&operation).await.problem(404, "not_found");
    app.delete(&operation).await.problem(404, "not_found");
}
