//! Requested results that do not exist: left out with a warning, or refused with a hint.

use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn line() -> Value {
    let x: Vec<f64> = (0..8).map(f64::from).collect();
    let y = [1.0, 2.1, 2.9, 4.2, 5.0, 6.1, 6.9, 8.2];
    json!({"nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 1}})
}

fn with(changes: Value) -> Value {
    let mut body = line();
    for (name, value) in changes.as_object().unwrap() {
        body[name] = value.clone();
    }
    body
}

fn warnings(answer: &Value) -> String {
    answer["warnings"].to_string()
}

#[tokio::test]
async fn warnings_name_the_fields_of_the_request() {
    let app = TestApp::start().await;
    let robust = with(json!({"coefficient_norm_limit": 9.0, "estimator": {"type": "least_absolute_deviations"},
                             "regularization": {"type": "none"}}));
    let answer = app.fit(&robust.to_string()).await.json();
    assert!(warnings(&answer).contains("norm_limit_unused"), "{answer}");
    assert!(warnings(&answer).contains("coefficient_norm_limit shortens"), "{answer}");
    let truncated = with(json!({"include": ["predicted_mse"], "regularization": {"type": "truncated_svd", "rank": 1}}));
    let answer = app.fit(&truncated.to_string()).await.json();
    assert!(warnings(&answer).contains("predicted_mse_corrected is not available here"), "{answer}");
    let flat = with(json!({"nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [0, 0, 0, 0]},
                           "prior": {"mean": [1, 1], "std_error": [1, 1]}}));
    let answer = app.fit(&flat.to_string()).await.json();
    assert!(warnings(&answer).contains("prior_unused"), "{answer}");
}

#[tokio::test]
async fn a_place_whose_powers_overflow_is_omitted() {
    let app = TestApp::start().await;
    let body = with(json!({"model": {"type": "polynomial", "degree": 3}, "regularization": {"type": "none"},
                           "predict": {"at": {"x": [1.0, 1e120, 2.0]}, "kinds": ["confidence", "simultaneous"]}}));
    let answer = app.fit(&body.to_string()).await.json();
    let found = &answer["predictions"];
    assert_eq!(found["place_indices"], json!([0, 2]), "{answer}");
    assert_eq!(found["value"].as_array().unwrap().len(), 2);
    assert_eq!(found["simultaneous"].as_array().unwrap().len(), 2);
    assert!(warnings(&answer).contains("number 1, from 0"), "{answer}");
}

#[tokio::test]
async fn refusals_have_pointers_and_say_what_to_do() {
    let app = TestApp::start().await;
    for std_error in [1e160, 1e300] {
        let body = with(json!({"prior": {"mean": [1, 1], "std_error": [std_error, std_error]}}));
        let refused = app.fit(&body.to_string()).await;
        assert_eq!(refused.status, 422, "{}", refused.text);
        assert_eq!(refused.json()["errors"][0]["pointer"], "/prior/std_error");
    }
    let zeros = json!({"nodes": {"type": "matrix", "x": [[0.0], [0.0]], "y": [1, 2]}, "model": {"type": "linear"},
                       "regularization": {"type": "truncated_svd", "rank": 1}});
    let refused = app.fit(&zeros.to_string()).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text.contains("every column is 0 at these nodes"), "{}", refused.text);
}

/// A stream whose heights are all 0 has nothing to combine a prior with, and is finished all the
/// same; one that requests earlier iterations is refused with a hint.
#[tokio::test]
async fn streams_with_priors() {
    let app = TestApp::start().await;
    let made = send(app.post("/v1/jobs", r#"{"name":"wheel"}"#)).await;
    let streams = format!("/v1/jobs/{}/streams", made.json()["id"].as_str().unwrap());
    let spec = |prior: Value| {
        json!({"model": {"type": "polynomial", "degree": 1}, "domain": {"u": [0, 7]}, "prior": prior}).to_string()
    };
    let refused = send(app.post(&streams, spec(json!({"iterations": "previous"})))).await;
    assert_eq!(refused.status, 422, "{}", refused.text);
    assert_eq!(refused.json()["errors"][0]["pointer"], "/prior/iterations");
    assert!(refused.text.contains("refit its iteration with this `prior`"), "{}", refused.text);
    let opened = send(app.post(&streams, spec(json!({"mean": [1, 1], "std_error": [1, 1]})))).await;
    let stream = format!("/v1/streams/{}", opened.json()["id"].as_str().unwrap());
    let block = json!({"sequence": 1, "nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [0, 0, 0, 0]}});
    let block = send(app.post(&format!("{stream}/nodes"), block.to_string())).await;
    assert!(block.text.contains("prior_unused"), "{}", block.text);
    let finished = send(app.post(&format!("{stream}/finish"), "{}")).await;
    assert_eq!(finished.status, 201, "{}", finished.text);
    assert!(finished.text.contains("prior_unused"), "{}", finished.text);
}
