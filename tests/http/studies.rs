//! The randomisation study over HTTP.

use crate::harness::{Answer, TestApp, send};
use flankfit::api::{examples::REQUEST_EXAMPLES, studies::result::RandomizationResult};
use serde_json::{Value, json};

async fn study(app: &TestApp, request: &Value) -> Answer {
    send(app.post("/v1/studies/randomization", request.to_string())).await
}

fn small() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "study_matrix").unwrap();
    serde_json::from_str(example.text).unwrap()
}

#[tokio::test]
async fn the_documented_examples_are_answered() {
    let app = TestApp::start().await;
    for example in REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == "study_randomization") {
        let request: Value = serde_json::from_str(example.text).unwrap();
        let answer = study(&app, &request).await;
        assert_eq!(answer.status, 200, "{}: {}", example.name, answer.text);
        assert!(!answer.text.contains("null"), "{}", answer.text);
        let body: RandomizationResult = serde_json::from_str(&answer.text).unwrap();
        let json = answer.json();
        assert_eq!(serde_json::to_value(&body).unwrap(), json, "every field of the answer is documented");
        assert_eq!(json["levels"].as_array().unwrap().len(), request["levels"].as_array().unwrap().len());
        assert!(
            body.levels
                .iter()
                .all(|l| l.results.bias_norm_squared.is_some_and(|q| q.q1 <= q.median && q.median <= q.q3))
        );
        let references = &json["references"];
        for name in ["spectral_first_order", "spectral_exact", "ridge"] {
            let choices = references[name]["choices"].as_array().unwrap();
            assert!(choices.len() >= 4, "{name}: {choices:?}");
            let default = choices.iter().find(|choice| choice["criterion"] == "min_mse").unwrap();
            assert_eq!(default["rss"], references[name]["rss"]);
            assert_eq!(default.get("noise_to_signal").is_some(), name != "ridge", "{default}");
        }
        // the plateau is made of levels, the best one among them
        let optimum = body.optimum.unwrap();
        let [low, high] = optimum.plateau;
        assert!(low <= optimum.best.level && optimum.best.level <= high);
        assert!((low..=high).contains(&optimum.least_condition.level));
        assert!(optimum.least_condition.condition_ratio >= optimum.best.condition_ratio);
        assert!(body.coefficient_norm_squared > 0.0 && body.levels.iter().any(|level| level.matrix_b.is_some()));
        assert!(references["least_squares"]["condition"]["median"].as_f64().unwrap() > 1.0);
        // the same study again is the same answer
        assert_eq!(study(&app, &request).await.text, answer.text);
    }
}

#[tokio::test]
async fn nodes_may_replace_the_matrix_and_the_coefficients() {
    let app = TestApp::start().await;
    let nodes = json!({"type": "curve", "x": [1, 2, 3, 4, 5, 6], "y": [1.1, 1.9, 3.2, 3.9, 5.1, 6.0]});
    let rest = json!({"levels": [0.1], "repetitions": 5, "seed": 3});
    let mut request = rest.clone();
    (request["nodes"], request["model"]) = (nodes.clone(), json!({"type": "polynomial", "degree": 1}));
    let body = study(&app, &request).await.json();
    assert_eq!(body["coefficients_source"], "estimate");
    assert_eq!(body["noise_sigma_source"], "estimate");
    assert_eq!(body["terms"], json!(["1", "x"]));
    let mut bare = rest;
    bare["x"] = json!((1..=6).map(|x| [1, x]).collect::<Vec<_>>());
    (bare["coefficients"], bare["noise_sigma"]) = (body["coefficients"].clone(), body["noise_sigma"].clone());
    let same = study(&app, &bare).await.json();
    assert_eq!(same["levels"], body["levels"]);
    assert_eq!(same["coefficients_source"], "request");
}

#[tokio::test]
async fn impossible_studies_are_pointed_at() {
    let app = TestApp::start().await;
    let curve = json!({"type": "curve", "x": [1, 2, 3], "y": [1, 2, 4]});
    let (remove, set) = ("remove", "set");
    for (what, field, value, expected) in [
        (remove, "x", json!(0), "/x"),
        (remove, "coefficients", json!(0), "/coefficients"),
        (remove, "noise_sigma", json!(0), "/noise_sigma"),
        (remove, "levels", json!(0), "/levels"),
        (set, "nodes", curve.clone(), "/nodes"),
        (set, "model", json!({"type": "linear"}), "/model"),
        (set, "x", json!([[1, 2], [3]]), "/x/1"),
        (set, "x", json!([]), "/x"),
        (set, "x", json!([[1, "2"]]), "/x/0/1"),
        (set, "coefficients", json!([1]), "/coefficients"),
        (set, "noise_sigma", json!(-1), "/noise_sigma"),
        (set, "levels", json!([0.1, -0.1]), "/levels/1"),
        (set, "levels", json!([]), "/levels"),
        (set, "repetitions", json!(0), "/repetitions"),
        (set, "repetitions", json!(1_000_000), "/repetitions"),
        (set, "seed", json!(-4), "/seed"),
        (set, "scaling", json!("standardized"), "/scaling"),
        (set, "x", json!([[0, 0], [0, 0], [0, 0]]), "/x"),
        (set, "colour", json!("red"), "/colour"),
    ] {
        let mut request = small();
        if what == remove {
            request.as_object_mut().unwrap().remove(field);
        } else {
            request[field] = value;
        }
        let pointers = study(&app, &request).await.pointers();
        assert_eq!(pointers[0], expected, "{what} {field}: {pointers:?}");
    }
    // errors of nodes and model keep their paths
    let mut request = small();
    request.as_object_mut().unwrap().remove("x");
    request["nodes"] = curve;
    assert_eq!(study(&app, &request).await.pointers(), ["/model"]);
    request["model"] = json!({"type": "polynomial", "degree": 5});
    assert_eq!(study(&app, &request).await.pointers(), ["/model/degree"]);
    request["nodes"]["y"] = json!([1, 2]);
    assert_eq!(study(&app, &request).await.pointers(), ["/nodes/y"]);
    let big: Vec<[f64; 3]> = (0..2000).map(|i| [1.0, f64::from(i), f64::from(i * i)]).collect();
    let request =
        json!({"x": big, "coefficients": [1, 1, 1], "noise_sigma": 1, "levels": vec![0.1; 100], "repetitions": 9999});
    assert_eq!(study(&app, &request).await.pointers(), ["/repetitions"]);
    send(app.post("/v1/studies/randomization", "{")).await.problem(400, "malformed_body");
}

#[tokio::test]
async fn each_number_out_of_range_is_reported_once_with_its_pointer() {
    let app = TestApp::start().await;
    let study_of = |x: Value, coefficients: Value| {
        json!({"x": x, "coefficients": coefficients, "noise_sigma": 1,
        "levels": [0.1], "repetitions": 2})
    };
    let x = json!([[1, 0], [1, 1], [1, 3]]);
    for (request, expected) in [
        (study_of(x.clone(), json!([1e300, 1])), vec!["/coefficients/0"]),
        (study_of(x.clone(), json!([1e300, -1e200])), vec!["/coefficients/0", "/coefficients/1"]),
        (study_of(json!([[1e300, 0], [1e300, 1e-300], [1e300, 0]]), json!([1, 1])), vec!["/x"]),
        (study_of(json!([[1e300, 0], [1, 1], [2, 0]]), json!([1e300, 1])), vec!["/x", "/coefficients/0"]),
        (study_of(json!([[0, 0], [0, 0]]), json!([1, 1])), vec!["/x"]),
    ] {
        assert_eq!(study(&app, &request).await.pointers(), expected, "{request}");
        let mut unit = request.clone();
        unit["scaling"] = json!("unit_length");
        if expected[0] == "/coefficients/0" {
            assert_eq!(study(&app, &unit).await.pointers(), expected, "{unit}");
        }
    }
    // estimated coefficients are those of the nodes
    let nodes = json!({"type": "curve", "x": [0, 1, 2, 3], "y": [1e144, 2e144, 3e144, 5e144]});
    let request =
        json!({"nodes": nodes, "model": {"type": "polynomial", "degree": 1}, "levels": [0.1], "repetitions": 2});
    assert_eq!(study(&app, &request).await.pointers()[0], "/nodes");
}

#[tokio::test]
async fn without_noise_there_is_no_optimum_with_a_warning() {
    let app = TestApp::start().await;
    let mut request = small();
    request["noise_sigma"] = json!(0);
    let body = study(&app, &request).await.json();
    assert!(body.get("optimum").is_none(), "{body}");
    assert!(body["warnings"].as_array().unwrap().iter().any(|warning| warning["code"] == "no_noise"), "{body}");
    assert_eq!(body["references"]["least_squares"]["bias_norm_squared"]["median"], 0.0);
    request["noise_sigma"] = json!(0.1);
    assert!(study(&app, &request).await.json()["optimum"]["error_ratio"].as_f64().is_some());
}
