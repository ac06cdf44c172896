//! ETag, If-Match, and what a patch changes.

use reqwest::Method;
use serde_json::json;

use super::app::{TestApp, send};

#[tokio::test]
async fn a_job_is_changed_only_from_its_latest_version() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let patched = app.patch_if(&job, "\"1\"", &json!({"machine": "K300", "tags": {"a": "b"}})).await.expect(200);
    assert_eq!(patched.header("etag"), Some("\"2-new\""));
    assert_eq!((&patched.json()["machine"], &patched.json()["tags"]), (&json!("K300"), &json!({"a": "b"})));
    app.patch_if(&job, "\"1\"", &json!({"machine": "K400"})).await.problem(412, "precondition_failed");
    app.patch_if(&job, "W/\"2\"", &json!({"machine": "K400"})).await.problem(412, "precondition_failed");
    app.patch_if(&job, "*", &json!({"clear": ["machine"]})).await.expect(200);
    let now = app.get(&job).await.expect(200);
    assert_eq!(now.header("etag"), Some("\"3-new\""));
    assert!(now.json().get("machine").is_none(), "what does not exist is left out: {}", now.text);
    // A patch that changes nothing is no new version.
    assert_eq!(app.patch(&job, &json!({"name": "wheel"})).await.expect(200).header("etag"), Some("\"3-new\""));

    let late = send(app.request(Method::DELETE, &job).header("If-Match", "\"2\"")).await;
    late.problem(412, "precondition_failed");
    send(app.request(Method::DELETE, &job).header("If-Match", "\"3-new\"")).await.expect(204);
    app.get(&job).await.problem(404, "not_found");
    app.stop().await;
}

#[tokio::test]
async fn an_iteration_is_decided_only_from_its_latest_version() {
    let mut app = TestApp::start().await;
    let place = app.iteration(&app.job().await).await;
    let refit =
        app.post(&format!("{place}/fits"), &json!({"model": {"type": "polynomial", "degree": 1}})).await.expect(201);
    assert_eq!(refit.header("etag"), Some("\"2\""));
    app.patch_if(&place, "\"1\"", &json!({"decision": "accepted"})).await.problem(412, "precondition_failed");
    let decided = app.patch_if(&place, "\"2\"", &json!({"decision": "accepted"})).await.expect(200);
    assert_eq!(decided.header("etag"), Some("\"3\""));
    let chosen = send(
        app.request(Method::PUT, &format!("{place}/chosen-fit"))
            .header("If-Match", "\"2\"")
            .json(&json!({"fit_id": refit.json()["id"]})),
    )
    .await;
    chosen.problem(412, "precondition_failed");
    // Saying the same again changes nothing, so a repeated request does no harm.
    let repeated = app.patch(&place, &json!({"decision": "accepted"})).await.expect(200);
    assert_eq!(repeated.text, decided.text);
    app.stop().await;
}
