//! `/v1/curves/evaluate`, `/v1/surfaces/evaluate` and closest points.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use super::{close, examples, numbers};
use crate::harness::{TestApp, send};
use flankfit::api::{
    curves::{closest::CurveFeetBody, evaluate::CurveValuesBody},
    surfaces::{closest::SurfaceFeetBody, values::SurfaceValuesBody},
};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, json};

/// A quarter of the unit circle.
fn quarter() -> Value {
    json!({"type": "nurbs", "degree": 2, "knots": [0, 0, 0, 1, 1, 1],
        "control_points": [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
           "weights": [1.0, 0.5 * SQRT_2, 1.0]})
}

/// A quarter of a cylinder of radius 2 along z, from 0 to 3.
fn cylinder() -> Value {
    let w = 0.5 * SQRT_2;
    json!({"type": "nurbs", "degree": [2, 1], "knots": [[0, 0, 0, 1, 1, 1], [0, 0, 3, 3]],
           "control_points": [[[2, 0, 0], [2, 0, 3]], [[2, 2, 0], [2, 2, 3]], [[0, 2, 0], [0, 2, 3]]],
           "weights": [[1, 1], [w, w], [1, 1]]})
}

async fn ask(app: &TestApp, path: &str, request: &Value) -> Value {
    let answer = send(app.post(path, request.to_string())).await;
    assert_eq!(answer.status, 200, "{request}: {}", answer.text);
    answer.json()
}

#[tokio::test]
async fn a_circle_is_a_circle() {
    let app = TestApp::start().await;
    let at: Vec<f64> = (0..=20).map(|i| f64::from(i) / 20.0).collect();
    let request = json!({"curve": quarter(), "at": at, "derivatives": 3, "include": ["arc_length"]});
    let found = ask(&app, "/v1/curves/evaluate", &request).await;
    for (i, value) in found["values"].as_array().unwrap().iter().enumerate() {
        let [x, y] = numbers(value)[..] else { panic!("{value}") };
        assert!((x.hypot(y) - 1.0).abs() < 1e-15);
        close(found["curvature"][i].as_f64().unwrap(), 1.0, 1e-13);
        close(found["arc_length"][i].as_f64().unwrap(), y.atan2(x), 1e-12);
        let velocity = numbers(&found["derivatives"][0][i]);
        assert!((x * velocity[0] + y * velocity[1]).abs() < 1e-15);
    }
    close(found["length"].as_f64().unwrap(), FRAC_PI_2, 1e-12);
    assert!(found["length_error"].as_f64().unwrap() < 1e-9);
    assert_eq!(found["derivatives"].as_array().unwrap().len(), 3);
}

#[tokio::test]
async fn a_curve_with_zero_velocity_has_no_curvature_there() {
    let app = TestApp::start().await;
    let curve =
        json!({"type": "piecewise_polynomial", "breaks": [0, 1], "coefficients": [[[0, 0], [0, 0], [1, 0], [0, 1]]]});
    let found = ask(&app, "/v1/curves/evaluate", &json!({"curve": curve, "at": [0.5, 0.0], "derivatives": 2})).await;
    assert!(found.get("curvature").is_none());
    assert_eq!(found["warnings"][0]["code"], "no_curvature");
    assert!(found["warnings"][0]["message"].as_str().unwrap().contains("number 1"));
}

#[tokio::test]
async fn a_cylinder_bends_one_way() {
    let app = TestApp::start().await;
    let request = json!({"surface": cylinder(), "grid": {"u": [0.0, 0.3, 1.0], "v": [0.0, 1.5, 3.0]}, "derivatives": 2,
                         "include": ["fundamental_forms", "area"]});
    let found = ask(&app, "/v1/surfaces/evaluate", &request).await;
    assert_eq!(found["values"].as_array().unwrap().len(), 9);
    for i in 0..9 {
        let [x, y, z] = numbers(&found["values"][i])[..] else { panic!() };
        close(x.hypot(y), 2.0, 1e-15);
        close(z, [0.0, 1.5, 3.0][i % 3], 1e-15);
        // S_u × S_v points outwards, away from the axis that the surface bends to
        let normal = numbers(&found["normals"][i]);
        close(normal[0] * x + normal[1] * y, 2.0, 1e-14);
        let [greater, lesser] = numbers(&found["curvatures"]["principal"][i])[..] else { panic!() };
        close(greater, 0.0, 1e-13);
        close(lesser, -0.5, 1e-13);
        close(found["curvatures"]["gaussian"][i].as_f64().unwrap(), 0.0, 1e-13);
        close(found["curvatures"]["mean"][i].as_f64().unwrap(), -0.25, 1e-13);
        let [e, f, g] = numbers(&found["fundamental_forms"]["first"][i])[..] else { panic!() };
        let velocity = numbers(&found["derivatives"]["u"][i]);
        close(e, velocity[0] * velocity[0] + velocity[1] * velocity[1], 1e-13);
        close(f, 0.0, 1e-14);
        close(g, 1.0, 1e-14);
    }
    close(found["area"]["value"].as_f64().unwrap(), 3.0 * PI, 1e-9);
    // the same by pairs
    let pairs: Vec<_> = [0.0, 0.3, 1.0].iter().flat_map(|u| [0.0, 1.5, 3.0].map(|v| [*u, v])).collect();
    let same = ask(&app, "/v1/surfaces/evaluate", &json!({"surface": cylinder(), "at": pairs, "derivatives": 2})).await;
    assert_eq!(same["values"], found["values"]);
    assert_eq!(same["derivatives"], found["derivatives"]);
}

#[tokio::test]
async fn closest_points_of_circle_and_cylinder() {
    let app = TestApp::start().await;
    let points: [[f64; 2]; 3] = [[2.0, 2.0], [0.3, 0.1], [-1.0, 3.0]];
    let found = ask(&app, "/v1/curves/closest-points", &json!({"curve": quarter(), "points": points})).await;
    for (i, [x, y]) in points.into_iter().enumerate() {
        // inside the quarter the foot lies on the ray from the centre, outside of it at an end
        let (foot, distance) = if x > 0.0 && y > 0.0 {
            ([x / x.hypot(y), y / x.hypot(y)], (x.hypot(y) - 1.0).abs())
        } else {
            ([0.0, 1.0], (x * x + (y - 1.0) * (y - 1.0)).sqrt())
        };
        for (a, b) in numbers(&found["points"][i]).into_iter().zip(foot) {
            close(a, b, 1e-9);
        }
        close(found["distances"][i].as_f64().unwrap(), distance, 1e-12);
    }
    let nodes: [[f64; 3]; 2] = [[3.0, 3.0, 1.0], [0.5, 0.5, 2.0]];
    let found = ask(&app, "/v1/surfaces/closest-points", &json!({"surface": cylinder(), "points": nodes})).await;
    for (i, [x, y, z]) in nodes.into_iter().enumerate() {
        let signed = f64::hypot(x, y) - 2.0;
        close(found["distances"][i].as_f64().unwrap(), signed.abs(), 1e-12);
        close(found["signed_distances"][i].as_f64().unwrap(), signed, 1e-12);
        close(numbers(&found["points"][i])[2], z, 1e-9);
        close(numbers(&found["parameters"][i])[1], z, 1e-9);
    }
}

async fn documented<B: Serialize + DeserializeOwned>(app: &TestApp, operation: &str, path: &str) {
    for (name, request) in examples(operation) {
        let found = ask(app, path, &request).await;
        let body: B = serde_json::from_value(found.clone()).unwrap();
        assert_eq!(serde_json::to_value(&body).unwrap(), found, "{name}");
    }
}

#[tokio::test]
async fn examples_are_answered_as_documented() {
    let app = TestApp::start().await;
    documented::<CurveValuesBody>(&app, "evaluate_curve", "/v1/curves/evaluate").await;
    documented::<CurveFeetBody>(&app, "closest_points_of_curve", "/v1/curves/closest-points").await;
    documented::<SurfaceValuesBody>(&app, "evaluate_surface", "/v1/surfaces/evaluate").await;
    documented::<SurfaceFeetBody>(&app, "closest_points_of_surface", "/v1/surfaces/closest-points").await;
}

#[tokio::test]
async fn impossible_places_and_shapes_are_pointed_at() {
    let app = TestApp::start().await;
    let with = |key: &str, value: Value| {
        let mut curve = quarter();
        curve[key] = value;
        curve
    };
    let cases = [
        ("/v1/curves/evaluate", json!({"curve": quarter(), "at": [0.5, 1.5]}), "/at/1"),
        ("/v1/curves/evaluate", json!({"curve": quarter(), "at": [0.5], "derivatives": 4}), "/derivatives"),
        ("/v1/curves/evaluate", json!({"curve": quarter(), "at": 0.5}), "/at"),
        ("/v1/curves/evaluate", json!({"curve": quarter()}), "/at"),
        ("/v1/curves/evaluate", json!({"curve": with("weights", json!([1, 1])), "at": []}), "/curve/weights"),
        ("/v1/curves/evaluate", json!({"curve": with("weights", json!([1, -1, 1])), "at": []}), "/curve/weights/1"),
        ("/v1/curves/evaluate", json!({"curve": with("weights", json!([0, 1, 1])), "at": []}), "/curve/weights"),
        ("/v1/curves/evaluate", json!({"curve": with("knots", json!([0, 0, 1, 0, 1, 1])), "at": []}), "/curve/knots/3"),
        (
            "/v1/curves/evaluate",
            json!({"curve": with("control_points", json!([[1, 0], [1, 1]])), "at": []}),
            "/curve/control_points",
        ),
        (
            "/v1/curves/evaluate",
            json!({"curve": with("control_points", json!([[1, 0], 1, [0, 1]])), "at": []}),
            "/curve/control_points/1",
        ),
        (
            "/v1/curves/evaluate",
            json!({"curve": {"type": "polynomial", "form": "barycentric", "nodes": [0, 1], "values": [1, 2],
                "weights": [1, 1]}, "at": []}),
            "/curve/weights",
        ),
        ("/v1/curves/closest-points", json!({"curve": quarter(), "points": [[1, 2, 3]]}), "/points/0"),
        ("/v1/surfaces/evaluate", json!({"surface": cylinder(), "at": [[0.5, 4.0]]}), "/at/0/1"),
        ("/v1/surfaces/evaluate", json!({"surface": cylinder(), "at": [[0.5]]}), "/at/0"),
        ("/v1/surfaces/evaluate", json!({"surface": cylinder()}), "/at"),
        ("/v1/surfaces/evaluate", json!({"surface": cylinder(), "at": [], "grid": {"u": [], "v": []}}), "/grid"),
        ("/v1/surfaces/evaluate", json!({"surface": cylinder(), "at": [], "derivatives": 3}), "/derivatives"),
        ("/v1/surfaces/closest-points", json!({"surface": cylinder(), "points": [[1, 2]]}), "/points/0"),
    ];
    for (path, request, pointer) in cases {
        let problem = send(app.post(path, request.to_string())).await.problem(422, "invalid_request");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{request}: {problem}");
    }
}
