//! Models chosen by the nodes, and λ* by leaving out blocks, over HTTP: results, refusals by
//! pointer, storing and replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example(name: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value}"))
}

fn codes(body: &Value) -> String {
    body["warnings"].to_string()
}

#[tokio::test]
async fn every_candidate_has_its_figures() {
    let app = TestApp::start().await;
    for criterion in ["aicc", "bic", "press", "blocked_cv", "reml"] {
        let mut request = example("fit_select");
        request["select"]["criterion"] = json!(criterion);
        let body = app.fit(&request.to_string()).await.json();
        let selection = &body["selection"];
        assert_eq!(selection["criterion"], json!(criterion));
        let candidates = list(&selection["candidates"]);
        assert_eq!((candidates.len(), &candidates[5]["degree"]), (12, &json!([1, 2])));
        for candidate in candidates {
            for name in ["aic", "aicc", "bic", "press", "blocked_cv", "reml", "rss", "sigma"] {
                assert!(candidate[name].is_number(), "{name}: {candidate}");
            }
            assert!(candidate.get("terms").is_none() && candidate.get("lambda").is_none());
        }
        let chosen = selection["chosen"].as_u64().unwrap() as usize;
        let figure = |candidate: &Value| candidate[criterion].as_f64().unwrap();
        assert!(candidates.iter().all(|other| figure(&candidates[chosen]) <= figure(other)));
        assert_eq!(candidates[chosen]["degree"], json!([2, 1]), "{criterion}");
        assert_eq!(list(&body["coefficients"]).len(), 6);
        assert!(codes(&body).contains("post_selection"));
        // the request is in the response, with its defaults
        let asked = json!({"degrees": [3, 2], "criterion": criterion, "hierarchical": true});
        assert_eq!(body["spec"]["select"], asked);
    }
}

#[tokio::test]
async fn selected_terms_are_named_and_can_be_requested() {
    let app = TestApp::start().await;
    for (terms, alpha) in [("backward", None), ("elastic_net", Some(0.8))] {
        let mut request = example("fit_select_terms");
        request["select"] = json!({"terms": terms, "criterion": "bic"});
        if let Some(alpha) = alpha {
            request["select"]["alpha"] = json!(alpha);
        }
        let body = app.fit(&request.to_string()).await.json();
        let selection = &body["selection"];
        let chosen = &selection["candidates"][selection["chosen"].as_u64().unwrap() as usize];
        let named: Vec<&Value> = list(&body["coefficients"]).iter().map(|c| &c["term"]).collect();
        assert_eq!(list(&chosen["terms"]).iter().collect::<Vec<_>>(), named);
        assert_eq!(chosen.get("lambda").is_some(), alpha.is_some());
        // the same terms, given
        let powers: Vec<&Value> = list(&body["coefficients"]).iter().map(|c| &c["powers"]).collect();
        let mut listed = request.clone();
        listed["model"]["terms"] = json!(powers);
        listed.as_object_mut().unwrap().remove("select");
        let answer = app.fit(&listed.to_string()).await.json();
        assert!(answer.get("selection").is_none() && !codes(&answer).contains("post_selection"));
        assert_eq!(answer["coefficients"], body["coefficients"]);
        assert_eq!(answer["spec"]["model"]["terms"], listed["model"]["terms"]);
    }
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let refused = async |name: &str, change: Value, pointer: &str| {
        let mut request = example(name);
        let members = request.as_object_mut().unwrap();
        for (name, value) in change.as_object().unwrap() {
            members.insert(name.clone(), value.clone());
        }
        let answer = app.fit(&request.to_string()).await;
        answer.problem(422, "invalid_request");
        assert_eq!(answer.pointers(), [pointer], "{}", answer.text);
    };
    let degrees = |more: Value| {
        let mut select = json!({"degrees": [2, 2], "criterion": "bic"});
        select.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({"select": select})
    };
    for (change, pointer) in [
        (json!({"folds": {"by": "rows", "count": 9}}), "/folds/count"),
        (json!({"folds": {"by": "rows", "count": 1}}), "/folds/count"),
        (json!({"folds": {"by": "nodes"}}), "/folds/by"),
        (json!({"folds": {"by": "rows", "line": [1, 2]}}), "/folds/line"),
        (json!({"folds": {"by": "lines"}}), "/folds/line"),
        (json!({"folds": {"by": "lines", "line": [1, 2]}}), "/folds/line"),
        (json!({"folds": {"by": "rows", "seed": 1}}), "/folds/seed"),
        (degrees(json!({"terms": "backward"})), "/select/terms"),
        (degrees(json!({"alpha": 0.5})), "/select/alpha"),
        (degrees(json!({"degrees": [20, 20]})), "/select/degrees"),
        (degrees(json!({"criterion": "gcv"})), "/select/criterion"),
        (degrees(json!({"hierarchical": false})), "/select/hierarchical"),
        (json!({"select": {"criterion": "bic"}}), "/select"),
        (json!({"select": {"terms": "elastic_net", "alpha": 0, "criterion": "bic"}}), "/select/alpha"),
        (json!({"select": {"terms": "forward", "criterion": "bic"}}), "/select/terms"),
        (json!({"estimator": {"type": "least_absolute_deviations"}}), "/select"),
    ] {
        refused("fit_select", change, pointer).await;
    }
    for (terms, pointer) in [
        (json!([[0, 0], [1, 1]]), "/model/terms/1"),
        (json!([[0, 0], [0, 1], [0, 2]]), "/model/terms/2"),
        (json!([]), "/model/terms"),
        (json!("some"), "/model/terms"),
        (json!([[0, 0, 0]]), "/model/terms/0"),
    ] {
        let model = json!({"type": "polynomial", "degree": [2, 1], "terms": terms});
        refused("fit_terms", json!({"model": model}), pointer).await;
    }
    refused("fit_terms", json!({"regularization": {"type": "ridge"}}), "/folds").await;
}

#[tokio::test]
async fn lambda_is_cross_validated() {
    let app = TestApp::start().await;
    for (kind, parameter) in [("ridge", "parameter"), ("spectral", "lambda_star"), ("tikhonov", "parameter")] {
        let mut request = example("fit_terms");
        request["regularization"] = json!({"type": kind, parameter: {"criterion": "blocked_cv"}});
        if kind == "tikhonov" {
            request["regularization"]["order"] = json!(2);
        }
        let found = app.fit(&request.to_string()).await.json();
        assert_eq!(found["regularization"]["criterion"], "blocked_cv", "{found}");
        let choices = list(&found["regularization"]["choices"]);
        assert!(choices.iter().any(|choice| choice["criterion"] == "blocked_cv"), "{found}");
        assert_eq!(found["spec"]["folds"], json!({"by": "columns"}));
        // blocks say what is left out, so that others choose otherwise
        request["folds"] = json!({"by": "lines", "line": (0..48).map(|k| k % 2).collect::<Vec<i32>>()});
        let other = app.fit(&request.to_string()).await.json();
        if kind != "spectral" {
            assert_ne!(other["regularization"]["lambda_star"], found["regularization"]["lambda_star"]);
        }
    }
}

#[tokio::test]
async fn a_stream_keeps_no_nodes_to_compare_by() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "selection"}).to_string())).await.json();
    let streams = format!("/v1/jobs/{}/streams", job["id"].as_str().unwrap());
    let model = json!({"type": "polynomial", "degree": 1});
    for (member, value) in [("select", json!({"degrees": 2, "criterion": "bic"})), ("folds", json!({"by": "rows"}))] {
        let answer = send(app.post(&streams, json!({"model": model, member: value}).to_string())).await;
        answer.problem(422, "invalid_request");
        assert_eq!(answer.pointers(), [format!("/{member}")]);
    }
}

#[tokio::test]
async fn stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "selection"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    for name in ["fit_select", "fit_select_terms", "fit_terms"] {
        let stored = send(app.post(&iterations, example(name).to_string())).await;
        assert_eq!(stored.status, 201, "{}", stored.text);
        let stored = stored.json();
        let fit = &stored["fits"][0];
        assert_eq!(fit["result"].get("selection").is_some(), name != "fit_terms");
        let path = format!("{iterations}/{}/fits/{}/replay", stored["number"], fit["id"].as_str().unwrap());
        assert_eq!(send(app.post(&path, "")).await.json()["identical"], true, "{name}");
    }
}
