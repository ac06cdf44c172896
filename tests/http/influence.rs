//! Influence of single nodes over HTTP: results, refusals by pointer, storing and replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_influence").unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value}"))
}

#[tokio::test]
async fn an_outlier_has_the_largest_influence() {
    let app = TestApp::start().await;
    let body = app.fit(&example().to_string()).await.json();
    let found = &body["influence"];
    let outlier: Vec<f64> = list(&found["externally_studentized"]).iter().map(|t| t.as_f64().unwrap().abs()).collect();
    assert!(outlier[5] > 5.0 && (0..9).all(|k| k == 5 || outlier[k] < 3.0), "{found}");
    for name in ["leverage", "internally_studentized", "cooks_distance", "dffits", "press_residual"] {
        assert_eq!(list(&found[name]).len(), 9, "{name}");
    }
    let press: f64 = list(&found["press_residual"]).iter().map(|r| r.as_f64().unwrap().powi(2)).sum();
    assert!((found["press"].as_f64().unwrap() - press).abs() < 1e-12 * press);
    assert!(found.get("node_indices").is_none());

    let mut plain = example();
    plain["include"] = json!([]);
    assert!(app.fit(&plain.to_string()).await.json().get("influence").is_none());

    // a node that is not counted has no entry, one that alone determines a term null
    let matrix = json!({
        "nodes": {
            "type": "matrix", "x": [[1, 0], [1, 0], [1, 0], [1, 0], [1, 1]], "y": [0, 1, 2, 3, 9],
            "weight": [1, 0, 2, 1, 1]
        },
        "model": {"type": "linear"}, "regularization": {"type": "none"}, "include": ["influence"]
    });
    let body = app.fit(&matrix.to_string()).await.json();
    let found = &body["influence"];
    assert_eq!(found["node_indices"], json!([0, 2, 3, 4]));
    assert_eq!(found["press_residual"][3], Value::Null);
    assert!(found.get("press").is_none() && body["warnings"].to_string().contains("full_leverage"));
}

#[tokio::test]
async fn missing_influences_are_warned_of() {
    let app = TestApp::start().await;
    let mut robust = example();
    robust["estimator"] = json!({"type": "least_absolute_deviations"});
    let body = app.fit(&robust.to_string()).await.json();
    assert!(body.get("influence").is_none() && body["warnings"].to_string().contains("no_influence"), "{body}");
    let mut many = example();
    let x: Vec<u32> = (0..200_001).collect();
    many["nodes"] = json!({"type": "curve", "y": x, "x": x});
    let body = app.fit(&many.to_string()).await.json();
    assert!(body.get("influence").is_none());
    assert!(body["warnings"].to_string().contains("influences of 200001 nodes are omitted"));
}

#[tokio::test]
async fn stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "influence"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let stored = send(app.post(&iterations, example().to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    let fit = &stored["fits"][0];
    assert_eq!(list(&fit["result"]["influence"]["dffits"]).len(), 9);
    let path = format!("{iterations}/{}/fits/{}/replay", stored["number"], fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&path, "")).await.json()["identical"], true);
}
