//! Every kind of regularisation over HTTP: results, refusals by pointer, storing and replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example(name: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap_or_else(|| panic!("{name}"));
    serde_json::from_str(example.text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[tokio::test]
async fn each_kind_reports_its_choice() {
    let app = TestApp::start().await;
    let answer = async |name: &str| app.fit(&example(name).to_string()).await.json();

    let ridge = answer("fit_ridge_trace").await;
    let trace = ridge["ridge_trace"].as_array().unwrap();
    assert_eq!(trace[0]["k"], 0.0);
    let k = &ridge["regularization"]["lambda_star"];
    let there = trace.iter().find(|point| &point["k"] == k).unwrap();
    for (i, coefficient) in ridge["coefficients"].as_array().unwrap().iter().enumerate() {
        assert_eq!(coefficient["value"], there["coefficients"][i]);
        assert_eq!(coefficient["least_squares"], trace[0]["coefficients"][i]);
    }
    let criteria: Vec<&str> = ridge["regularization"]["choices"]
        .as_array()
        .unwrap()
        .iter()
        .map(|choice| choice["criterion"].as_str().unwrap())
        .collect();
    assert_eq!(
        criteria,
        ["least_squares", "min_mse", "gcv", "discrepancy", "l_curve", "hkb", "hkb_1975", "lawless_wang"]
    );

    let tikhonov = answer("fit_tikhonov").await;
    assert_eq!(tikhonov["regularization"]["type"], "tikhonov");
    assert_eq!(tikhonov["regularization"]["criterion"], "gcv");
    let criteria: Vec<&Value> =
        tikhonov["regularization"]["choices"].as_array().unwrap().iter().map(|choice| &choice["criterion"]).collect();
    assert_eq!(criteria, ["least_squares", "min_mse", "min_condition", "gcv", "discrepancy", "l_curve"]);
    assert_eq!(tikhonov["lambda_curve"].as_array().unwrap().len(), 61);
    let free = tikhonov["regularization"]["filter_factors"].as_array().unwrap();
    assert_eq!(free.iter().filter(|factor| **factor == 1.0).count(), 4, "1, u, v and uv do not bend: {free:?}");

    let truncated = answer("fit_truncated_svd").await;
    assert_eq!(truncated["regularization"]["rank"], 3);
    assert_eq!(truncated["regularization"]["filter_factors"], json!([0.0, 1.0, 1.0, 1.0]));
    assert_eq!(truncated["spectrum"]["regularized"]["eigenvalues"][0], 0.0);
    assert!(truncated["spectrum"]["regularized"].get("log10_determinant").is_none());
    let eigenvalues = &truncated["spectrum"]["eigenvalues"];
    let kept = number(&eigenvalues[3]) / number(&eigenvalues[1]);
    assert!((number(&truncated["spectrum"]["regularized"]["condition"]) / kept - 1.0).abs() < 1e-12);

    let stein = answer("fit_james_stein").await;
    let factor = number(&stein["regularization"]["shrinkage_factor"]);
    assert!((0.0..1.0).contains(&factor) && stein["regularization"].get("lambda_star").is_none());
    let coefficient = &stein["coefficients"][1];
    let shrunk = number(&coefficient["value"]) / number(&coefficient["least_squares"]);
    assert!((shrunk - factor).abs() < 1e-12, "the slope is shrunk, the mean is not");

    let attracted = answer("fit_attraction").await;
    let target = example("fit_attraction")["regularization"]["target"].clone();
    let factor = number(&attracted["regularization"]["shrinkage_factor"]);
    let k = number(&attracted["regularization"]["lambda_star"]);
    assert!((factor * (1.0 + k) - 1.0).abs() < 1e-14);
    for (i, coefficient) in attracted["coefficients"].as_array().unwrap().iter().enumerate() {
        let (t, a) = (number(&target[i]), number(&coefficient["least_squares"]));
        assert!((number(&coefficient["value"]) - t - factor * (a - t)).abs() < 1e-12, "{coefficient}");
    }
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let cases = [
        (json!({"type": "tikhonov", "order": 4}), "/regularization/order"),
        (json!({"type": "tikhonov"}), "/regularization/order"),
        (json!({"type": "tikhonov", "order": 1, "weights": [1, 1]}), "/regularization/weights"),
        (json!({"type": "tikhonov", "order": 1, "weights": [-1]}), "/regularization/weights/0"),
        (json!({"type": "tikhonov", "order": 1, "weights": [0]}), "/regularization/weights"),
        (
            json!({"type": "tikhonov", "order": 1, "parameter": {"criterion": "hkb"}}),
            "/regularization/parameter/criterion",
        ),
        (
            json!({"type": "tikhonov", "order": 1, "parameter": {"criterion": "fixed", "value": 0}}),
            "/regularization/parameter/value",
        ),
        (json!({"type": "truncated_svd", "rank": 0}), "/regularization/rank"),
        (json!({"type": "truncated_svd", "rank": 6}), "/regularization/rank"),
        (json!({"type": "truncated_svd", "rank": 1.5}), "/regularization/rank"),
        (json!({"type": "truncated_svd"}), "/regularization/rank"),
        (json!({"type": "james_stein", "variant": "stein"}), "/regularization/variant"),
        (
            json!({"type": "james_stein", "variant": "positive_part", "positive_part": false}),
            "/regularization/positive_part",
        ),
        (json!({"type": "james_stein", "target": [1, 2]}), "/regularization/target"),
        (json!({"type": "james_stein", "parameter": {"criterion": "gcv"}}), "/regularization/parameter"),
        (json!({"type": "attraction"}), "/regularization/target"),
        (json!({"type": "attraction", "target": [0, 0, 0, 0, 0, 0]}), "/regularization/target"),
        (
            json!({"type": "attraction", "target": [0, 0, 0, 0, 0], "parameter": {"criterion": "lawless_wang"}}),
            "/regularization/parameter/criterion",
        ),
        (json!({"type": "ridge", "parameter": {"criterion": "optimal"}}), "/regularization/parameter/criterion"),
        (
            json!({"type": "spectral", "lambda_star": {"criterion": "hkb_1975"}}),
            "/regularization/lambda_star/criterion",
        ),
        (json!({"type": "lasso"}), "/regularization/type"),
    ];
    for (regularization, pointer) in cases {
        let mut request = example("fit_james_stein");
        request["regularization"] = regularization.clone();
        let answer = app.fit(&request.to_string()).await;
        assert_eq!(answer.status, 422, "{regularization}: {}", answer.text);
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{regularization}: {}", answer.text);
    }
}

/// Both ways of asking for the positive part are the same request.
#[tokio::test]
async fn two_spellings_have_one_digest() {
    let app = TestApp::start().await;
    let mut digests = Vec::new();
    for regularization in [
        json!({"type": "james_stein"}),
        json!({"type": "james_stein", "positive_part": true}),
        json!({"type": "james_stein", "variant": "positive_part"}),
        json!({"type": "james_stein", "variant": "positive_part", "positive_part": true}),
    ] {
        let mut request = example("fit_james_stein");
        request["regularization"] = regularization;
        digests.push(app.fit(&request.to_string()).await.json()["provenance"]["input_sha256"].clone());
    }
    assert!(digests.windows(2).all(|pair| pair[0] == pair[1]), "{digests:?}");
}

#[tokio::test]
async fn dependent_columns_are_answered_by_a_smaller_rank() {
    let app = TestApp::start().await;
    let request = json!({
        "nodes": {"type": "matrix", "x": [[1, 2, 4], [1, 3, 6], [1, 5, 10], [1, 6, 12], [1, 8, 16]],
            "y": [1, 2, 2, 4, 5]},
        "model": {"type": "linear"},
        "regularization": {"type": "truncated_svd", "rank": 2},
        "include": ["matrix_b", "lambda_curve", "ridge_trace"],
        "node_uncertainty": {"position": 0.001, "height": 0.01}
    });
    let answer = app.fit(&request.to_string()).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let body = answer.json();
    let codes: Vec<&str> =
        body["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect();
    for code in ["rank_deficient", "no_matrix_b", "no_lambda_curve", "no_ridge_trace", "no_regularized_perturbation"] {
        assert!(codes.contains(&code), "{code}: {codes:?}");
    }
    assert_eq!(body["perturbation"]["regularized"], json!({}));
}

/// Stored with a job, the fit is on the trace and comes out of a replay bit by bit.
#[tokio::test]
async fn stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "regularised"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    for name in ["fit_ridge_trace", "fit_tikhonov", "fit_truncated_svd", "fit_james_stein", "fit_attraction"] {
        let stored = send(app.post(&iterations, example(name).to_string())).await;
        assert_eq!(stored.status, 201, "{name}: {}", stored.text);
        let stored = stored.json();
        let mut plain = app.fit(&example(name).to_string()).await.json();
        let spec = plain.as_object_mut().unwrap().remove("spec");
        assert_eq!(Some(&stored["fits"][0]["spec"]), spec.as_ref());
        assert_eq!(stored["fits"][0]["result"], plain, "{name}");
        let path =
            format!("{iterations}/{}/fits/{}/replay", stored["number"], stored["fits"][0]["id"].as_str().unwrap());
        let replay = send(app.post(&path, "")).await;
        assert_eq!(replay.json()["identical"], true, "{name}: {}", replay.text);
    }
    let trace = send(app.get(&format!("/v1/jobs/{}/trace", job["id"].as_str().unwrap()))).await.json();
    let criteria: Vec<&Value> =
        trace["iterations"].as_array().unwrap().iter().map(|iteration| &iteration["fits"][0]["criterion"]).collect();
    assert_eq!(criteria[0], "hkb");
    assert_eq!(criteria[1], "gcv");
    assert_eq!(criteria[4], "optimal");
}
