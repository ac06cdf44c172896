//! Filters before a fit: results, refusals, and that stored fits keep them.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example(name: &str) -> Value {
    serde_json::from_str(REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap().text).unwrap()
}

#[tokio::test]
async fn every_filter_reports_its_changes() {
    let app = TestApp::start().await;
    let body = app.fit(&example("fit_filtered").to_string()).await.json();
    let filters = body["filters"].as_array().unwrap();
    let kinds: Vec<&str> = filters.iter().map(|filter| filter["type"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["hampel", "gaussian", "spline"]);
    // the three peaks that were put into the example, row by row of 13
    assert_eq!(filters[0]["node_indices"], json!([44, 80, 113]), "{}", filters[0]);
    assert_eq!((&filters[0]["changed"], &filters[0]["removed"]), (&json!(3), &json!(3)));
    assert!(filters[0]["max_change"].as_f64().unwrap() > 9.0);
    for filter in &filters[1..] {
        assert!(filter["changed"].as_u64().unwrap() > 100 && filter["removed"] == 0, "{filter}");
        assert!(filter["rms_change"].as_f64().unwrap() > 0.0 && filter.get("node_indices").is_none(), "{filter}");
    }
    // 143 places, one missing, three removed
    let columns = &body["filter_collinearity"];
    assert_eq!((&columns["before"]["count"], &columns["after"]["count"]), (&json!(142), &json!(139)));
    assert_eq!(body["residuals"]["count"], 139);
    let condition = |when: &str| columns[when]["condition"].as_f64().unwrap();
    assert!(condition("after") > condition("before"), "{columns}");
    for figure in ["largest_correlation", "largest_vif"] {
        assert!(columns["after"][figure].as_f64().unwrap() > 0.0, "{columns}");
    }
    let codes: Vec<&str> =
        body["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"filtered_noise"), "{codes:?}");

    let body = app.fit(&example("fit_filtered_curve").to_string()).await.json();
    let robust = &body["filters"][1];
    assert!(robust["iterations"].as_u64().unwrap() > 1 && robust["converged"] == true, "{robust}");
    // unfiltered responses have no filters
    let plain = app.fit(crate::harness::CURVE).await.json();
    assert!(plain.get("filters").is_none() && plain.get("filter_collinearity").is_none());
}

#[tokio::test]
async fn an_empty_list_is_no_filter_and_defaults_are_written_out() {
    let app = TestApp::start().await;
    let mut request: Value = serde_json::from_str(crate::harness::CURVE).unwrap();
    let digest = |body: Value| body["provenance"]["input_sha256"].clone();
    let plain = digest(app.fit(&request.to_string()).await.json());
    request["filters"] = json!([]);
    assert_eq!(digest(app.fit(&request.to_string()).await.json()), plain);
    request["filters"] = json!([{"type": "hampel"}]);
    let short = digest(app.fit(&request.to_string()).await.json());
    assert_ne!(short, plain);
    request["filters"] = json!([{"action": "replace", "threshold": 3, "window": 7, "type": "hampel"}]);
    assert_eq!(digest(app.fit(&request.to_string()).await.json()), short);
}

#[tokio::test]
async fn impossible_filters_are_pointed_at() {
    let app = TestApp::start().await;
    let curve = json!({"type": "curve", "x": [0, 1, 2, 3, 4], "y": [0, 1, 4, 2, 1]});
    let grid = json!({"type": "grid", "u": [0, 1, 2], "v": [0, 1, 2], "z": [[1, 2, 3], [4, 5, 6], [7, 8, 9.5]]});
    let scattered = json!({"type": "scattered", "u": [0, 1, 0, 1], "v": [0, 0, 1, 1], "z": [1, 2, 3, 5]});
    let matrix = json!({"type": "matrix", "x": [[1], [2], [3]], "y": [1, 2, 4]});
    for (nodes, filters, expected) in [
        (&curve, json!({"type": "hampel"}), vec!["/filters"]),
        (&curve, json!([{"window": 7}]), vec!["/filters/0/type"]),
        (&curve, json!([{"type": "median"}]), vec!["/filters/0/type"]),
        (
            &curve,
            json!([{"type": "hampel", "window": 4}, {"type": "hampel", "threshold": -1}]),
            vec!["/filters/0/window", "/filters/1/threshold"],
        ),
        (&curve, json!([{"type": "hampel", "action": "keep"}]), vec!["/filters/0/action"]),
        (&curve, json!([{"type": "hampel", "size": 4}]), vec!["/filters/0/size"]),
        (&curve, json!([{"type": "gaussian"}]), vec!["/filters/0/cutoff"]),
        (&curve, json!([{"type": "gaussian", "cutoff": 0}]), vec!["/filters/0/cutoff"]),
        (&curve, json!([{"type": "gaussian", "cutoff": 1.5}]), vec!["/filters/0/cutoff"]),
        (&curve, json!([{"type": "gaussian", "cutoff": 4, "axis": "v"}]), vec!["/filters/0/axis"]),
        (&curve, json!([{"type": "gaussian", "cutoff": 4, "order": 2}]), vec!["/filters/0/order"]),
        (&curve, json!([{"type": "gaussian", "cutoff": 4, "robust": true, "order": 1}]), vec!["/filters/0/order"]),
        (&curve, json!([{"type": "spline", "cutoff": null}]), vec!["/filters/0/cutoff"]),
        (
            &grid,
            json!([{"type": "spline", "cutoff": 4}, {"type": "gaussian", "cutoff": 4, "axis": "w"}]),
            vec!["/filters/1/axis"],
        ),
        (&grid, json!([{"type": "spline", "cutoff": 4}]), vec!["/filters/0/axis"]),
        (&scattered, json!([{"type": "hampel"}]), vec!["/filters/0/type"]),
        (&matrix, json!([{"type": "hampel"}, {"type": "spline", "cutoff": 4}]), vec!["/filters/1/type"]),
        (&matrix, json!([{"type": "hampel", "axis": "u"}]), vec!["/filters/0/axis"]),
        (&curve, json!(vec![json!({"type": "hampel"}); 17]), vec!["/filters"]),
    ] {
        let model = if nodes["type"] == "matrix" {
            json!({"type": "linear"})
        } else {
            json!({"type": "polynomial", "degree": 1})
        };
        let request = json!({"nodes": nodes, "model": model, "filters": filters});
        assert_eq!(app.fit(&request.to_string()).await.pointers(), expected, "{filters}");
    }
}

#[tokio::test]
async fn stored_fits_keep_their_filters_and_refits_may_have_others() {
    let app = TestApp::start().await;
    let post = async |path: &str, body: &Value| send(app.post(path, body.to_string())).await;
    let job = post("/v1/jobs", &json!({"name": "filtered"})).await;
    let job = job.header("location").to_owned();
    let request = example("fit_filtered");
    let added = post(&format!("{job}/iterations"), &request).await;
    assert_eq!(added.status, 201, "{}", added.text);
    let place = added.header("location").to_owned();
    let mut computed = app.fit(&request.to_string()).await.json();
    computed.as_object_mut().unwrap().remove("spec");
    assert_eq!(added.json()["fits"][0]["result"], computed);
    // the nodes stay as they were posted
    let nodes = send(app.get(&format!("{place}/nodes"))).await.json();
    assert_eq!(nodes["z"][3][5], 14.2);
    let refit = post(
        &format!("{place}/fits"),
        &json!({"model": request["model"], "filters": [{"type": "hampel", "axis": "v"}], "reason": "peaks only"}),
    )
    .await;
    assert_eq!(refit.status, 201, "{}", refit.text);
    assert_eq!(refit.json()["result"]["filters"].as_array().unwrap().len(), 1);
    for fit in [&added.json()["fits"][0]["id"], &refit.json()["id"]] {
        let replay = post(&format!("{place}/fits/{}/replay", fit.as_str().unwrap()), &json!({})).await;
        assert_eq!(replay.text, r#"{"identical":true}"#);
    }
}
