//! Responses in which something does not exist, and their warnings.

use serde_json::{Value, json};

use crate::harness::TestApp;

const ESTIMATORS: [&str; 6] = [
    r#"{"type":"m_estimator","loss":"tukey"}"#,
    r#"{"type":"least_absolute_deviations"}"#,
    r#"{"type":"quantile","tau":0.3}"#,
    r#"{"type":"lp","p":1.5}"#,
    r#"{"type":"least_trimmed_squares"}"#,
    r#"{"type":"rank"}"#,
];

fn has(body: &Value, code: &str) -> bool {
    body["warnings"].as_array().unwrap().iter().any(|warning| warning["code"] == code)
}

async fn fit(app: &TestApp, x: &[f64], y: &[f64], degree: usize, rest: Value) -> Value {
    let mut request = json!({
        "nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": degree},
        "regularization": {"type": "none"}
    });
    for (key, value) in rest.as_object().unwrap() {
        request[key] = value.clone();
    }
    let answer = app.fit(&request.to_string()).await;
    assert_eq!(answer.status, 200, "{request}: {}", answer.text);
    answer.json()
}

/// Scale 0, no τ, no standard errors, and a warning.
fn assert_exact(body: &Value, name: &str) {
    let robust = &body["robust"];
    assert!(has(body, "exact_fit"), "{name}: {}", body["warnings"]);
    assert_eq!(robust["scale"], 0.0, "{name}: {robust}");
    assert!(robust.get("dispersion").is_none(), "{name}: {robust}");
    assert!(body["coefficients"].as_array().unwrap().iter().all(|c| c.get("std_error").is_none()), "{name}: {body}");
}

#[tokio::test]
async fn no_estimator_takes_rounding_for_a_scale() {
    let app = TestApp::start().await;
    let x: Vec<f64> = (0..12).map(|i| 0.37 * f64::from(i) + 0.1).collect();
    let on: Vec<f64> = x.iter().map(|x| 0.3 + 1.7 * x - 0.013 * x * x).collect();
    let mut most = on.clone();
    (most[2], most[7]) = (5.0, -4.0);
    for text in ESTIMATORS {
        let estimator =
            json!({"estimator": serde_json::from_str::<Value>(text).unwrap(), "include": ["robust_weights"]});
        assert_exact(&fit(&app, &x, &on, 2, estimator.clone()).await, text);
        if !text.contains("trimmed") {
            assert_exact(&fit(&app, &x[..3], &[1.1, 2.3, 2.9], 2, estimator.clone()).await, text);
        }
        // gross errors do not hide that the rest is exact from those that reject them
        if text.contains("m_estimator") || text.contains("trimmed") {
            let body = fit(&app, &x, &most, 2, estimator.clone()).await;
            assert_exact(&body, text);
            let weights = body["robust"]["weights"].as_array().unwrap();
            assert!(weights[2] == 0.0 && weights[7] == 0.0 && weights[1] == 1.0, "{text}: {weights:?}");
        }
        // noise is noise, however small its unit
        let small: Vec<f64> = on.iter().zip(&x).map(|(y, x)| 1e-9 * (y + 1e-3 * (37.0 * x).sin())).collect();
        let body = fit(&app, &x, &small, 2, estimator).await;
        assert!(!has(&body, "exact_fit") && body["robust"]["scale"].as_f64().unwrap() > 1e-14, "{text}: {body}");
    }
}

#[tokio::test]
async fn an_undetermined_scale_is_omitted() {
    let app = TestApp::start().await;
    let estimator = |name: &str| json!({"estimator": {"type": name}});
    for name in ["least_absolute_deviations", "rank"] {
        let body = fit(&app, &[0.0, 1.0, 2.0, 3.0], &[1.0, 2.0, 2.5, 9.0], 2, estimator(name)).await;
        assert!(has(&body, "no_scale"), "{name}: {}", body["warnings"]);
        assert!(body["robust"].get("scale").is_none() && body["robust"].get("dispersion").is_none(), "{name}");
    }
}

#[tokio::test]
async fn heights_of_0_have_no_relative_error_with_a_warning() {
    let app = TestApp::start().await;
    let x = [0.0, 1.0, 2.0, 3.0];
    let uncertain = json!({"node_uncertainty": {"position": 0.01, "height": 0.01}});
    let body = fit(&app, &x, &[0.0; 4], 1, uncertain.clone()).await;
    assert_eq!(body["perturbation"]["least_squares"], json!({}));
    assert!(has(&body, "no_relative_error") && !has(&body, "perturbation_unbounded"), "{}", body["warnings"]);
    let body = fit(&app, &x, &[0.0, 1.0, 2.0, 3.5], 1, uncertain).await;
    assert!(!has(&body, "no_relative_error") && body["perturbation"]["least_squares"].get("square_bound").is_some());
}

#[tokio::test]
async fn a_variant_of_james_stein_goes_with_the_positive_part_but_not_against_itself() {
    let app = TestApp::start().await;
    let x: Vec<f64> = (0..9).map(f64::from).collect();
    let y = [0.5, -1.0, 0.3, 0.9, -0.7, 0.2, -0.4, 1.1, -0.6];
    let with = |variant: &str, positive: bool| {
        json!({"regularization": {"type": "james_stein", "variant": variant,
        "positive_part": positive}})
    };
    for variant in ["efron_morris", "hoerl_kennard"] {
        let factor = async |positive: bool| {
            let body = fit(&app, &x, &y, 4, with(variant, positive)).await;
            body["regularization"]["shrinkage_factor"].as_f64().unwrap()
        };
        let plain = factor(false).await;
        assert!(plain < 0.0, "{variant}: {plain} would not be cut");
        assert_eq!(factor(true).await, 0.0, "{variant}");
    }
    let mut request = json!({
        "nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 4}
    });
    request["regularization"] = with("positive_part", false)["regularization"].clone();
    assert_eq!(app.fit(&request.to_string()).await.pointers(), ["/regularization/positive_part"]);
}
