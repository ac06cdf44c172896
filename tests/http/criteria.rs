//! Criteria for λ* and ranks other than the usual, and corrected predictions, over HTTP.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example(regularization: Value) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_ridge_trace").unwrap();
    let mut request: Value = serde_json::from_str(example.text).unwrap();
    request["regularization"] = regularization;
    request["include"] = json!(["predicted_mse"]);
    request
}

#[tokio::test]
async fn the_requested_criterion_is_among_the_choices() {
    let app = TestApp::start().await;
    for (criterion, corrected) in [("reml", true), ("press", false), ("sure", true), ("gcv", true)] {
        for (kind, parameter) in [("ridge", "parameter"), ("spectral", "lambda_star")] {
            let request = example(json!({"type": kind, parameter: {"criterion": criterion}}));
            let answer = app.fit(&request.to_string()).await;
            assert_eq!(answer.status, 200, "{}", answer.text);
            let found = answer.json()["regularization"].clone();
            assert_eq!(found["criterion"], criterion);
            let own: Vec<&Value> =
                found["choices"].as_array().unwrap().iter().filter(|choice| choice["criterion"] == criterion).collect();
            assert_eq!(own.len(), 1, "{found}");
            assert_eq!(own[0].get("lambda_star"), found.get("lambda_star"));
            let regularized = found.get("lambda_star").is_some();
            assert_eq!(found.get("predicted_mse_corrected").is_some(), corrected || !regularized, "{found}");
        }
    }
    let mut lean = example(json!({"type": "ridge"}));
    lean["include"] = json!([]);
    let found = app.fit(&lean.to_string()).await.json()["regularization"].clone();
    assert!(found.get("predicted_mse_corrected").is_none());
    assert!(!found["choices"].to_string().contains("reml"), "what costs time is answered when asked for");
}

#[tokio::test]
async fn ranks_are_chosen_or_given() {
    let app = TestApp::start().await;
    for criterion in ["gcv", "reml", "discrepancy"] {
        let request = example(json!({"type": "truncated_svd", "parameter": {"criterion": criterion}}));
        let body = app.fit(&request.to_string()).await.json();
        assert_eq!(body["regularization"]["criterion"], criterion);
        let rank = body["regularization"]["rank"].as_u64().unwrap();
        let kept = body["regularization"]["filter_factors"].as_array().unwrap();
        assert_eq!(kept.iter().filter(|f| **f == 1.0).count() as u64, rank);
        assert_eq!(body["spec"]["regularization"]["parameter"], json!({"criterion": criterion}));
    }
    for (regularization, pointer) in [
        (json!({"type": "truncated_svd"}), "/regularization/rank"),
        (json!({"type": "truncated_svd", "rank": 2, "parameter": {"criterion": "gcv"}}), "/regularization/parameter"),
        (
            json!({"type": "truncated_svd", "parameter": {"criterion": "l_curve"}}),
            "/regularization/parameter/criterion",
        ),
        (json!({"type": "ridge", "parameter": {"criterion": "aicc"}}), "/regularization/parameter/criterion"),
    ] {
        let answer = app.fit(&example(regularization).to_string()).await;
        answer.problem(422, "invalid_request");
        assert_eq!(answer.pointers(), [pointer]);
    }
}

#[tokio::test]
async fn a_stream_has_no_nodes_to_leave_out() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "criteria"}).to_string())).await.json();
    let streams = format!("/v1/jobs/{}/streams", job["id"].as_str().unwrap());
    let open = |kind: &str, parameter: &str| {
        json!({
            "model": {"type": "polynomial", "degree": 1},
            "regularization": {"type": kind, parameter: {"criterion": "press"}}
        })
    };
    for (kind, parameter) in [("ridge", "parameter"), ("spectral", "lambda_star")] {
        let answer = send(app.post(&streams, open(kind, parameter).to_string())).await;
        answer.problem(422, "invalid_request");
        assert_eq!(answer.pointers(), [format!("/regularization/{parameter}/criterion")]);
    }
}

#[tokio::test]
async fn stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "criteria"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let request = example(json!({"type": "ridge", "parameter": {"criterion": "reml"}}));
    let stored = send(app.post(&iterations, request.to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    let fit = &stored["fits"][0];
    assert!(fit["result"]["regularization"]["predicted_mse_corrected"].is_number());
    let path = format!("{iterations}/{}/fits/{}/replay", stored["number"], fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&path, "")).await.json()["identical"], true);
}
