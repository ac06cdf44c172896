//! Fits that succeed.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{CURVE, TestApp};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value}")).iter().map(|number| number.as_f64().unwrap()).collect()
}

#[tokio::test]
async fn the_documented_examples_are_answered() {
    let app = TestApp::start().await;
    for example in REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == "create_fit") {
        let answer = app.fit(example.text).await;
        assert_eq!(answer.status, 200, "{}: {}", example.name, answer.text);
        assert_eq!(answer.header("content-type"), "application/json");
        assert!(!answer.text.contains("null"), "{}: {}", example.name, answer.text);
        let body = answer.json();
        let coefficients = body["coefficients"].as_array().unwrap();
        let n = coefficients.len();
        assert_eq!(numbers(&body["spectrum"]["eigenvalues"]).len(), n);
        assert!(numbers(&body["spectrum"]["eigenvalues"]).is_sorted());
        assert_eq!(numbers(&body["regularization"]["filter_factors"]).len(), n, "{}", example.name);
        for coefficient in coefficients {
            let keys = ["powers", "index", "column"].iter().filter(|key| coefficient.get(key).is_some()).count();
            assert_eq!(keys, 1, "{coefficient}");
        }
        let choices = body["regularization"]["choices"].as_array().unwrap();
        assert!(choices.iter().any(|choice| choice["criterion"] == "least_squares"), "{choices:?}");
        assert_eq!(body["provenance"]["engine"], "flankfit 0.1.0");
        assert_eq!(body["provenance"]["input_sha256"].as_str().unwrap().len(), 64);
    }
}

#[tokio::test]
async fn a_straight_line_has_known_coefficients() {
    let app = TestApp::start().await;
    let body = app.fit(CURVE).await.json();
    let value = |i: usize| body["coefficients"][i]["least_squares"].as_f64().unwrap();
    // Σ(x−x̄)(y−ȳ)/Σ(x−x̄)² = 10.2/5 and ȳ − 1.5 · 2.04.
    assert!((value(1) - 2.04).abs() < 1e-14 && (value(0) - 0.99).abs() < 1e-14, "{body}");
    assert_eq!(body["coefficients"][1]["powers"], serde_json::json!([1]));
    assert_eq!(body["coefficients"][1]["term"], "x");
    assert_eq!(body["domain"], serde_json::json!({"u": [0.0, 3.0]}));
    assert_eq!(body["residuals"]["count"], 4);
    assert!(body["residuals"].get("values").is_none());
}

#[tokio::test]
async fn includes_are_returned() {
    let app = TestApp::start().await;
    let grid = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_grid").unwrap();
    let body = app.fit(grid.text).await.json();
    let (values, indices) = (&body["residuals"]["values"], &body["residuals"]["node_indices"]);
    assert_eq!((values.as_array().unwrap().len(), indices.as_array().unwrap().len()), (18, 18));
    assert!(!indices.as_array().unwrap().contains(&serde_json::json!(10)));
    assert!(!body["lambda_curve"].as_array().unwrap().is_empty());
    assert!(body["perturbation"]["least_squares"].is_object());
    assert!(body.get("matrix_b").is_none());
    let mut request: Value = serde_json::from_str(grid.text).unwrap();
    request["include"] = serde_json::json!(["matrix_b"]);
    let body = app.fit(&request.to_string()).await.json();
    assert_eq!(body["matrix_b"].as_array().unwrap().len(), 18);
    assert!(body.get("lambda_curve").is_none());
}

#[tokio::test]
async fn the_same_request_gives_the_same_answer_however_it_is_written() {
    let app = TestApp::start().await;
    let spread = r#" {"model":{"degree":1,"type":"polynomial","terms":"tensor"},"scaling":"unit_length",
        "nodes":{"y":[1.0,31e-1,4.90,7.2],"x":[-0,1,2e0,3],"type":"curve"}} "#;
    assert_eq!(app.fit(CURVE).await.text, app.fit(spread).await.text);
}

#[tokio::test]
async fn a_fixed_lambda_star_is_taken_as_it_is() {
    let app = TestApp::start().await;
    let text = CURVE.replacen(
        '{',
        r#"{"regularization":{"type":"ridge","parameter":{"criterion":"fixed","value":0.125}},"#,
        1,
    );
    let body = app.fit(&text).await.json();
    let regularization = &body["regularization"];
    assert_eq!(regularization["type"], "ridge");
    assert_eq!(regularization["criterion"], "fixed");
    assert_eq!(regularization["lambda_star"], 0.125);
    assert!(regularization.get("scheme").is_none());
}

/// Heights that swing about a line, each close to its neighbours.
#[tokio::test]
async fn correlated_residuals_are_warned_of() {
    let app = TestApp::start().await;
    let x: Vec<f64> = (0..40).map(f64::from).collect();
    let request = |y: Vec<f64>| {
        let model = json!({"type": "polynomial", "degree": 1});
        json!({"nodes": {"type": "curve", "x": x, "y": y}, "model": model}).to_string()
    };
    let smooth = x.iter().map(|x| 0.3 * x + (0.4 * x).sin()).collect();
    let body = app.fit(&request(smooth)).await.json();
    let warning = body["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "correlated_residuals").unwrap();
    assert!(warning["message"].as_str().unwrap().contains("along order"), "{warning}");
    // of so many nodes the probability is less than any double
    let of_many: Vec<f64> = (0..6000).map(f64::from).collect();
    let y: Vec<f64> = of_many.iter().map(|x| (0.01 * x).sin()).collect();
    let many = json!({"nodes": {"type": "curve", "x": of_many, "y": y}, "model": {"type": "polynomial", "degree": 1}});
    let body = app.fit(&many.to_string()).await.json();
    let many = body["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "correlated_residuals").unwrap();
    assert!(many["message"].as_str().unwrap().contains("a probability of less than 1e-300"), "{many}");
    let alternating = x.iter().map(|x| 0.3 * x + (2.9 * x).sin()).collect();
    let body = app.fit(&request(alternating)).await.json();
    assert_eq!(body["warnings"], json!([]));
}
