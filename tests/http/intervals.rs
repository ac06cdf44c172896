//! Intervals, covariances and predictions over HTTP: results, refusals by pointer, storing and
//! replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_predict").unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value}")).iter().map(number).collect()
}

#[tokio::test]
async fn each_interval_has_its_kind() {
    let app = TestApp::start().await;
    let body = app.fit(&example().to_string()).await.json();
    for c in body["coefficients"].as_array().unwrap() {
        let [low, high] = numbers(&c["interval"])[..] else { panic!("{c}") };
        let student = numbers(&c["least_squares_interval"]);
        assert_eq!(c["interval_kind"], "bias_aware");
        assert!(low < high && high - low < student[1] - student[0]);
        let gain = number(&c["interval_gain"]);
        assert!((gain - (high - low) / (student[1] - student[0])).abs() < 1e-9 && gain < 1.0);
        // t(0.995; 21) of tables
        let half = 2.831_359_6 * number(&c["least_squares_std_error"]);
        assert!((student[1] - number(&c["least_squares"]) - half).abs() < 1e-6 * half, "{c}");
    }
    let mut unlimited = example();
    unlimited.as_object_mut().unwrap().remove("coefficient_norm_limit");
    for (regularization, kind) in [("none", "student"), ("spectral", "least_squares")] {
        unlimited["regularization"] = json!({"type": regularization});
        let body = app.fit(&unlimited.to_string()).await.json();
        for c in body["coefficients"].as_array().unwrap() {
            assert_eq!(c["interval_kind"], kind);
            assert!(c.get("interval_gain").is_none() && c.get("least_squares_interval").is_none());
        }
    }
}

#[tokio::test]
async fn predictions_are_there_for_every_place() {
    let app = TestApp::start().await;
    let body = app.fit(&example().to_string()).await.json();
    let found = &body["predictions"];
    assert_eq!(found["level"], 0.95);
    let (value, error) = (numbers(&found["value"]), numbers(&found["std_error"]));
    // the sum of the coefficients at u = 34, v = 0
    let coefficient = |j: usize| number(&body["coefficients"][j]["value"]);
    assert!((value[4] - (coefficient(0) + 34.0 * coefficient(2))).abs() < 1e-9, "{body}");
    // λ* is selected from the nodes: the valid standard error is that of least squares, the
    // conditional one is smaller
    let variance = |of: &str| {
        let covariance = |i: usize, j: usize| number(&body["covariance"][of][i][j]);
        covariance(0, 0) + 68.0 * covariance(2, 0) + 34.0 * 34.0 * covariance(2, 2)
    };
    assert!((error[4] - variance("least_squares").sqrt()).abs() < 1e-7 * error[4]);
    assert!(variance("coefficients") < variance("least_squares"));
    for (j, coefficient) in body["coefficients"].as_array().unwrap().iter().enumerate() {
        for (of, name) in [("least_squares", "std_error"), ("coefficients", "conditional_std_error")] {
            let (error, own) = (number(&coefficient[name]), number(&body["covariance"][of][j][j]).sqrt());
            assert!((error - own).abs() < 1e-7 * own, "{name} {coefficient}");
        }
    }
    for kind in ["confidence", "prediction", "simultaneous"] {
        let band: Vec<Vec<f64>> = found[kind].as_array().unwrap().iter().map(numbers).collect();
        assert_eq!(band.len(), 6);
        assert!(band.iter().all(|ends| ends[0] < ends[1]));
    }
    let width = |kind: &str, k: usize| number(&found[kind][k][1]) - number(&found[kind][k][0]);
    for k in 0..6 {
        assert!(width("confidence", k) < width("simultaneous", k) && width("confidence", k) < width("prediction", k));
    }
    assert!(number(&found["simultaneous_factor"]) <= number(&found["scheffe"]));
    assert!(["scheffe", "tube"].contains(&found["simultaneous_method"].as_str().unwrap()));
    let slope = numbers(&found["slope_u"]["value"]);
    assert!(
        (slope[0] - coefficient(2)).abs() < 1e-10 && (slope[1] - coefficient(2) - 20.0 * coefficient(3)).abs() < 1e-9
    );
    assert_eq!(numbers(&found["slope_v"]["std_error"]).len(), 6);
    assert!(!body["warnings"].to_string().contains("outside_domain"));

    let mut far = example();
    far["predict"]["at"] = json!({"u": [30.0, 40.0], "v": [0.0, 5.0]});
    far["predict"]["kinds"] = json!([]);
    let body = app.fit(&far.to_string()).await.json();
    assert!(body["warnings"].to_string().contains("outside_domain"), "{}", body["warnings"]);
    assert!(body["predictions"].get("confidence").is_none() && body["predictions"].get("simultaneous").is_none());
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let of = async |change: fn(&mut Value)| {
        let mut request = example();
        change(&mut request);
        let answer = app.fit(&request.to_string()).await;
        answer.problem(422, "invalid_request");
        answer.pointers()
    };
    assert_eq!(of(|r| r["level"] = json!(1.0)).await, ["/level"]);
    assert_eq!(of(|r| r["level"] = json!(0.5)).await, ["/level"]);
    assert_eq!(of(|r| r["predict"]["level"] = json!(95)).await, ["/predict/level"]);
    assert_eq!(of(|r| r["predict"]["at"] = json!({"x": [1.0]})).await, ["/predict/at"]);
    assert_eq!(of(|r| r["predict"]["at"] = json!({"u": [31.0, 32.0], "v": [1.0]})).await, ["/predict/at"]);
    assert_eq!(of(|r| r["predict"]["at"] = json!({"u": [], "v": []})).await, ["/predict/at/u", "/predict/at/v"]);
    assert_eq!(of(|r| r["predict"]["at"] = json!({})).await, ["/predict/at"]);
    assert_eq!(of(|r| r["predict"]["at"]["grid"]["u"][1] = json!("a")).await, ["/predict/at/grid/u/1"]);
    assert_eq!(of(|r| r["predict"]["kinds"] = json!(["tolerance"])).await, ["/predict/kinds/0"]);
    assert_eq!(of(|r| r["predict"]["where"] = json!(1)).await, ["/predict/where"]);
    let many: Vec<f64> = (0..4000).map(f64::from).collect();
    let answer = {
        let mut request = example();
        request["predict"]["at"] = json!({"grid": {"u": many, "v": many}});
        app.fit(&request.to_string()).await
    };
    answer.problem(422, "invalid_request");
    assert_eq!(answer.pointers(), ["/predict/at"]);
    let matrix = json!({
        "nodes": {"type": "matrix", "x": [[1, 0], [1, 1], [1, 2]], "y": [0, 1, 2.5]},
        "model": {"type": "linear"}, "predict": {"at": {"x": [1]}}
    });
    assert_eq!(app.fit(&matrix.to_string()).await.pointers(), ["/predict/at"]);
    let of_rows = async |predict: Value| {
        let mut request = matrix.clone();
        request["predict"] = predict;
        let answer = app.fit(&request.to_string()).await;
        answer.problem(422, "invalid_request");
        answer.pointers()
    };
    assert_eq!(of_rows(json!({"at": {"x": [[1, 0], [1]]}})).await, ["/predict/at/x/1"]);
    assert_eq!(of_rows(json!({"at": {"x": [[1, 0], [1, "a"]]}})).await, ["/predict/at/x/1/1"]);
    assert_eq!(of_rows(json!({"at": {"x": [[1, 0], 1]}})).await, ["/predict/at/x/1"]);
    assert_eq!(of_rows(json!({"at": {"x": [[1, 0]]}, "slopes": true})).await, ["/predict/slopes"]);
    assert_eq!(of_rows(json!({"at": {"x": []}})).await, ["/predict/at/x"]);
    let mut curve = example();
    curve["predict"]["at"] = json!({"x": [[1, 0, 0, 0, 0, 0, 0, 0, 0]]});
    assert_eq!(app.fit(&curve.to_string()).await.pointers(), ["/predict/at"]);
}

/// A fit has at most 600 coefficients, so that a covariance matrix has at most 180,300 numbers.
#[tokio::test]
async fn covariances_are_of_600_coefficients_at_most() {
    let app = TestApp::start().await;
    let axis: Vec<f64> = (0..26).map(|k| f64::from(k) / 25.0).collect();
    let height = |k: usize| ((k * 7919) % 101) as f64 / 101.0;
    let heights: Vec<Vec<f64>> = (0..26).map(|i| (26 * i..26 * i + 26).map(height).collect()).collect();
    let request = |degree: usize| {
        json!({
            "nodes": {"type": "grid", "u": axis, "v": axis, "z": heights},
            "model": {"type": "polynomial", "degree": degree, "basis": "chebyshev"},
            "regularization": {"type": "none"},
            "include": ["covariance"]
        })
        .to_string()
    };
    let body = app.fit(&request(6)).await.json();
    for of in ["coefficients", "least_squares"] {
        let rows = body["covariance"][of].as_array().unwrap();
        let lengths: Vec<usize> = rows.iter().map(|row| row.as_array().unwrap().len()).collect();
        assert_eq!(lengths, (1..=49).collect::<Vec<usize>>());
    }
    let refused = app.fit(&request(24)).await;
    refused.problem(422, "invalid_request");
    assert_eq!(refused.pointers(), ["/model/degree"]);
    let message = "a fit has at most 600 coefficients, this model has 625: use fewer";
    assert!(refused.text.contains(message), "{}", refused.text);
}

#[tokio::test]
async fn rows_of_a_linear_model_are_predicted() {
    let app = TestApp::start().await;
    let request = json!({
        "nodes": {"type": "matrix", "x": [[1, 0], [1, 1], [1, 2], [1, 3]], "y": [0, 1, 2.5, 2.5]},
        "model": {"type": "linear"}, "regularization": {"type": "none"},
        "include": ["intervals", "covariance"],
        "predict": {"at": {"x": [[1, 1.5], [0, 1]]}, "kinds": ["confidence", "simultaneous"]}
    });
    let body = app.fit(&request.to_string()).await.json();
    // parts of every response are not in the spec
    assert_eq!(body["spec"]["include"], json!(["covariance"]));
    let found = &body["predictions"];
    assert!((number(&found["value"][0]) - 1.5).abs() < 1e-12);
    // the second row is the slope, that is the second coefficient
    let slope = &body["coefficients"][1];
    for k in 0..2 {
        assert!((number(&found["confidence"][1][k]) - number(&slope["interval"][k])).abs() < 1e-9);
    }
    // the middle of the nodes: σ / √4 and t(0.975; 2) = 4.302653
    let half = 4.302_652_73 * number(&body["residuals"]["sigma"]) / 2.0;
    assert!((number(&found["confidence"][0][1]) - 1.5 - half).abs() < 1e-6);
    // for two rows t(0.9875; 2) = 6.205347 is more than Scheffé's √(2 · 19)
    assert_eq!(found["simultaneous_method"], "scheffe");
    assert!((number(&found["scheffe"]) - 38f64.sqrt()).abs() < 1e-9);
    let mut one = request.clone();
    one["predict"]["at"] = json!({"x": [[1, 1.5]]});
    let found = &app.fit(&one.to_string()).await.json()["predictions"];
    assert_eq!(found["simultaneous_method"], "bonferroni");
    assert!((number(&found["simultaneous_factor"]) - 4.302_652_73).abs() < 1e-7);
}

#[tokio::test]
async fn the_source_of_the_norm_limit_is_reported() {
    let app = TestApp::start().await;
    let mut request = example();
    let body = app.fit(&request.to_string()).await.json();
    assert_eq!(body["bias"]["coefficient_norm_limit_source"], "request");
    assert!(body["bias"].get("upper_confidence").is_none());
    request.as_object_mut().unwrap().remove("coefficient_norm_limit");
    let body = app.fit(&request.to_string()).await.json();
    assert_eq!(body["bias"]["coefficient_norm_limit_source"], "estimate");
    assert!(number(&body["bias"]["upper_confidence"]) > number(&body["bias"]["coefficient_norm_limit"]));
}

#[tokio::test]
async fn stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "intervals"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let stored = send(app.post(&iterations, example().to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    let fit = &stored["fits"][0];
    assert_eq!(fit["spec"]["predict"], example()["predict"]);
    assert_eq!(fit["spec"]["level"], 0.99);
    assert!(fit["result"]["predictions"]["simultaneous"].is_array());
    let path = format!("{iterations}/{}/fits/{}/replay", stored["number"], fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&path, "")).await.json()["identical"], true);
}
