//! The streams of a job, and the nodes that were posted to one.

use reqwest::Method;
use serde_json::{Value, json};

use super::{
    app::{TestApp, send},
    streams::{block, nodes, spec},
};

#[tokio::test]
async fn streams_of_a_job_are_listed_with_their_state() {
    let mut app = TestApp::start().await;
    let (job, other) = (app.job().await, app.job().await);
    let mut made = Vec::new();
    for _ in 0..3 {
        made.push(app.stream(&job, &spec()).await);
    }
    app.stream(&other, &spec()).await;
    app.post(&format!("{}/nodes", made[1]), &block(1, 0..20)).await.expect(200);
    send(app.request(Method::POST, &format!("{}/finish", made[1]))).await.expect(201);
    let mut found: Vec<Value> = Vec::new();
    let mut path = format!("{job}/streams?limit=2");
    loop {
        let page = app.get(&path).await.expect(200).json();
        found.extend(page["items"].as_array().unwrap().clone());
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        path = format!("{job}/streams?limit=2&cursor={cursor}");
    }
    let ids: Vec<String> = found.iter().map(|item| format!("/v1/streams/{}", item["id"].as_str().unwrap())).collect();
    assert_eq!(ids, made);
    for (item, stream) in found.iter().zip(&made) {
        let whole = app.get(stream).await.expect(200).json();
        for (name, value) in item.as_object().unwrap() {
            assert_eq!(value, &whole[name], "{name}");
        }
        assert!(item.get("spec").is_none() && item.get("result").is_none());
    }
    assert_eq!(
        (&found[1]["state"], &found[1]["iteration_number"], &found[0]["state"]),
        (&json!("finished"), &json!(1), &json!("open"))
    );
    app.get("/v1/jobs/00000000-0000-7000-8000-000000000000/streams").await.problem(404, "not_found");
    let jobs = app.get("/v1/jobs?limit=1").await.json()["next_cursor"].as_str().unwrap().to_owned();
    let strange = app.get(&format!("{job}/streams?cursor={jobs}")).await;
    assert_eq!(strange.problem(422, "invalid_request"), ["/cursor"]);
    app.stop().await;
}

#[tokio::test]
async fn posted_nodes_come_back_block_by_block() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let stream = app.stream(&job, &spec()).await;
    let place = format!("{stream}/nodes");
    let empty = app.get(&place).await.expect(200).json();
    assert_eq!(empty, json!({"items": [], "sequence": 0, "state": "open"}));
    for k in 0..4_usize {
        app.post(&place, &block(1 + k as u64, 10 * k..10 * k + 10)).await.expect(200);
    }
    let blocks = |from: usize| -> Vec<Value> {
        (from..4).map(|k| json!({"sequence": k + 1, "nodes": nodes(10 * k..10 * k + 10)})).collect()
    };
    for after in 0..=4 {
        let found = app.get(&format!("{place}?after={after}")).await.expect(200).json();
        assert_eq!(found, json!({"items": blocks(after), "sequence": 4, "state": "open"}), "{after}");
    }
    assert_eq!(app.get(&place).await.json()["items"], json!(blocks(0)), "from the beginning");
    for odd in ["-1", "x", "1.5", ""] {
        assert_eq!(app.get(&format!("{place}?after={odd}")).await.problem(422, "invalid_request"), ["/after"], "{odd}");
    }
    let beyond = app.get("/v1/streams/00000000-0000-7000-8000-000000000000/nodes").await;
    beyond.problem(404, "not_found");
    send(app.request(Method::POST, &format!("{stream}/finish"))).await.expect(201);
    let finished = app.get(&place).await.expect(200).json();
    assert_eq!(finished, json!({"items": [], "sequence": 4, "state": "finished", "iteration_number": 1}));
    app.stop().await;
}
