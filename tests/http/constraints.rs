//! Constraints on the shape over HTTP: a flank that meets them, its proof, refusals with pointers,
//! storing and replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_constrained").unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[tokio::test]
async fn a_flank_meets_its_constraints() {
    let app = TestApp::start().await;
    let fit = app.fit(&example().to_string()).await.json();
    let proof = &fit["constraints"];
    for (k, kind) in ["increasing", "concave"].into_iter().enumerate() {
        let one = &proof["each"][k];
        assert_eq!((&one["kind"], &one["domain"]), (&json!(kind), &json!({"u": [30.0, 34.0], "v": [0.0, 20.0]})));
        assert!(number(&one["least_value"]) >= 0.0 && number(&one["least_squares_least_value"]) < 0.0, "{proof}");
        assert!(number(&one["active"][0]["multiplier"]) > 0.0 && one["active"][0]["v"].is_number(), "{proof}");
    }
    let (rss, bound) = (number(&proof["rss"]), number(&proof["rss_bound"]));
    assert!(bound <= rss && rss - bound < 1e-6 * rss, "{proof}");
    assert!((rss - number(&fit["residuals"]["rss"])).abs() < 1e-9 * rss);
    assert!(rss > number(&fit["residuals"]["least_squares_rss"]));
    assert!(fit["warnings"].to_string().contains("constraints_active"));
    assert_eq!(fit["spec"]["regularization"], json!({"type": "none"}));
    assert_eq!(fit["spec"]["constraints"], example()["constraints"]);
    assert_eq!(fit["coefficients"][0]["interval_kind"], "least_squares");

    // a given limit shortens intervals as without constraints; a tiny one is shown with few digits
    let mut limited = example();
    limited["coefficient_norm_limit"] = json!(1e-300);
    let body = app.fit(&limited.to_string()).await.json();
    assert_eq!(body["coefficients"][0]["interval_kind"], "bias_aware", "{body}");
    let warnings = body["warnings"].as_array().unwrap();
    let below = warnings.iter().find(|w| w["code"] == "norm_limit_contradicted").unwrap();
    let message = below["message"].as_str().unwrap();
    assert!(
        message.starts_with("the nodes contradict coefficient_norm_limit 1e-300: ") && message.len() < 300,
        "{message}"
    );
    assert!(message.contains("bias-aware intervals and bands do not hold"), "{message}");

    // the returned surface meets the constraints everywhere
    let axis = |low: f64, high: f64| (0..=60).map(|k| low + (high - low) * f64::from(k) / 60.0).collect::<Vec<f64>>();
    let grid = json!({"u": axis(30.0, 34.0), "v": axis(0.0, 20.0)});
    let body = json!({"surface": fit["surface"], "grid": grid, "derivatives": 2});
    let found = send(app.post("/v1/surfaces/evaluate", body.to_string())).await;
    assert_eq!(found.status, 200, "{}", found.text);
    let found = found.json();
    let all = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
    let (slopes, bends) = (all(&found["derivatives"]["u"]), all(&found["derivatives"]["vv"]));
    assert_eq!((slopes.len(), bends.len()), (61 * 61, 61 * 61));
    assert!(slopes.iter().all(|slope| *slope >= -1e-13), "{:?}", slopes.iter().copied().fold(0.0, f64::min));
    assert!(bends.iter().all(|bend| *bend <= 1e-13), "{:?}", bends.iter().copied().fold(0.0, f64::max));
}

#[tokio::test]
async fn invalid_constraints_are_refused_with_their_pointer() {
    let app = TestApp::start().await;
    let with = |name: &str, value: Value| {
        let mut body = example();
        body[name] = value;
        body
    };
    let constraints = |value: Value| with("constraints", value);
    let refusals = [
        (constraints(json!([{"kind": "increasing"}])), "/constraints/0/along"),
        (constraints(json!([{"kind": "rising", "along": "u"}])), "/constraints/0/kind"),
        (constraints(json!([{"kind": "increasing", "along": "x"}])), "/constraints/0/along"),
        (constraints(json!([{"kind": "increasing", "along": "u", "where": 1}])), "/constraints/0/where"),
        (constraints(json!([{"along": "u"}])), "/constraints/0/kind"),
        (constraints(json!(vec![json!({"kind": "convex", "along": "u"}); 17])), "/constraints"),
        (constraints(json!([{"kind": "convex", "along": "v", "domain": {"v": [5, 25]}}])), "/constraints/0/domain/v"),
        (constraints(json!([{"kind": "convex", "along": "u"}, {"kind": "concave", "along": "u"}])), "/constraints/1"),
        (with("regularization", json!({"type": "ridge"})), "/regularization"),
        (with("variance", json!("hc3")), "/constraints"),
        (with("estimator", json!({"type": "rank"})), "/estimator"),
        (with("prior", json!({"mean": vec![0; 15], "std_error": vec![1; 15]})), "/constraints"),
        (with("model", json!({"type": "polynomial", "degree": [1, 1]})), "/constraints/1"),
    ];
    for (body, pointer) in refusals {
        let answer = app.fit(&body.to_string()).await;
        assert_eq!(answer.status, 422, "{body}: {}", answer.text);
        let found = answer.json();
        assert_eq!(found["errors"][0]["pointer"], pointer, "{}", answer.text);
    }
    // none at all is as if nothing were said
    let none = app.fit(&constraints(json!([])).to_string()).await.json();
    assert_eq!(none["regularization"]["type"], "spectral");
    assert!(none.get("constraints").is_none() && none["spec"].get("constraints").is_none());
}

#[tokio::test]
async fn a_kept_fit_replays_and_a_stream_takes_none() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "shapes"}).to_string())).await.json();
    let job = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
    let iterations = format!("{job}/iterations");
    let mut plain = example();
    plain.as_object_mut().unwrap().remove("constraints");
    let stored = send(app.post(&iterations, plain.to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let mut refit = example();
    for name in ["nodes", "include"] {
        refit.as_object_mut().unwrap().remove(name);
    }
    let fits = format!("{iterations}/1/fits");
    let stored = send(app.post(&fits, refit.to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let stored = stored.json();
    assert_eq!(stored["spec"]["constraints"], refit["constraints"]);
    assert_eq!(stored["result"]["constraints"]["each"].as_array().unwrap().len(), 2);
    let path = format!("{fits}/{}", stored["id"].as_str().unwrap());
    assert_eq!(send(app.post(&format!("{path}/replay"), "")).await.json()["identical"], true);
    let more = send(app.get(&format!("{path}?include=covariance,shape"))).await.json();
    assert_eq!(more["result"]["constraints"], stored["result"]["constraints"]);
    assert_eq!(more["result"]["surface"]["type"], "b_spline");

    let mut opened = refit;
    opened["domain"] = json!({"u": [30, 34], "v": [0, 20]});
    let stream = send(app.post(&format!("{job}/streams"), opened.to_string())).await;
    assert_eq!(stream.status, 422, "{}", stream.text);
    assert_eq!(stream.json()["errors"][0]["pointer"], "/constraints", "{}", stream.text);
}
