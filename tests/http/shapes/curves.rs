//! `POST /v1/curves`: every method, and what is refused.

use super::{close, examples, numbers};
use crate::harness::{TestApp, send};
use flankfit::api::curves::result::BuiltCurveBody;
use serde_json::{Value, json};

/// Values of a returned curve, at places.
pub async fn values(app: &TestApp, curve: &Value, at: &[f64]) -> Vec<Value> {
    let request = json!({"curve": curve, "at": at});
    let answer = send(app.post("/v1/curves/evaluate", request.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()["values"].as_array().unwrap().clone()
}

async fn build(app: &TestApp, points: Value, method: Value) -> Value {
    let answer = send(app.post("/v1/curves", json!({"points": points, "method": method}).to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

#[tokio::test]
async fn every_example_is_a_curve_that_can_be_sent_back() {
    let app = TestApp::start().await;
    for (name, request) in examples("create_curve") {
        let answer = send(app.post("/v1/curves", request.to_string())).await;
        assert_eq!(answer.status, 200, "{name}: {}", answer.text);
        assert!(!answer.text.contains("null"), "{name}: {}", answer.text);
        let built = answer.json();
        let body: BuiltCurveBody = serde_json::from_str(&answer.text).unwrap();
        assert_eq!(serde_json::to_value(&body).unwrap(), built, "{name}: every field is documented");
        let graph = request["points"]["x"].is_array();
        let parameters = numbers(if graph { &request["points"]["x"] } else { &built["parameters"] });
        let (low, high) = (parameters[0], parameters[parameters.len() - 1]);
        assert_eq!(built["domain"], json!([low, high]), "{name}");
        let found = values(&app, &built["curve"], &parameters).await;
        if built["stability"].is_object() {
            // a method through points: the curve that comes back meets them
            let wanted = if graph { &request["points"]["y"] } else { &request["points"]["xyz"] };
            for (found, wanted) in found.iter().zip(wanted.as_array().unwrap()) {
                let flat = |v: &Value| v.as_f64().map_or_else(|| numbers(v), |y| vec![y]);
                for (a, b) in flat(found).into_iter().zip(flat(wanted)) {
                    close(a, b, 1e-13);
                }
            }
        }
    }
}

/// Numbers of Burden and Faires (Numerical Analysis, 3.3): J₀ of the Bessel function at 1.5 from
/// five nodes.
#[tokio::test]
async fn one_polynomial_in_two_forms() {
    let app = TestApp::start().await;
    let points = json!({"x": [1.0, 1.3, 1.6, 1.9, 2.2], "y": [0.7651977, 0.6200860, 0.4554022, 0.2818186, 0.1103623]});
    for method in ["lagrange", "newton"] {
        let built = build(&app, points.clone(), json!({"type": method})).await;
        let value = values(&app, &built["curve"], &[1.5]).await[0].as_f64().unwrap();
        close(value, 0.5118200, 1e-7);
        assert_eq!(built["curve"]["form"], if method == "newton" { "newton" } else { "barycentric" });
        // the greatest Σ|Lᵢ| of five equally spaced nodes, by golden section in exact fractions
        close(built["stability"]["lebesgue_constant"].as_f64().unwrap(), 2.207824397325843, 1e-12);
        assert!(built["stability"]["condition"].as_f64().unwrap() > 1.0);
    }
}

/// y = x³ from values and slopes at 0 and 1, and from values, slope and bending at 0 alone with the
/// value at 1.
#[tokio::test]
async fn derivatives_of_mixed_order_are_met() {
    let app = TestApp::start().await;
    for derivatives in [json!([[0.0], [3.0]]), json!([[0.0, 0.0], []])] {
        let method = json!({"type": "hermite", "derivatives": derivatives});
        let built = build(&app, json!({"x": [0.0, 1.0], "y": [0.0, 1.0]}), method).await;
        for (t, value) in [0.25, 0.5, 0.75].into_iter().zip(values(&app, &built["curve"], &[0.25, 0.5, 0.75]).await) {
            close(value.as_f64().unwrap(), t * t * t, 1e-15);
        }
    }
}

/// The natural spline through (0,0), (1,1), (2,0) is 1.5 x − 0.5 x³ on [0, 1] (by hand); the others
/// reproduce x³.
#[tokio::test]
async fn cubic_splines_with_every_end() {
    let app = TestApp::start().await;
    let spline = |ends: Value| json!({"type": "cubic_spline", "ends": ends});
    let hat = json!({"x": [0.0, 1.0, 2.0], "y": [0.0, 1.0, 0.0]});
    let built = build(&app, hat.clone(), spline(json!({"type": "natural"}))).await;
    close(values(&app, &built["curve"], &[0.5]).await[0].as_f64().unwrap(), 0.6875, 1e-15);
    let cube = |x: &[f64]| json!({"x": x, "y": x.iter().map(|x| x * x * x).collect::<Vec<_>>()});
    for ends in [
        json!({"type": "clamped", "start": 3.0, "end": 12.0}),
        json!({"type": "second_derivative", "start": -6.0, "end": 12.0}),
        json!({"type": "not_a_knot"}),
    ] {
        let built = build(&app, cube(&[-1.0, 0.5, 1.0, 2.0]), spline(ends.clone())).await;
        for (x, y) in [-0.5, 0.75, 1.5].into_iter().zip(values(&app, &built["curve"], &[-0.5, 0.75, 1.5]).await) {
            close(y.as_f64().unwrap(), x * x * x, 1e-14);
        }
    }
    let built = build(&app, hat, spline(json!({"type": "periodic"}))).await;
    let request = json!({"curve": built["curve"], "at": [0.0, 2.0], "derivatives": 2});
    let ends = send(app.post("/v1/curves/evaluate", request.to_string())).await.json();
    for order in 0..2 {
        let [start, end] = [0, 1].map(|i| ends["derivatives"][order][i].as_f64().unwrap());
        close(start, end, 1e-13);
    }
}

#[tokio::test]
async fn oscillation_is_a_figure_and_a_warning() {
    let app = TestApp::start().await;
    let x: Vec<f64> = (0..21).map(|i| -1.0 + 0.1 * f64::from(i)).collect();
    let y: Vec<f64> = x.iter().map(|x| 1.0 / (1.0 + 25.0 * x * x)).collect();
    let points = json!({"x": x, "y": y});
    let wild = build(&app, points.clone(), json!({"type": "lagrange"})).await;
    assert!(wild["stability"]["lebesgue_constant"].as_f64().unwrap() > 1e4);
    assert!(wild["stability"]["overshoot"]["relative"].as_f64().unwrap() > 10.0);
    assert!(wild["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "overshoot"));
    let calm = build(&app, points.clone(), json!({"type": "cubic_hermite", "tangents": "monotone"})).await;
    assert!(calm["stability"].get("overshoot").is_none(), "{}", calm["stability"]);
    let spline = build(&app, points, json!({"type": "cubic_spline", "ends": {"type": "not_a_knot"}})).await;
    assert!(spline["stability"]["lebesgue_constant"].as_f64().unwrap() < 3.0);
    assert!(spline["stability"]["condition"].as_f64().unwrap() < 100.0);
}

#[tokio::test]
async fn impossible_curves_are_pointed_at() {
    let app = TestApp::start().await;
    let graph = |x: Value, y: Value| json!({"x": x, "y": y});
    let three = graph(json!([0, 1, 2]), json!([1, 2, 4]));
    let lagrange = json!({"type": "lagrange"});
    let spline = json!({"type": "cubic_spline", "ends": {"type": "natural"}});
    let b_spline = |degree: usize| json!({"type": "b_spline", "degree": degree});
    let cases = [
        (json!({"method": lagrange}), "/points"),
        (json!({"points": three}), "/method"),
        (json!({"points": three, "method": {"type": "bezier"}}), "/method/type"),
        (json!({"points": {"x": [1, 2]}, "method": lagrange}), "/points/y"),
        (json!({"points": graph(json!([0, 1]), json!([1, 2, 3])), "method": lagrange}), "/points/y"),
        (json!({"points": graph(json!([0, 1, 0]), json!([1, 2, 3])), "method": lagrange}), "/points/x/2"),
        (json!({"points": graph(json!([0, 2, 1]), json!([1, 2, 3])), "method": spline}), "/points/x/2"),
        (json!({"points": graph(json!([0, 1, 1]), json!([1, 2, 3])), "method": spline}), "/points/x/2"),
        (json!({"points": graph(json!([0, "1"]), json!([1, 2])), "method": lagrange}), "/points/x/1"),
        (json!({"points": three, "method": b_spline(3)}), "/method/degree"),
        (
            json!({"points": three, "method": {"type": "b_spline", "degree": 2, "knots": [0, 0, 0, 2, 1, 2]}}),
            "/method/knots/4",
        ),
        (json!({"points": three, "method": {"type": "hermite", "derivatives": [[1], [1]]}}), "/method/derivatives"),
        (
            json!({"points": three, "method": {"type": "hermite", "derivatives": [[[1, 2]], [], []]}}),
            "/method/derivatives/0",
        ),
        (json!({"points": three, "method": {"type": "cubic_hermite", "tangents": "given"}}), "/method/values"),
        (
            json!({"points": three, "method": {"type": "cubic_hermite", "tangents": "akima", "values": [1, 2, 3]}}),
            "/method/values",
        ),
        (json!({"points": three, "method": {"type": "cubic_spline", "ends": {"type": "loose"}}}), "/method/ends/type"),
        (json!({"points": three, "method": {"type": "cubic_spline", "ends": {"type": "periodic"}}}), "/points/y/2"),
        (json!({"points": three, "method": lagrange, "estimator": {"type": "least_squares"}}), "/estimator"),
        (json!({"points": {"xyz": [[0, 0], [1, 1], [1, 1]]}, "method": b_spline(1)}), "/points/xyz/2"),
        (json!({"points": {"xyz": [[0, 0], [1, 1, 1]]}, "method": b_spline(1)}), "/points/xyz/1"),
        (json!({"points": {"xyz": [[0], [1]]}, "method": b_spline(1)}), "/points/xyz/0"),
        (json!({"points": {"x": [0, 1], "y": [0, 1], "xyz": []}, "method": lagrange}), "/points/x"),
    ];
    for (request, pointer) in cases {
        let answer = send(app.post("/v1/curves", request.to_string())).await;
        let problem = answer.problem(422, "invalid_request");
        let pointers: Vec<_> =
            problem["errors"].as_array().unwrap().iter().map(|error| error["pointer"].as_str().unwrap()).collect();
        assert!(pointers.contains(&pointer), "{request}: {pointers:?}, not {pointer}");
    }
    send(app.post("/v1/curves", "{\"points\": [1,")).await.problem(400, "malformed_body");
}
