//! Estimators of the paper's section 2 over HTTP: what they answer, and what is refused.

use crate::harness::{TestApp, send};
use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

fn request(estimator: Value) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_trimmed").unwrap();
    let mut request: Value = serde_json::from_str(example.text).unwrap();
    request["estimator"] = estimator;
    request["regularization"] = json!({"type": "none"});
    request
}

async fn fitted(app: &TestApp, estimator: Value) -> Value {
    let answer = send(app.post("/v1/fits", request(estimator).to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

#[tokio::test]
async fn additional_estimates_are_returned() {
    let app = TestApp::start().await;
    let huber = |more: Value| {
        let mut estimator = json!({"type": "m_estimator", "loss": "huber"});
        estimator.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        estimator
    };
    let minimax = fitted(&app, huber(json!({"contamination": 0.1}))).await;
    let found = &minimax["robust"]["minimax"];
    assert!((found["k"].as_f64().unwrap() - 1.140_171_145_8).abs() < 1e-9 && found["estimated"] == false, "{found}");
    assert_eq!(minimax["spec"]["estimator"]["contamination"], 0.1);
    assert!(minimax["spec"]["estimator"].get("tuning").is_none(), "{}", minimax["spec"]);
    let tuned = fitted(&app, huber(json!({"tuning": [found["k"]]}))).await;
    assert_eq!(tuned["coefficients"], minimax["coefficients"]);
    assert!(tuned["robust"].get("minimax").is_none());
    let estimated = &fitted(&app, huber(json!({"contamination": "estimate"}))).await["robust"]["minimax"];
    assert!(estimated["estimated"] == true && estimated["contamination"].as_f64().unwrap() > 0.0, "{estimated}");

    let student = |more: Value| json!({"type": "maximum_likelihood", "distribution": "student", "shape": more});
    let given = fitted(&app, student(json!(3))).await;
    let free = json!({"type": "maximum_likelihood", "distribution": "student"});
    let free = fitted(&app, free).await;
    let likelihood = |answer: &Value| answer["robust"]["likelihood"]["log_likelihood"].as_f64().unwrap();
    assert!(likelihood(&free) >= likelihood(&given));
    assert_eq!(given["robust"]["likelihood"]["shape"], 3.0);
    assert!(given["robust"]["likelihood"].get("shape_std_error").is_none());
    // what was found, given, is found again
    let again = fitted(&app, student(free["robust"]["likelihood"]["shape"].clone())).await;
    assert_eq!(again["robust"]["likelihood"]["log_likelihood"], free["robust"]["likelihood"]["log_likelihood"]);
    let laplace = fitted(&app, json!({"type": "maximum_likelihood", "distribution": "laplace"})).await;
    assert!(laplace["robust"]["likelihood"].get("shape").is_none());
    let least = fitted(&app, json!({"type": "least_absolute_deviations"})).await;
    let value = |answer: &Value| answer["coefficients"][1]["value"].as_f64().unwrap();
    assert!((value(&laplace) - value(&least)).abs() < 1e-12);
}

#[tokio::test]
async fn impossible_estimators_are_pointed_at() {
    let app = TestApp::start().await;
    let huber = |more: Value| {
        let mut estimator = json!({"type": "m_estimator", "loss": "huber"});
        estimator.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        estimator
    };
    let l = |more: Value| {
        let mut estimator = json!({"type": "l_estimator"});
        estimator.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        estimator
    };
    let likelihood =
        |name: &str, shape: Value| json!({"type": "maximum_likelihood", "distribution": name, "shape": shape});
    for (estimator, expected) in [
        (huber(json!({"contamination": 0})), "/estimator/contamination"),
        (huber(json!({"contamination": 0.95})), "/estimator/contamination"),
        (huber(json!({"contamination": "guess"})), "/estimator/contamination"),
        (huber(json!({"contamination": 0.1, "tuning": [1.0]})), "/estimator/contamination"),
        (json!({"type": "m_estimator", "loss": "tukey", "contamination": 0.1}), "/estimator/contamination"),
        (l(json!({})), "/estimator/form"),
        (l(json!({"form": "trimmed", "share": 0.5})), "/estimator/share"),
        (l(json!({"form": "winsorized", "share": 0})), "/estimator/share"),
        (l(json!({"form": "trimmed", "quantiles": [0.5]})), "/estimator/quantiles"),
        (l(json!({"form": "quantiles", "quantiles": [0.5]})), "/estimator/weights"),
        (l(json!({"form": "quantiles", "quantiles": [0.5], "weights": [0.9]})), "/estimator/weights"),
        (l(json!({"form": "quantiles", "quantiles": [0.5], "weights": [0.5, 0.5]})), "/estimator/weights"),
        (l(json!({"form": "quantiles", "quantiles": [0.5, 0.5], "weights": [0.5, 0.5]})), "/estimator/quantiles/1"),
        (l(json!({"form": "quantiles", "quantiles": [1], "weights": [1]})), "/estimator/quantiles/0"),
        (l(json!({"form": "quantiles", "quantiles": [], "weights": [1]})), "/estimator/quantiles"),
        (l(json!({"form": "trimmed", "colour": 1})), "/estimator/colour"),
        (likelihood("student", json!(0.1)), "/estimator/shape"),
        (likelihood("generalized_normal", json!(9)), "/estimator/shape"),
        (likelihood("generalized_normal", json!(0.9)), "/estimator/shape"),
        (likelihood("laplace", json!(1)), "/estimator/shape"),
        (likelihood("cauchy", json!(1)), "/estimator/distribution"),
    ] {
        let answer = send(app.post("/v1/fits", request(estimator.clone()).to_string())).await;
        assert_eq!(answer.pointers(), [expected], "{estimator}");
    }
}

/// Nearly dependent terms, their sum that is determined, and B as a product.
#[tokio::test]
async fn sums_of_nearly_dependent_terms_are_returned_on_request() {
    let app = TestApp::start().await;
    let x: Vec<[f64; 2]> = (0..12).map(f64::from).map(|t| [1.0 + t, 1.0 + t + 0.01 * (1.7 * t).sin()]).collect();
    let y: Vec<f64> = (0..12).map(|t| 5.0 * (1.0 + f64::from(t)) + 0.1 * f64::from(t % 3 - 1)).collect();
    let mut request = json!({"nodes": {"type": "matrix", "x": x, "y": y}, "model": {"type": "linear"},
        "include": ["collinearity", "matrix_b"]});
    let answer = send(app.post("/v1/fits", request.to_string())).await.json();
    let sums = answer["estimable"].as_array().unwrap();
    assert_eq!(sums.len(), 1);
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&sums[0]["value"]) - 5.0).abs() < 0.1 && number(&sums[0]["std_error"]) < 0.1, "{sums:?}");
    let [low, high] = [0, 1].map(|at| number(&sums[0]["interval"][at]));
    assert!(low < 5.0 && 5.0 < high);
    assert!(sums[0]["sentence"].as_str().unwrap().contains("cannot be separated"));
    let factors = &answer["matrix_b_factors"];
    assert_eq!(factors["products"][0]["q"].as_array().unwrap().len(), 12);
    assert_eq!(factors["products"][0]["s"].as_array().unwrap().len(), 2);
    assert!(number(&factors["mixed_eigenvalue"]) <= number(&factors["mixed_eigenvalue_bound"]) * (1.0 + 1e-12));
    request.as_object_mut().unwrap().remove("include");
    let lean = send(app.post("/v1/fits", request.to_string())).await.json();
    assert!(lean.get("estimable").is_none() && lean.get("matrix_b_factors").is_none());
}
