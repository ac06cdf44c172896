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
    app.put(&format!("{place}/chosen_fit"), &chosen).await.expect(200);
    app.patch(place, &example("update_iteration")).await.expect(200);
    app.stop().await;
}
