//! Tenants in the service: what one of them has in memory does not exist for another.

use std::sync::Arc;

use flankfit::jobs::{Caller, JobDraft, Jobs, PostedBlock, Precondition, RepositoryError, Resource, Tenant};
use flankfit_engine::estimation::Nodes;
use reqwest::Method;
use serde_json::json;
use uuid::Uuid;

use super::{
    app::{TestApp, iteration, send},
    streams::{block, spec},
};

/// Jobs of another tenant than HTTP's.
fn others(app: &TestApp) -> Jobs {
    app.state().jobs.of(&Caller {
        tenant: Tenant::named("other").unwrap(),
        actor: "other".into(),
        origin: Default::default(),
    })
}

fn id_of(path: &str) -> Uuid {
    path.rsplit('/').next().unwrap().parse().unwrap()
}

fn missing<T>(outcome: Result<T, RepositoryError>, what: Resource) {
    assert!(matches!(outcome.err(), Some(RepositoryError::NotFound(found)) if found == what));
}

#[tokio::test]
async fn a_stream_in_memory_is_its_tenants_alone() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let stream = app.post(&format!("{job}/streams"), &spec()).await.expect(201).header("location").unwrap().to_owned();
    let nodes = format!("{stream}/nodes");
    app.post(&nodes, &block(1, 0..12)).await.expect(200);
    let (others, id) = (others(&app), id_of(&stream));
    missing(others.stream(id).await, Resource::Stream);
    let next = PostedBlock {
        sequence: 2,
        nodes: Arc::new(Nodes::scattered(vec![31.0], vec![2.0], vec![0.3], None).unwrap()),
        sha256: [1; 32],
    };
    let refused = others.add_block(app.state(), id, next, None).await.err().unwrap();
    assert_eq!((refused.status, &*refused.code), (404, "not_found"));
    assert_eq!(others.stream_with_estimate(app.state(), id).await.err().unwrap().status, 404);
    missing(others.delete_stream(id, Precondition::None).await, Resource::Stream);
    // and its own tenant goes on with it
    let two = app.post(&nodes, &block(2, 12..20)).await.expect(200);
    assert_eq!(two.json()["node_count"], 20);
    app.stop().await;
}

#[tokio::test]
async fn a_job_that_is_known_is_known_to_its_tenant_alone() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let (others, id) = (others(&app), id_of(&job));
    app.state()
        .jobs
        .of(&Caller { tenant: Tenant::default(), actor: "own".into(), origin: Default::default() })
        .known_job(id)
        .await
        .unwrap();
    missing(others.known_job(id).await, Resource::Job);
    missing(others.iteration(id, 1).await, Resource::Job);
    // nor does its bell ring for another
    let mut bell = others.listen(id);
    bell.borrow_and_update();
    app.iteration(&job).await;
    assert!(!bell.has_changed().unwrap());

    let draft = JobDraft { name: "theirs".to_owned(), ..JobDraft::default() };
    let theirs = others.create_job(draft, None).await.unwrap();
    let path = format!("/v1/jobs/{}", theirs.id);
    app.get(&path).await.problem(404, "not_found");
    app.post(&format!("{path}/iterations"), &iteration()).await.problem(404, "not_found");
    app.get(&format!("{path}/events")).await.problem(404, "not_found");
    let listed = app.get("/v1/jobs").await.json();
    assert_eq!(listed["items"].as_array().unwrap().len(), 1);
    app.stop().await;
}

/// While a key is worked on, the same key of another tenant is free.
#[tokio::test]
async fn a_running_key_is_its_tenants_alone() {
    let mut app = TestApp::start().await;
    let keys = app.state().keys.clone();
    let theirs = keys.claim(&Tenant::named("other").unwrap(), "k", "POST /v1/jobs").unwrap();
    app.post_keyed("/v1/jobs", "k", &json!({"name": "wheel"})).await.expect(201);
    drop(theirs);
    let own = keys.claim(&Tenant::default(), "l", "POST /v1/jobs").unwrap();
    let busy = app.request(Method::POST, "/v1/jobs").header("Idempotency-Key", "l").json(&json!({"name": "wheel"}));
    send(busy).await.problem(409, "idempotency_key_in_use");
    drop(own);
    app.post_keyed("/v1/jobs", "l", &json!({"name": "wheel"})).await.expect(201);
    app.stop().await;
}
