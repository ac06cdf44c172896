//! A fitted polynomial as a surface: returned, and accepted by the operations on surfaces.

use super::{close, numbers};
use crate::harness::{TestApp, send};
use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_shape").unwrap();
    serde_json::from_str(example.text).unwrap()
}

#[tokio::test]
async fn a_fitted_polynomial_feeds_evaluation_closest_points_and_export() {
    let app = TestApp::start().await;
    let fit = app.fit(&example().to_string()).await.json();
    let surface = &fit["surface"];
    assert_eq!(surface["type"], "b_spline", "{fit}");
    let heights = numbers(&fit["predictions"]["value"]);
    let grid = &example()["predict"]["at"]["grid"];
    let answer = send(app.post("/v1/surfaces/evaluate", json!({"surface": surface, "grid": grid}).to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let found = numbers(&answer.json()["values"]);
    assert_eq!(found.len(), heights.len());
    for (found, height) in found.into_iter().zip(&heights) {
        close(found, *height, 1e-13);
    }
    // a point of the graph is its own closest point
    let point = [31.7, 13.1, heights[4]];
    let answer =
        send(app.post("/v1/surfaces/closest-points", json!({"surface": surface, "points": [point]}).to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    assert!(answer.json()["distances"][0].as_f64().unwrap() < 1e-12, "{}", answer.text);
    let answer = send(app.post("/v1/surfaces/export", json!({"surface": surface, "format": "step"}).to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    assert!(answer.text.contains("B_SPLINE_SURFACE_WITH_KNOTS"));
}

/// From nodes to a fit, from the fit to sections, from their mesh to patches: a polynomial of
/// second degree comes back as it is.
#[tokio::test]
async fn a_fit_is_cut_and_its_mesh_filled() {
    let app = TestApp::start().await;
    let fit = app.fit(&example().to_string()).await.json();
    let families =
        json!([{"normal": [1, 0, 0], "offsets": [30, 31, 34]}, {"normal": [0, 1, 0], "offsets": [0, 8, 20]}]);
    let cut = json!({"surface": fit["surface"], "families": families, "mesh": true});
    let answer = send(app.post("/v1/surfaces/sections", cut.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let cut = answer.json();
    assert!(cut["mesh_error"].as_f64().unwrap() <= 1e-9, "{cut}");
    let fill = json!({"mesh": cut["mesh"], "method": {"type": "gregory"}});
    let filled = send(app.post("/v1/surfaces", fill.to_string())).await;
    assert_eq!(filled.status, 200, "{}", filled.text);
    let evaluate = json!({"surface": filled.json()["surface"], "grid": example()["predict"]["at"]["grid"]});
    let answer = send(app.post("/v1/surfaces/evaluate", evaluate.to_string())).await;
    let (found, heights) = (numbers(&answer.json()["values"]), numbers(&fit["predictions"]["value"]));
    assert_eq!(found.len(), heights.len());
    for (found, height) in found.into_iter().zip(&heights) {
        close(found, *height, 1e-9);
    }
}

#[tokio::test]
async fn shapes_are_returned_on_request() {
    let app = TestApp::start().await;
    let mut plain = example();
    plain.as_object_mut().unwrap().remove("include");
    assert!(app.fit(&plain.to_string()).await.json().get("surface").is_none());
    let matrix = json!({
        "nodes": {"type": "matrix", "x": [[1, 0], [1, 1], [1, 2]], "y": [0, 1, 2.5]},
        "model": {"type": "linear"}, "include": ["shape"]
    });
    let answer = app.fit(&matrix.to_string()).await.json();
    assert!(answer["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "no_shape"), "{answer}");
}

#[tokio::test]
async fn a_stored_fit_returns_its_shape_and_replays() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "shapes"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let stored = send(app.post(&iterations, example().to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    let fit = &stored["fits"][0];
    assert_eq!(fit["result"]["surface"]["type"], "b_spline");
    let path = format!("{iterations}/{}/fits/{}", stored["number"], fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&format!("{path}/replay"), "")).await.json()["identical"], true);
}
