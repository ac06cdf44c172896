//! The examples of the document are requests that the service takes.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::Value;

use super::app::TestApp;

fn example(operation: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.operation_id == operation).unwrap();
    serde_json::from_str(example.text).unwrap()
}

#[tokio::test]
async fn the_examples_of_a_job_are_taken() {
    let mut app = TestApp::start().await;
    let created = app.post("/v1/jobs", &example("create_job")).await.expect(201);
    let job = created.header("location").unwrap();
    let added = app.post(&format!("{job}/iterations"), &example("create_iteration")).await.expect(201);
    let place = added.header("location").unwrap();
    let refit = app.post(&format!("{place}/fits"), &example("create_iteration_fit")).await.expect(201).json();
    let mut chosen = example("choose_fit");
    chosen["fit_id"] = refit["id"].clone();
    app.put(&format!("{place}/chosen-fit"), &chosen).await.expect(200);
    app.patch(place, &example("update_iteration")).await.expect(200);
    let opened = app.post(&format!("{job}/streams"), &example("create_stream")).await.expect(201);
    let stream = opened.header("location").unwrap();
    let block = app.post(&format!("{stream}/nodes"), &example("add_stream_nodes")).await.expect(200).json();
    assert_eq!(block["result"]["residuals"]["count"], 6);
    app.post(&format!("{stream}/finish"), &example("finish_stream")).await.expect(201);
    app.stop().await;
}
