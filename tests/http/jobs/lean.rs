//! Short responses: parts that grow with the nodes or with the square of the coefficients come only
//! on request, which changes nothing else.

use std::collections::BTreeMap;

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Map, Value, json};

use super::app::{TestApp, iteration};

const SHORT: usize = 16 << 10;
const FIT: [&str; 11] = [
    "residuals",
    "fitted",
    "collinearity",
    "lambda_curve",
    "matrix_b",
    "ridge_trace",
    "robust_weights",
    "peaks",
    "covariance",
    "influence",
    "predicted_mse",
];

fn examples(operation: &str) -> Vec<(&'static str, Value)> {
    REQUEST_EXAMPLES
        .iter()
        .filter(|example| example.operation_id == operation)
        .map(|example| (example.name, serde_json::from_str(example.text).unwrap()))
        .collect()
}

fn without_include(body: &Value) -> Value {
    let mut body = body.clone();
    body.as_object_mut().unwrap().remove("include");
    body
}

/// The members of an object with the text of each.
fn members(text: &str) -> BTreeMap<String, Box<serde_json::value::RawValue>> {
    serde_json::from_str(text).unwrap()
}

/// Everything in `short` is in `long` with the same bytes; objects and lists of objects may have
/// more members there.
#[track_caller]
fn only_added(short: &str, long: &str, at: &str) {
    if short.starts_with('{') {
        let long = members(long);
        for (key, value) in members(short) {
            let at = format!("{at}/{key}");
            // a requested part is in the response, and may have more in it too
            let other = long.get(&key).unwrap_or_else(|| panic!("{at} is gone"));
            if key == "warnings" {
                // there may be one more: that there is nothing of that name to add
                let list = |text: &str| serde_json::from_str::<Vec<Value>>(text).unwrap();
                let (short, long) = (list(value.get()), list(other.get()));
                assert!(short.iter().all(|warning| long.contains(warning)), "{at}");
                continue;
            }
            only_added(value.get(), other.get(), &at);
        }
    } else if short.starts_with("[{") {
        let list = |text: &str| serde_json::from_str::<Vec<Box<serde_json::value::RawValue>>>(text).unwrap();
        let (short, long) = (list(short), list(long));
        assert_eq!(short.len(), long.len(), "{at}");
        for (k, (short, long)) in short.iter().zip(&long).enumerate() {
            only_added(short.get(), long.get(), &format!("{at}/{k}"));
        }
    } else {
        assert_eq!(short, long, "{at}");
    }
}

/// Without what changes from one request to the next.
fn lasting(text: &str) -> String {
    let mut body: Map<String, Value> = serde_json::from_str(text).unwrap();
    for key in ["id", "number", "created_at"] {
        body.remove(key);
    }
    if let Some(fits) = body.get_mut("fits").and_then(Value::as_array_mut) {
        for fit in fits {
            fit.as_object_mut().unwrap().retain(|key, _| key != "id" && key != "created_at");
        }
    }
    Value::Object(body).to_string()
}

#[tokio::test]
async fn responses_are_short_and_include_only_adds() {
    let mut app = TestApp::start().await;
    let gear = examples("create_job")[0].1.clone();
    let job = app.post("/v1/jobs", &gear).await.expect(201).header("location").unwrap().to_owned();
    let place = app.post(&format!("{job}/iterations"), &examples("create_iteration")[0].1).await.expect(201);
    let place = place.header("location").unwrap().to_owned();
    let correction = ["nodes", "result", "residuals", "collinearity", "lambda_curve", "matrix_b", "ridge_trace"];
    let mut seen = 0;
    for (operation, path, status, names) in [
        ("create_fit", "/v1/fits".to_owned(), 200, &FIT[..]),
        ("create_iteration", format!("{job}/iterations"), 201, &FIT[..]),
        ("create_iteration_fit", format!("{place}/fits"), 201, &FIT[..]),
        ("preview_iteration_fit", format!("{place}/preview"), 200, &FIT[..]),
        ("create_iteration_correction", format!("{place}/correction"), 201, &correction[..]),
    ] {
        for (name, body) in examples(operation) {
            let lean = without_include(&body);
            let short = app.post(&path, &lean).await.expect(status);
            assert!(short.text.len() <= SHORT, "{operation} {name}: {} bytes", short.text.len());
            for include in names.iter().map(|name| vec![*name]).chain([names.to_vec(), vec![names[0], names[0]]]) {
                let mut asked = lean.clone();
                asked["include"] = json!(include);
                let long = app.post(&path, &asked).await.expect(status);
                if status == 200 {
                    only_added(&short.text, &long.text, name);
                } else {
                    only_added(&lasting(&short.text), &lasting(&long.text), name);
                }
            }
            let mut wrong = lean.clone();
            wrong["include"] = json!([names[0], "everything"]);
            assert_eq!(app.post(&path, &wrong).await.problem(422, "invalid_request"), ["/include/1"], "{operation}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
    for path in [place.clone(), format!("{place}/correction"), format!("{place}/fits")] {
        let answer = app.get(&path).await.expect(200);
        assert!(answer.text.len() <= 2 * SHORT, "{path}: {} bytes", answer.text.len());
    }
    app.stop().await;
}

#[tokio::test]
async fn later_includes_equal_initial_ones() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut body = iteration();
    body["estimator"] = json!({"type": "m_estimator", "loss": "huber"});
    body["filters"] = json!([{"type": "hampel", "axis": "v"}]);
    let lean = app.post(&format!("{job}/iterations"), &body).await.expect(201).json();
    body["include"] = json!(FIT);
    let full = app.post(&format!("{job}/iterations"), &body).await.expect(201).json();
    let place = |iteration: &Value| {
        let fit = iteration["fits"][0]["id"].as_str().unwrap();
        format!("{job}/iterations/{}/fits/{fit}", iteration["number"])
    };
    let short = app.get(&place(&lean)).await.expect(200);
    assert_eq!(short.header("etag"), Some("\"chosen\""));
    app.restart().await;
    assert_eq!(app.get(&place(&lean)).await.expect(200).text, short.text);
    let later = app.get(&format!("{}?include={}", place(&lean), FIT.join(","))).await.expect(200);
    only_added(&short.text, &later.text, "");
    only_added(&later.json()["result"].to_string(), &full["fits"][0]["result"].to_string(), "");
    assert_eq!(later.header("etag"), None);
    // existing parts are returned as they are stored
    let stored = app.get(&place(&full)).await.expect(200).text;
    assert_eq!(app.get(&format!("{}?include=residuals,residuals", place(&full))).await.expect(200).text, stored);
    for query in ["include=everything", "include=residuals,", "include=", "includes=residuals"] {
        let refused = app.get(&format!("{}?{query}", place(&lean))).await.problem(422, "invalid_request");
        assert_eq!(refused, [if query.starts_with("includes") { "/includes" } else { "/include" }], "{query}");
    }
    let refused = app.get(&format!("{}?include=everything", place(&lean))).await.json();
    let said = refused["errors"][0]["detail"].as_str().unwrap();
    assert!(said.starts_with("`everything` is not known; expected one of") && said.contains("`residuals`"), "{said}");
    app.get(&format!("{job}/iterations/1/fits/0190b0de-0000-7000-8000-000000000000")).await.problem(404, "not_found");
    app.stop().await;
}

/// Warnings of an include are returned also if it is requested later, after those of the fit
/// itself.
#[tokio::test]
async fn later_includes_bring_their_warnings() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut body = json!({
        "nodes": {"type": "curve", "x": [0, 1, 1, 1, 1], "y": [1, 1.1, 1.2, 1, 1.1]},
        "model": {"type": "polynomial", "degree": 1}, "regularization": {"type": "none"}
    });
    let stored = app.post(&format!("{job}/iterations"), &body).await.expect(201).json();
    let place = format!("{job}/iterations/1/fits/{}", stored["fits"][0]["id"].as_str().unwrap());
    let codes = |result: &Value| -> Vec<String> {
        result["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|warning| warning["code"].as_str().unwrap().to_owned())
            .collect()
    };
    assert!(!codes(&app.get(&place).await.expect(200).json()["result"]).contains(&"full_leverage".to_owned()));
    for (names, code) in [
        (vec!["influence"], "full_leverage"),
        (vec!["ridge_trace"], "no_ridge_trace"),
        (vec!["lambda_curve", "influence"], "full_leverage"),
    ] {
        let later = app.get(&format!("{place}?include={}", names.join(","))).await.expect(200).json();
        body["include"] = json!(names);
        let at_once = app.post("/v1/fits", &body).await.expect(200).json();
        assert!(codes(&later["result"]).contains(&code.to_owned()), "{later}");
        assert_eq!(later["result"]["warnings"], at_once["warnings"], "{names:?}");
    }
    app.stop().await;
}

/// The returned `spec` is a request: sent back it gives the same bytes, as a fit, as a refit and
/// after a change.
#[tokio::test]
async fn the_spec_that_is_answered_can_be_sent_back() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    for (name, body) in examples("create_fit") {
        let first = app.post("/v1/fits", &body).await.expect(200);
        let mut again = first.json()["spec"].clone();
        again["nodes"] = body["nodes"].clone();
        assert_eq!(app.post("/v1/fits", &again).await.expect(200).text, first.text, "{name}");
        let stored = app.post(&format!("{job}/iterations"), &body).await.expect(201);
        let place = stored.header("location").unwrap().to_owned();
        let stored = stored.json()["fits"][0].clone();
        assert_eq!(stored["spec"], first.json()["spec"], "{name}");
        let mut refit = stored["spec"].clone();
        refit["reason"] = json!("the same again");
        let refit = app.post(&format!("{place}/fits"), &refit).await.expect(201);
        assert_eq!((&refit.json()["spec"], &refit.json()["result"]), (&stored["spec"], &stored["result"]), "{name}");
        // the new fit is where it is said to be, in the very bytes
        assert_eq!(app.get(refit.header("location").unwrap()).await.expect(200).text, refit.text, "{name}");
    }
    app.stop().await;
}
