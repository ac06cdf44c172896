//! Suspected gross errors over HTTP: they are named together with the figures without them, and
//! excluded by a refit that is stored and replayed.

use serde_json::{Value, json};

use super::{spur, taken};
use crate::harness::{TestApp, send};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn warning<'a>(warnings: &'a Value, code: &str) -> Option<&'a Value> {
    warnings.as_array().unwrap_or_else(|| panic!("{warnings}")).iter().find(|one| one["code"] == code)
}

/// Returns a crowned flank of 9 × 7 nodes with noise of about 0.3 µm; one node is off by 77 µm.
fn iteration(off: f64) -> Value {
    let u: Vec<f64> = (0..9).map(made_u).collect();
    let v: Vec<f64> = (0..7).map(|j| 1.0 + 2.0 * f64::from(j)).collect();
    let height = |i: usize, j: usize| {
        let (p, z) = ((u[i] - 7.8) / 2.8, (v[j] - 7.0) / 6.0);
        let noise = 0.4 * (17.0 * u[i] + 5.0 * v[j]).sin();
        let gross = if (i, j) == (6, 4) { off } else { 0.0 };
        3.0 * p - 2.0 * z - 1.5 * p * p - 2.5 * z * z + 0.8 * p * z + noise + gross
    };
    let rows: Vec<Vec<f64>> = (0..9).map(|i| (0..7).map(|j| height(i, j)).collect()).collect();
    json!({
        "nodes": {"type": "grid", "u": u, "v": v, "z": rows}, "flank": "right", "tooth": "1",
        "axes": {"u": {"quantity": "roll_length", "unit": "mm"}, "v": {"quantity": "face_width", "unit": "mm"},
                 "z": {"quantity": "deviation", "unit": "um"}},
        "model": {"type": "polynomial", "degree": 2, "basis": "legendre", "terms": "total"},
        "regularization": {"type": "none"},
    })
}

#[tokio::test]
async fn a_node_that_is_off_is_named_and_left_out() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "w", "gear": spur()}).to_string())).await;
    let at = format!("{}/iterations", job.header("location"));
    let made = send(app.post(&at, iteration(77.0).to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let made = made.json();
    let (result, figures) = (&made["fits"][0]["result"], &made["fits"][0]["figures"]);

    // the fit reports which node, by how much, and its effect on the coefficients
    let suspects = warning(&result["warnings"], "outliers_suspected").unwrap_or_else(|| panic!("{result}"));
    let params = &suspects["params"];
    let [node] = &params["nodes"].as_array().unwrap()[..] else { panic!("{params}") };
    assert_eq!((&node["index"], &node["row"], &node["column"]), (&json!(46), &json!(6), &json!(4)));
    assert!((number(&node["off"]) - 77.0).abs() < 1.0 && number(&node["off_sigmas"]) > 100.0, "{node}");
    assert_eq!(node["place"], json!([made_u(6), 9.0]));
    assert_eq!((&params["count"], &params["exceeds_interval"]), (&json!(1), &json!(true)));
    assert!(!params["moved"].as_array().unwrap().is_empty());
    let message = suspects["message"].as_str().unwrap();
    assert!(message.contains("node 46 (row 6, column 4) by 7") && !message.contains("heavy tails"), "{message}");

    // so do the figures of the flank
    let suspects = warning(&figures["warnings"], "outliers_suspected").unwrap_or_else(|| panic!("{figures}"));
    assert_eq!(suspects["params"]["exceeds_interval"], json!(true));
    let moved = |name: &str| {
        let all = suspects["params"]["figures"].as_array().unwrap().clone();
        all.into_iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {suspects}"))
    };
    let crowning = moved("profile_crowning_um");
    assert_eq!(crowning["value"], figures["profile_crowning_um"]["value"]);

    // a refit excludes it, and is stored and replayed as requested
    let refit = json!({
        "model": iteration(0.0)["model"], "regularization": {"type": "none"},
        "exclude": [{"row": 6, "column": 4}], "reason": "dust",
    });
    let kept = send(app.post(&format!("{at}/1/fits"), refit.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let kept = kept.json();
    assert_eq!(kept["spec"]["exclude"], refit["exclude"]);
    assert_eq!(kept["result"]["residuals"]["count"], 62);
    assert!(warning(&kept["result"]["warnings"], "outliers_suspected").is_none());
    assert!((number(&kept["figures"]["profile_crowning_um"]["value"]) - number(&crowning["without"])).abs() < 1e-12);
    assert!((number(&crowning["without"]) - 1.5).abs() < 0.3, "{crowning}");
    for (with, without) in
        params["coefficients"].as_array().unwrap().iter().zip(kept["result"]["coefficients"].as_array().unwrap())
    {
        assert_eq!(with["without"], without["value"]);
    }
    let id = kept["id"].as_str().unwrap();
    let replay = send(app.post(&format!("{at}/1/fits/{id}/replay"), "{}")).await;
    assert_eq!(replay.json(), json!({"identical": true}));
    let trace = send(app.get(&format!("{}/trace", job.header("location")))).await.json();
    let traced = trace["iterations"][0]["fits"].as_array().unwrap();
    assert!(traced.iter().any(|fit| fit["reason"] == "dust"), "{trace}");
    // the nodes are those that were measured
    let nodes = send(app.get(&format!("{at}/1/nodes")).header("accept", "application/json")).await.json();
    assert!(number(&nodes["z"][6][4]) > 70.0);

    // once this fit is chosen, corrections leave the node out as well
    let correction =
        json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "target": "nominal"}).to_string();
    let before = async || {
        let made = send(app.post(&format!("{at}/1/correction"), correction.clone())).await;
        assert_eq!(made.status, 201, "{}", made.text);
        number(&made.json()["result"]["figures"]["right"]["profile_crowning_um"]["before"])
    };
    let with = before().await;
    let choice = app.client.put(app.url(&format!("{at}/1/chosen-fit"))).json(&json!({"fit_id": id}));
    assert_eq!(send(choice).await.status, 200);
    let without = before().await;
    assert!((without - number(&crowning["without"])).abs() < 0.1, "{without} {crowning}");
    assert!((with - without).abs() > 0.5, "{with} {without}");
}

/// Returns u of a row.
fn made_u(i: u32) -> f64 {
    5.0 + 0.7 * f64::from(i)
}

#[tokio::test]
async fn invalid_exclusions_are_refused_with_their_pointer() {
    let app = TestApp::start().await;
    let fit = |exclude: Value| {
        let mut body = iteration(0.0);
        for name in ["flank", "tooth", "axes"] {
            body.as_object_mut().unwrap().remove(name);
        }
        body["exclude"] = exclude;
        body
    };
    let mut body = fit(json!([{"row": 0, "column": 0}]));
    body["nodes"]["z"][2][3] = Value::Null;
    for (exclude, pointer, words) in [
        (json!([{"row": 9, "column": 0}]), "/exclude/0", "9 rows and 7 columns"),
        (json!([1, {"row": 0, "column": 7}]), "/exclude/1", "9 rows and 7 columns"),
        (json!([63]), "/exclude/0", "63 were posted"),
        (json!([17]), "/exclude/0", "missing or has weight 0"),
        (json!([4, {"row": 0, "column": 4}]), "/exclude/1", "already excluded by entry 0"),
        (json!((0..58).filter(|k| *k != 17).collect::<Vec<usize>>()), "/exclude", "5 nodes are left for 6"),
        (json!([-1]), "/exclude/0", "-1"),
        (json!([{"row": 1}]), "/exclude/0/column", "required"),
        (json!("none"), "/exclude", "array"),
    ] {
        body["exclude"] = exclude;
        let refused = app.fit(&body.to_string()).await;
        assert_eq!(refused.status, 422, "{}", refused.text);
        assert_eq!(refused.pointers(), [pointer], "{}", refused.text);
        assert!(refused.text.contains(words), "{words}: {}", refused.text);
    }
    // nodes of a curve have no rows
    let curve = json!({
        "nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [0, 1, 2, 4]},
        "model": {"type": "polynomial", "degree": 1}, "exclude": [{"row": 0, "column": 0}],
    });
    let refused = app.fit(&curve.to_string()).await;
    assert_eq!(refused.status, 422, "{}", refused.text);
    assert_eq!(refused.pointers(), ["/exclude/0"], "{}", refused.text);
    // a stream takes every node
    let job = send(app.post("/v1/jobs", json!({"name": "s"}).to_string())).await;
    let open = json!({"model": {"type": "polynomial", "degree": 1}, "domain": {"u": [0, 9]}, "exclude": [0]});
    let refused = send(app.post(&format!("{}/streams", job.header("location")), open.to_string())).await;
    assert_eq!(refused.status, 422, "{}", refused.text);
    assert!(refused.pointers().contains(&"/exclude".to_owned()), "{}", refused.text);
}

/// Near dependencies of raw powers far from 0 are caused by the basis, those of terms that a grid
/// does not separate by the nodes.
#[tokio::test]
async fn a_dependency_is_attributed_to_basis_or_nodes() {
    let app = TestApp::start().await;
    let fit = |u: Vec<f64>, basis: &str| {
        let v: Vec<f64> = (0..9).map(|j| 30.0 + f64::from(j)).collect();
        let row = |x: &f64| -> Vec<f64> { v.iter().map(|y| (13.0 * x + 7.0 * y).sin()).collect() };
        let rows: Vec<Vec<f64>> = u.iter().map(row).collect();
        json!({"nodes": {"type": "grid", "u": u, "v": v, "z": rows}, "regularization": {"type": "none"},
               "model": {"type": "polynomial", "degree": [2, 2], "basis": basis}})
    };
    let even: Vec<f64> = (0..9).map(|i| 30.0 + f64::from(i)).collect();
    let raw = app.fit(&fit(even.clone(), "monomial").to_string()).await.json();
    let found = &raw["collinearity"];
    let condition = number(&found["basis"]["condition"]);
    assert_eq!(found["basis"]["type"], "legendre");
    assert!(condition < 4.0, "{condition}");
    let near = found["near_dependencies"].as_array().unwrap();
    assert!(!near.is_empty());
    for one in near {
        assert_eq!(one["cause"], "basis", "{one}");
        let sentence = one["sentence"].as_str().unwrap();
        assert!(sentence.contains("as raw powers") && sentence.contains("the fitted function"), "{sentence}");
    }
    // a fit in that basis has the reported condition
    let mapped = app.fit(&fit(even, "legendre").to_string()).await.json();
    assert!((number(&mapped["spectrum"]["condition"]) / condition - 1.0).abs() < 1e-9);
    assert_eq!(mapped["collinearity"]["near_dependencies"], json!([]));
    // two of three positions nearly coincide: no basis helps
    let few = app.fit(&fit(vec![30.0, 30.001, 38.0], "legendre").to_string()).await.json();
    let near = few["collinearity"]["near_dependencies"].as_array().unwrap();
    assert!(!near.is_empty());
    for one in near {
        assert_eq!(one["cause"], "nodes", "{one}");
        assert!(one["sentence"].as_str().unwrap().contains("at these nodes"), "{one}");
    }
    // rows of a matrix have no other basis
    let matrix = json!({"nodes": {"type": "matrix", "x": [[1.0, 1.0], [2.0, 2.01], [3.0, 3.0], [4.0, 4.01]], "y": [1, 2, 3, 5]},
                        "model": {"type": "linear"}});
    let found = app.fit(&matrix.to_string()).await.json()["collinearity"].clone();
    assert!(found.get("basis").is_none());
    assert_eq!(found["near_dependencies"][0]["cause"], "nodes");
}

/// A flank with a node that is suspected is accepted with a reason only.
#[tokio::test]
async fn a_suspected_node_asks_for_a_reason() {
    let app = TestApp::start().await;
    let requirements = json!({"tolerance_limits": {"profile_slope_um": [-90, 90]}});
    let job = json!({"name": "w", "gear": spur(), "requirements": requirements});
    let job = send(app.post("/v1/jobs", job.to_string())).await;
    let at = format!("{}/iterations", job.header("location"));
    for (number, off) in [(1, 77.0), (2, 0.0)] {
        assert_eq!(send(app.post(&at, iteration(off).to_string())).await.status, 201);
        let accepted = async |more: Value| {
            let mut body = json!({"decision": "accepted"});
            body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            send(app.client.patch(app.url(&format!("{at}/{number}"))).json(&body)).await
        };
        let plain = accepted(json!({})).await;
        if number == 1 {
            assert_eq!(plain.pointers(), ["/reason"], "{}", plain.text);
            assert!(plain.text.contains("gross errors"), "{}", plain.text);
            assert_eq!(accepted(json!({"reason": "dust at the tip"})).await.status, 200);
        } else {
            assert_eq!(plain.status, 200, "{}", plain.text);
        }
    }
}

/// From three suspected nodes on the sentence names heavy tails as the other explanation.
#[tokio::test]
async fn three_suspected_nodes_may_be_heavy_tails() {
    let app = TestApp::start().await;
    for (count, heavy) in [(2, false), (3, true)] {
        let mut request = iteration(0.0);
        for (row, column) in [(6, 4), (2, 1), (4, 5)].into_iter().take(count) {
            request["nodes"]["z"][row][column] = json!(25.0);
        }
        for stored in ["tooth", "flank"] {
            request.as_object_mut().unwrap().remove(stored);
        }
        let fit = taken(&app, "/v1/fits", &request).await;
        let suspected = warning(&fit["warnings"], "outliers_suspected").unwrap_or_else(|| panic!("{fit}"));
        assert_eq!(suspected["params"]["count"], json!(count));
        let message = suspected["message"].as_str().unwrap();
        let advice = message.contains("or the errors have heavy tails: compare `m_estimator`");
        assert_eq!(advice, heavy, "{message}");
    }
    app.stop().await;
}
