//! Curves and surfaces kept with an iteration: stored, listed, found again after a restart.

use serde_json::{Value, json};

use super::{close, curves::values, examples};
use crate::harness::{Answer, TestApp, send};

async fn stored_iteration(app: &TestApp, nodes: Value, model: Value) -> String {
    let job = send(app.post("/v1/jobs", r#"{"name": "wheel"}"#)).await.json();
    let place = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let request = json!({"nodes": nodes, "model": model});
    let answer = send(app.post(&place, request.to_string())).await;
    assert_eq!(answer.status, 201, "{}", answer.text);
    format!("{place}/1")
}

fn line() -> Value {
    json!({"type": "curve", "x": [0.0, 1.0, 2.0, 3.0, 4.0], "y": [0.1, 1.0, 1.9, 3.2, 3.9]})
}

fn grid() -> Value {
    let z = |u: f64, v: f64| 1.0 + 0.5 * u - 0.25 * v + 0.125 * u * v;
    let (u, v) = ([0.0, 1.0, 2.5, 4.0], [-2.0, 0.0, 1.0, 2.0]);
    json!({"type": "grid", "u": u, "v": v, "z": u.map(|u| v.map(|v| z(u, v)))})
}

fn straight() -> Value {
    json!({"type": "polynomial", "degree": 1})
}

async fn keep(app: &TestApp, place: &str, kind: &str, request: &Value) -> Answer {
    send(app.post(&format!("{place}/{kind}"), request.to_string())).await
}

#[tokio::test]
async fn a_curve_of_the_iterations_own_nodes_is_kept() {
    let app = TestApp::start().await;
    let place = stored_iteration(&app, line(), straight()).await;
    let before = send(app.get(&place)).await;
    let request = json!({"method": {"type": "cubic_spline", "ends": {"type": "natural"}}});
    let kept = keep(&app, &place, "curves", &request).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let body = kept.json();
    assert_eq!((&body["kind"], &body["method"]), (&json!("curve"), &json!("cubic_spline")));
    assert_eq!(body["request"], request);
    // the same as of posted points
    let mut posted = request.clone();
    posted["points"] = json!({"x": line()["x"], "y": line()["y"]});
    assert_eq!(body["result"], send(app.post("/v1/curves", posted.to_string())).await.json());
    let found = values(&app, &body["result"]["curve"], &[1.0, 3.0]).await;
    close(found[1].as_f64().unwrap(), 3.2, 1e-14);
    // posted points go before nodes
    let other = keep(&app, &place, "curves", &examples("create_curve")[0].1).await;
    assert_eq!(other.status, 201, "{}", other.text);
    assert_eq!(send(app.get(&place)).await.text, before.text, "the iteration is as it was");
    assert_eq!(send(app.get(&place)).await.header("etag"), before.header("etag"));

    let list = send(app.get(&format!("{place}/records?limit=1"))).await.json();
    assert_eq!(list["items"][0]["id"], body["id"]);
    assert!(list["items"][0].get("result").is_none());
    let next = list["next_cursor"].as_str().unwrap();
    let rest = send(app.get(&format!("{place}/records?cursor={next}"))).await.json();
    assert_eq!(rest["items"][0]["id"], other.json()["id"]);
    assert!(rest.get("next_cursor").is_none());

    let location = kept.header("location").to_owned();
    assert_eq!(location, format!("{place}/records/{}", body["id"].as_str().unwrap()));
    let app = TestApp::start_in(app.stop().await, |_| {}).await;
    assert_eq!(send(app.get(&location)).await.text, kept.text, "the same bytes after a restart");
}

#[tokio::test]
async fn a_surface_of_the_iterations_grid_is_kept() {
    let app = TestApp::start().await;
    let place = stored_iteration(&app, grid(), straight()).await;
    for (name, request) in examples("create_iteration_surface") {
        let kept = keep(&app, &place, "surfaces", &request).await;
        assert_eq!(kept.status, 201, "{name}: {}", kept.text);
    }
    let request = json!({"method": {"type": "b_spline", "degree": [2, 1]}});
    let kept = keep(&app, &place, "surfaces", &request).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let surface = &kept.json()["result"]["surface"];
    let found = json!({"surface": surface, "at": [[1.7, 0.3], [4.0, 2.0]]});
    let found = send(app.post("/v1/surfaces/evaluate", found.to_string())).await.json();
    close(found["values"][0].as_f64().unwrap(), 1.0 + 0.85 - 0.075 + 0.125 * 0.51, 1e-14);
    close(found["values"][1].as_f64().unwrap(), 1.0 + 2.0 - 0.5 + 1.0, 1e-14);
}

#[tokio::test]
async fn a_key_keeps_one_shape_and_nothing_is_half_kept() {
    let app = TestApp::start().await;
    let place = stored_iteration(&app, line(), straight()).await;
    let request = json!({"method": {"type": "lagrange"}}).to_string();
    let keyed = || app.post(&format!("{place}/curves"), request.clone()).header("idempotency-key", "once");
    let first = send(keyed()).await;
    let second = send(keyed()).await;
    assert_eq!((first.status.as_u16(), &first.text), (201, &second.text));
    assert_eq!(second.header("idempotency-replayed"), "true");
    let refused = keep(&app, &place, "curves", &json!({"method": {"type": "b_spline", "degree": 9}})).await;
    refused.problem(422, "invalid_request");
    // a grid has no curve to offer, a curve no surface
    let refused = keep(&app, &place, "surfaces", &json!({"method": {"type": "b_spline", "degree": 1}})).await;
    refused.problem(422, "invalid_request");
    let list = send(app.get(&format!("{place}/records"))).await.json();
    assert_eq!(list["items"].as_array().unwrap().len(), 1);
    for path in [format!("{place}0/records"), format!("{place}/records/{}", uuid::Uuid::nil())] {
        send(app.get(&path)).await.problem(404, "not_found");
    }
    let nowhere = keep(&app, &format!("{place}0"), "curves", &json!({"method": {"type": "lagrange"}})).await;
    nowhere.problem(404, "not_found");
}

/// A fit of B-splines returns its curve or surface, also in the iteration.
#[tokio::test]
async fn fits_of_b_splines_are_shapes() {
    let app = TestApp::start().await;
    let model = json!({"type": "b_spline", "degree": 2, "knots": [0, 0, 0, 2, 4, 4, 4]});
    let place = stored_iteration(&app, line(), model).await;
    let id = send(app.get(&place)).await.json()["fits"][0]["id"].as_str().unwrap().to_owned();
    let result = send(app.get(&format!("{place}/fits/{id}"))).await.json()["result"].clone();
    let controls: Vec<_> = result["coefficients"].as_array().unwrap().iter().map(|c| c["value"].clone()).collect();
    assert_eq!(result["curve"]["control_points"], json!(controls));
    assert_eq!(result["curve"]["knots"], json!([0.0, 0.0, 0.0, 2.0, 4.0, 4.0, 4.0]));
    let found = values(&app, &result["curve"], &[0.0, 1.0, 2.0, 3.0, 4.0]).await;
    let posted = line();
    let heights = posted["y"].as_array().unwrap();
    let misses = found.iter().zip(heights).map(|(f, y)| f.as_f64().unwrap() - y.as_f64().unwrap());
    close(misses.map(|d| d * d).sum::<f64>(), result["residuals"]["rss"].as_f64().unwrap(), 1e-12);

    let model = json!({"type": "b_spline", "degree": 1, "spans": [1, 2]});
    let request = json!({"nodes": grid(), "model": model, "regularization": {"type": "none"}});
    let fit = app.fit(&request.to_string()).await.json();
    let at = json!({"surface": fit["surface"], "at": [[2.5, 1.0]]});
    let found = send(app.post("/v1/surfaces/evaluate", at.to_string())).await.json();
    close(found["values"][0].as_f64().unwrap(), 1.0 + 1.25 - 0.25 + 0.3125, 1e-13);

    // with weights it is a NURBS, and the same weights come back
    let model = json!({"type": "b_spline", "degree": 1, "spans": [1, 1], "weights": [[1.0, 2.0], [0.5, 1.0]]});
    let fit = app.fit(&json!({"nodes": grid(), "model": model}).to_string()).await;
    assert_eq!(fit.status, 200, "{}", fit.text);
    assert_eq!(fit.json()["surface"]["type"], "nurbs");
    assert_eq!(fit.json()["surface"]["weights"], json!([[1.0, 2.0], [0.5, 1.0]]));
    let ragged = json!({"type": "b_spline", "degree": 1, "spans": [1, 1], "weights": [[1.0, 2.0], [0.5]]});
    let problem = app.fit(&json!({"nodes": grid(), "model": ragged}).to_string()).await.problem(422, "invalid_request");
    assert_eq!(problem["errors"][0]["pointer"], "/model/weights/1");
}
