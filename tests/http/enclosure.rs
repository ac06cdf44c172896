//! Proved intervals over HTTP: results, reasons, storing.

use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn thirds() -> Value {
    json!({
        "nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [1, 0, 0, 0.1]},
        "model": {"type": "polynomial", "degree": 1, "basis": "monomial"},
        "regularization": {"type": "none"}, "include": ["enclosure"]
    })
}

/// True for a short interval that the answer lies in, up to the rounding of standard errors.
fn holds(ends: &Value, value: f64) -> bool {
    let end = |k: usize| ends[k].as_f64().unwrap_or_else(|| panic!("{ends}"));
    end(0) <= value + 1e-14 && value - 1e-14 <= end(1) && end(1) - end(0) <= 1e-15
}

#[tokio::test]
async fn intervals_hold_the_answer_and_are_short() {
    let app = TestApp::start().await;
    let body = app.fit(&thirds().to_string()).await.json();
    let found = &body["numerics"]["enclosure"];
    for k in 0..2 {
        let one = &body["coefficients"][k];
        assert!(holds(&found["coefficients"][k], one["least_squares"].as_f64().unwrap()), "{found}");
        assert!(holds(&found["std_errors"][k], one["least_squares_std_error"].as_f64().unwrap()), "{found}");
    }
    assert!(holds(&found["rss"], body["residuals"]["least_squares_rss"].as_f64().unwrap()), "{found}");

    let mut plain = thirds();
    plain["include"] = json!([]);
    assert!(app.fit(&plain.to_string()).await.json()["numerics"].get("enclosure").is_none());

    let mut robust = thirds();
    robust["estimator"] = json!({"type": "least_absolute_deviations"});
    let body = app.fit(&robust.to_string()).await.json();
    let warnings = body["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|one| one["code"] == "no_enclosure").unwrap_or_else(|| panic!("{body}"));
    assert_eq!(warning["params"], json!({"reason": "other_fit"}));
    assert!(body["numerics"].get("enclosure").is_none());
}

/// A stored fit is returned with intervals that were not asked for at first.
#[tokio::test]
async fn a_stored_fit_has_them_on_request() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "enclosure"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let mut plain = thirds();
    plain["include"] = json!([]);
    let stored = send(app.post(&iterations, plain.to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    let fit = format!("{iterations}/{}/fits/{}", stored["number"], stored["fits"][0]["id"].as_str().unwrap());
    let found = send(app.get(&format!("{fit}?include=enclosure"))).await.json();
    assert_eq!(found["result"]["numerics"]["enclosure"]["coefficients"].as_array().unwrap().len(), 2, "{found}");
}
