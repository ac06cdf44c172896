//! Requests that a stream's model excludes: refused when it is opened, or by the block that
//! determines the number of coefficients.

use reqwest::Method;
use serde_json::json;

use super::app::{TestApp, send};

/// A regularisation that n excludes is refused at opening, by the pointer of the batch fit; nothing
/// is stored.
#[tokio::test]
async fn a_regularisation_that_the_model_rules_out_is_refused_at_opening() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/streams");
    let surface = json!({"type": "polynomial", "degree": [1, 1]});
    let curve = json!({"model": {"type": "polynomial", "degree": 2, "basis": "chebyshev"}, "domain": {"u": [0, 1]}});
    let raw = json!({"type": "polynomial", "degree": 2});
    let spline = json!({"type": "b_spline", "degree": 1, "knots": [0, 0, 0.5, 1, 1]});
    for (model, regularization, pointer) in [
        (&surface, json!({"type": "truncated_svd", "rank": 5}), "/regularization/rank"),
        (&surface, json!({"type": "attraction", "target": [0, 1, 2]}), "/regularization/target"),
        (&surface, json!({"type": "james_stein", "target": [0, 1, 2, 3, 4]}), "/regularization/target"),
        (&surface, json!({"type": "spectral", "count": 4}), "/regularization/count"),
        (&surface, json!({"type": "tikhonov", "order": 2}), "/regularization/order"),
        (&surface, json!({"type": "tikhonov", "order": 1, "weights": [1]}), "/regularization/weights"),
        (&spline, json!({"type": "tikhonov", "order": 1, "weights": [1, 1]}), "/regularization/weights"),
        (&spline, json!({"type": "tikhonov", "order": 2}), "/regularization/order"),
        (
            &spline,
            json!({"type": "ridge", "parameter": {"criterion": "min_condition"}}),
            "/regularization/parameter/criterion",
        ),
        // whether of a curve or of a surface: 3 or 9
        (&raw, json!({"type": "truncated_svd", "rank": 10}), "/regularization/rank"),
    ] {
        let asked = json!({"model": model, "regularization": regularization});
        let answer = app.post(&path, &asked).await;
        assert_eq!(answer.problem(422, "invalid_request")[0], pointer, "{asked}: {}", answer.text);
    }
    let mut ruled_out = curve.clone();
    ruled_out["regularization"] = json!({"type": "truncated_svd", "rank": 4});
    assert_eq!(app.post(&path, &ruled_out).await.problem(422, "invalid_request"), ["/regularization/rank"]);
    ruled_out["regularization"]["rank"] = json!(3);
    ruled_out["filters"] = json!([{"type": "hampel", "window": 5}]);
    assert_eq!(app.post(&path, &ruled_out).await.problem(422, "invalid_request"), ["/filters"]);
    // no stream hinders the job's end
    app.delete(&job).await.expect(204);
    app.stop().await;
}

/// The columns of a measurement matrix are counted in its first block: that one is refused, and
/// another may take its place.
#[tokio::test]
async fn the_first_block_that_decides_n_is_refused_where_it_rules_the_regularisation_out() {
    let mut app = TestApp::start().await;
    let spec =
        json!({"model": {"type": "linear"}, "regularization": {"type": "attraction", "target": [1.0, 0.0, 0.5]}});
    let stream = app.stream(&app.job().await, &spec).await;
    let path = format!("{stream}/nodes");
    let rows = |columns: usize| {
        let x: Vec<Vec<f64>> =
            (0..6).map(|i| (0..columns).map(|j| ((i + 1) as f64).powi(j as i32)).collect()).collect();
        json!({"sequence": 1, "nodes": {"type": "matrix", "x": x, "y": [1, 2, 2, 3, 5, 4]}})
    };
    let before = app.get(&stream).await.expect(200).text;
    let refused = app.post(&path, &rows(2)).await;
    assert_eq!(refused.problem(422, "invalid_request"), ["/nodes/x"]);
    assert!(refused.text.contains("/regularization/target"), "{}", refused.text);
    assert_eq!(app.get(&stream).await.expect(200).text, before);
    app.restart().await;
    assert_eq!(app.get(&stream).await.expect(200).text, before);
    let answer = app.post(&path, &rows(3)).await.expect(200).json();
    assert_eq!(answer["result"]["regularization"]["type"], "attraction");
    send(app.request(Method::POST, &format!("{stream}/finish"))).await.expect(201);
    app.stop().await;
}
