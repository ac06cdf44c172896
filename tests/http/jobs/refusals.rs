//! Refusals with their pointers, and nothing stored after any of them.

use serde_json::{Value, json};

use super::app::{TestApp, iteration};

const NOBODY: &str = "0190b0de-0000-7000-8000-000000000000";

#[tokio::test]
async fn bad_jobs_are_refused_with_pointers() {
    let mut app = TestApp::start().await;
    for (body, pointer) in [
        (json!({}), "/name"),
        (json!({"name": ""}), "/name"),
        (json!({"name": 5}), "/name"),
        (json!({"name": "x".repeat(201)}), "/name"),
        (json!({"name": "w", "colour": "blue"}), "/colour"),
        (json!({"name": "w", "tags": {"a": 1}}), "/tags/a"),
        (json!({"name": "w", "gear": {"teeth": 0, "normal_module_mm": 1}}), "/gear/teeth"),
        (json!({"name": "w", "gear": {"teeth": 20, "normal_module_mm": 1, "module": 1}}), "/gear/module"),
        (json!({"name": "w", "gear": {"teeth": 20}}), "/gear/normal_module_mm"),
        (json!([]), ""),
    ] {
        assert_eq!(app.post("/v1/jobs", &body).await.problem(422, "invalid_request"), [pointer], "{body}");
    }
    assert_eq!(app.get("/v1/jobs").await.json(), json!({"items": []}));

    let job = app.job().await;
    for (body, pointer) in [(json!({"name": ""}), "/name"), (json!({"id": NOBODY}), "/id")] {
        assert_eq!(app.patch(&job, &body).await.problem(422, "invalid_request"), [pointer]);
    }
    let long = format!("tag={}", "x".repeat(402));
    for (query, pointer) in [
        ("limit=0", "/limit"),
        ("limit=201", "/limit"),
        ("cursor=here", "/cursor"),
        ("cursor=%30%C3%A9", "/cursor"),
        ("cursor=99019a0000000070008000000000000000", "/cursor"),
        ("status=done", "/status"),
        ("sort=status", "/sort"),
        ("q=", "/q"),
        ("q=%00", "/q"),
        ("machine=%20", "/machine"),
        ("part_number=", "/part_number"),
        (long.as_str(), "/tag"),
        ("from=yesterday", "/from"),
        ("from=2026-11-21T08:30:00Z&to=2026-11-21T10:30:00%2B02:00", "/to"),
    ] {
        assert_eq!(app.get(&format!("/v1/jobs?{query}")).await.problem(422, "invalid_request"), [pointer], "{query}");
    }
    let all = app.get("/v1/jobs?status=done&sort=age&from=now&limit=many").await;
    assert_eq!(all.problem(422, "invalid_request"), ["/status", "/from", "/sort", "/limit"]);
    app.get("/v1/jobs?limit=many").await.problem(422, "invalid_request");
    app.stop().await;
}

#[tokio::test]
async fn bad_iterations_are_refused_and_nothing_is_stored() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let with = |change: fn(&mut Value)| {
        let mut body = iteration();
        change(&mut body);
        body
    };
    let cases: [(Value, &str); 7] = [
        (with(|body| body["measured_at"] = json!("yesterday")), "/measured_at"),
        (with(|body| body["operator"] = json!(7)), "/operator"),
        (with(|body| body["note"] = json!("")), "/note"),
        (with(|body| body["decision"] = json!("accepted")), "/decision"),
        (with(|body| body["nodes"]["u"][1] = json!(0)), "/nodes/u/1"),
        (with(|body| body["nodes"] = json!({"type": "grid", "u": [], "v": [], "z": []})), "/nodes/u"),
        (with(|body| body["model"]["degree"] = json!([20, 20])), "/model/degree"),
    ];
    for (body, pointer) in cases {
        let answer = app.post(&format!("{job}/iterations"), &body).await;
        let pointers = answer.problem(422, "invalid_request");
        assert!(pointers.iter().any(|found| found == pointer), "{pointer}: {}", answer.text);
    }
    let trace = app.get(&format!("{job}/trace")).await.expect(200).json();
    assert_eq!(trace["iterations"], json!([]));
    assert_eq!(app.iteration(&job).await, format!("{job}/iterations/1"), "no number was used up");

    let place = format!("{job}/iterations/1");
    app.post(&format!("{place}/fits"), &iteration()).await.problem(422, "invalid_request");
    let pointers = app.put(&format!("{place}/chosen-fit"), &json!({"fit_id": NOBODY})).await;
    assert_eq!(pointers.problem(422, "invalid_request"), ["/fit_id"]);
    let pointers = app.patch(&place, &json!({"decision": "perhaps"})).await;
    assert_eq!(pointers.problem(422, "invalid_request"), ["/decision"]);
    app.delete(&job).await.problem(409, "conflict");
    app.stop().await;
}

#[tokio::test]
async fn missing_resources_are_404() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let place = app.iteration(&job).await;
    let nobody = format!("/v1/jobs/{NOBODY}");
    let decide = json!({"decision": "accepted"});
    let refit = json!({"model": {"type": "polynomial", "degree": 1}});
    for path in [
        &nobody,
        &format!("{nobody}/trace"),
        &format!("{job}/iterations/2"),
        "/v1/jobs/not-an-id",
        &format!("{job}/iterations/0"),
    ] {
        app.get(path).await.problem(404, "not_found");
    }
    for path in [
        format!("{nobody}/iterations/1/nodes"),
        format!("{job}/iterations/9/nodes"),
        format!("{job}/iterations/x/nodes"),
    ] {
        app.get(&path).await.problem(404, "not_found");
    }
    app.patch(&nobody, &json!({"name": "w"})).await.problem(404, "not_found");
    app.delete(&nobody).await.problem(404, "not_found");
    app.post(&format!("{nobody}/iterations"), &iteration()).await.problem(404, "not_found");
    app.post(&format!("{job}/iterations/9/fits"), &refit).await.problem(404, "not_found");
    app.patch(&format!("{job}/iterations/9"), &decide).await.problem(404, "not_found");
    app.put(&format!("{nobody}/iterations/1/chosen-fit"), &json!({"fit_id": NOBODY})).await.problem(404, "not_found");
    app.post(&format!("{place}/fits/{NOBODY}/replay"), &json!({})).await.problem(404, "not_found");
    app.stop().await;
}
