//! Models of the errors over HTTP: results, refusals by pointer, storing and replay.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example(name: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[tokio::test]
async fn correlated_errors_are_estimated() {
    let app = TestApp::start().await;
    let body = app.fit(&example("fit_correlated").to_string()).await.json();
    let errors = &body["errors"];
    assert_eq!((&errors["type"], &errors["along"]), (&json!("ar1"), &json!("order")));
    assert_eq!(body["spec"]["errors"], json!({"type": "ar1", "along": "order", "estimate": true}));
    let (rho, error) = (number(&errors["parameters"]["rho"]), number(&errors["parameters"]["std_error"]));
    assert!((0.1..0.95).contains(&rho) && (0.02..0.4).contains(&error), "{errors}");
    let count = number(&errors["effective_count"]);
    assert!(count > 2.0 && count < 40.0, "{errors}");
    let statistic = |k: usize| number(&errors["durbin_watson"][k]);
    assert!(statistic(0) < statistic(1) && statistic(1) < 2.6, "{errors}");
    // as a plain fit it warns, and says less than the truth of its errors
    let mut plain = example("fit_correlated");
    plain.as_object_mut().unwrap().remove("errors");
    let plain = app.fit(&plain.to_string()).await.json();
    assert!(plain.get("errors").is_none());
    assert!(plain["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "correlated_residuals"), "{plain}");
    let first = |body: &Value| number(&body["coefficients"][0]["std_error"]);
    assert!(first(&body) > 1.5 * first(&plain));
}

#[tokio::test]
async fn given_parameters_and_variances_are_returned() {
    let app = TestApp::start().await;
    let mut asked = example("fit_correlated");
    for (errors, parameters) in [
        (json!({"type": "ar1", "parameters": {"rho": 0.6}}), json!({"rho": 0.6})),
        (json!({"type": "ar2", "parameters": {"phi": [0.9, -0.2]}}), json!({"phi": [0.9, -0.2]})),
        (
            json!({"type": "matern", "parameters": {"length": 2.0, "nugget": 0.25}}),
            json!({"length": 2.0, "nugget": 0.25}),
        ),
    ] {
        asked["errors"] = errors;
        let body = app.fit(&asked.to_string()).await.json();
        assert_eq!(body["errors"]["parameters"], parameters);
        let mut again = body["spec"].clone();
        again["nodes"] = asked["nodes"].clone();
        assert_eq!(app.fit(&again.to_string()).await.json()["coefficients"], body["coefficients"]);
    }
    asked["errors"] = json!({"type": "independent"});
    let plain = app.fit(&asked.to_string()).await.json();
    assert!(plain["spec"].get("errors").is_none() && plain.get("errors").is_none());
    asked["variance"] = json!("hc3");
    let sandwich = app.fit(&asked.to_string()).await.json();
    assert_eq!(sandwich["spec"]["variance"], "hc3");
    assert_eq!(sandwich["coefficients"][0]["value"], plain["coefficients"][0]["value"]);
    assert_ne!(sandwich["coefficients"][0]["std_error"], plain["coefficients"][0]["std_error"]);

    let body = app.fit(&example("fit_groups").to_string()).await.json();
    let sigma = |k: usize| number(&body["variance"]["groups"][k]["sigma"]);
    assert!(sigma(1) > 2.0 * sigma(0), "{}", body["variance"]);
    assert!(body["warnings"].as_array().unwrap().iter().all(|w| w["code"] != "group_variance_uncertain"), "{body}");
    // four of 24 nodes determine next to nothing of a variance next to a fitted curve
    let mut small = example("fit_groups");
    let group: Vec<u8> = (0..24).map(|k| u8::from(k % 6 != 2)).collect();
    small["variance"] = json!({"groups": group});
    let y = (0..24).map(|k| if k % 6 == 2 { 0.0 } else { f64::from((7 * k) % 5) - 2.0 });
    small["nodes"]["y"] = json!(y.enumerate().map(|(k, y)| y + 1e-3 * (k as f64).sin()).collect::<Vec<_>>());
    let body = app.fit(&small.to_string()).await.json();
    let warnings = body["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|w| w["code"] == "group_variance_uncertain").unwrap_or_else(|| panic!("{body}"));
    assert!(warning["message"].as_str().unwrap().starts_with("the variance of group 0 has "), "{warning}");
    let wide = |k: usize| {
        let [low, high] = [0, 1].map(|end| number(&body["coefficients"][k]["interval"][end]));
        (high - low) / number(&body["coefficients"][k]["std_error"])
    };
    // t of two degrees of freedom or fewer, not of all
    assert!(wide(0) > 7.0, "{body}");
    let mut power = example("fit_groups");
    power["nodes"]["x"] = json!((1..25).map(f64::from).collect::<Vec<_>>());
    power["variance"] = json!({"power_of": "u"});
    let body = app.fit(&power.to_string()).await.json();
    assert!(number(&body["variance"]["exponent"]) > 0.0 && number(&body["variance"]["at"]) > 1.0);
    let few = |body: &Value| body["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "power_uncertain");
    assert!(!few(&body), "{body}");
    for axis in ["x", "y"] {
        let every_third = power["nodes"][axis].as_array().unwrap().iter().step_by(3).cloned().collect();
        power["nodes"][axis] = Value::Array(every_third);
    }
    let body = app.fit(&power.to_string()).await.json();
    assert!(few(&body), "{body}");
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let base = example("fit_correlated");
    let refused = async |change: &[(&str, Value)], pointer: &str| {
        let mut asked = base.clone();
        for (name, value) in change {
            asked[*name] = value.clone();
        }
        let answer = app.fit(&asked.to_string()).await;
        assert_eq!(answer.status, 422, "{}", answer.text);
        let answer = answer.json();
        assert_eq!(answer["errors"][0]["pointer"], pointer, "{answer}");
    };
    refused(&[("errors", json!({"type": "arma"}))], "/errors/type").await;
    refused(&[("errors", json!({"type": "ar1", "rho": 0.5}))], "/errors/rho").await;
    refused(&[("errors", json!({"type": "ar1", "along": "v"}))], "/errors/along").await;
    refused(&[("errors", json!({"type": "ar1", "estimate": false}))], "/errors/parameters").await;
    refused(&[("errors", json!({"type": "ar1", "parameters": {"rho": 1.0}}))], "/errors/parameters/rho").await;
    refused(&[("errors", json!({"type": "ar1", "line": [1, 2]}))], "/errors/line").await;
    let z: Vec<[f64; 2]> = (0..12).map(|k| [f64::from(k * k % 7), f64::from(k * k % 5)]).collect();
    let u: Vec<i32> = (0..12).collect();
    let twos = ("nodes", json!({"type": "grid", "u": u, "v": [0.0, 1.0], "z": z}));
    let plane = ("model", json!({"type": "polynomial", "degree": 1}));
    for kind in ["ar2", "matern"] {
        refused(&[twos.clone(), plane.clone(), ("errors", json!({"type": kind, "along": "v"}))], "/errors/along").await;
    }
    refused(&[("estimator", json!({"type": "rank"}))], "/estimator/type").await;
    refused(&[("scaling", json!("standardized"))], "/scaling").await;
    refused(&[("variance", json!("hc3"))], "/variance").await;
    let independent = ("errors", json!({"type": "independent"}));
    refused(&[independent.clone(), ("variance", json!("hc4"))], "/variance").await;
    refused(&[independent.clone(), ("variance", json!({"groups": [1]}))], "/variance/groups").await;
    refused(&[independent.clone(), ("variance", json!({"power_of": "u", "exponent": 9}))], "/variance/exponent").await;
    refused(&[independent.clone(), ("variance", json!({"power_of": "v"}))], "/variance/power_of").await;
    refused(&[independent.clone(), ("variance", json!(true))], "/variance").await;
    refused(&[independent, ("variance", json!({}))], "/variance").await;
}

#[tokio::test]
async fn they_are_stored_and_replayed() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "errors"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    for name in ["fit_correlated", "fit_groups"] {
        let stored = send(app.post(&iterations, example(name).to_string())).await;
        assert_eq!(stored.status, 201, "{}", stored.text);
        let stored = stored.json();
        let fit = &stored["fits"][0];
        let kept = if name == "fit_groups" { "variance" } else { "errors" };
        assert_eq!(fit["spec"][kept], example(name)[kept]);
        let path = format!("{iterations}/{}/fits/{}/replay", stored["number"], fit["id"].as_str().unwrap());
        assert_eq!(send(app.post(&path, "")).await.json()["identical"], true);
    }
}

/// The table of docs/explanation/errors.md on selections, constraints and criteria that leave nodes
/// out.
#[tokio::test]
async fn incompatible_options_of_an_error_model_are_refused() {
    let app = TestApp::start().await;
    let x: Vec<f64> = (0..24).map(|k| 1.0 + 0.5 * f64::from(k)).collect();
    let y: Vec<f64> = x.iter().enumerate().map(|(k, x)| 0.3 * x + 0.02 * x * x + (37 * k % 11) as f64 / 30.0).collect();
    let plain = json!({"nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 2},
        "regularization": {"type": "none"}});
    let groups = [[1; 12], [2; 12]].concat();
    let models = [
        ("errors", json!({"type": "ar1", "along": "order", "parameters": {"rho": 0.3}})),
        ("errors", json!({"type": "ar1", "along": "order"})),
        ("variance", json!("hc3")),
        ("variance", json!({"groups": groups})),
        ("variance", json!({"power_of": "u"})),
    ];
    let criterion = |name: &str| json!({"type": "ridge", "parameter": {"criterion": name}});
    let beside = [
        ("select", json!({"degrees": 3, "criterion": "bic"}), true),
        ("constraints", json!([{"kind": "increasing"}]), true),
        ("regularization", criterion("press"), false),
        ("regularization", criterion("blocked_cv"), false),
    ];
    for (name, value, of_variances) in beside {
        for (kind, model) in &models {
            let mut asked = plain.clone();
            asked[name] = value.clone();
            assert_eq!(app.fit(&asked.to_string()).await.status, 200, "{name} alone");
            asked[*kind] = model.clone();
            let answer = app.fit(&asked.to_string()).await;
            let refused = of_variances || *kind == "errors";
            assert_eq!(answer.status, if refused { 422 } else { 200 }, "{name} {model}: {}", answer.text);
        }
    }
}

#[tokio::test]
async fn figures_of_flanks_take_them_and_shapes_do_not() {
    let app = TestApp::start().await;
    let mut flank = crate::shapes::examples("gear_flank_surface")[0].1.clone();
    let post = async |path: &str, body: &Value| send(app.post(path, body.to_string())).await;
    let width = |body: &Value| {
        let ends = &body["helix_slope_um"]["interval"];
        number(&ends[1]) - number(&ends[0])
    };
    let plain = post("/v1/gears/flank-surface", &flank).await.json();
    flank["errors"] = json!({"type": "ar1", "along": "v", "parameters": {"rho": 0.8}});
    let scanned = post("/v1/gears/flank-surface", &flank).await;
    assert_eq!(scanned.status, 200, "{}", scanned.text);
    assert!(width(&scanned.json()) > 1.2 * width(&plain), "{}", scanned.text);
    let refused = async |path: &str, body: &Value, pointer: &str| {
        let answer = post(path, body).await;
        assert_eq!(answer.status, 422, "{}", answer.text);
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{}", answer.text);
    };
    flank["errors"] = json!({"type": "matern", "along": "both"});
    refused("/v1/gears/flank-surface", &flank, "/errors/along").await;
    flank.as_object_mut().unwrap().remove("errors");
    flank["variance"] = json!({"power_of": "u"});
    refused("/v1/gears/flank-surface", &flank, "/variance").await;
    let mut curve = example("curve_least_squares");
    curve["variance"] = json!("hc3");
    refused("/v1/curves", &curve, "/variance").await;
}

#[tokio::test]
async fn positions_that_are_off_are_counted_stored_and_replayed() {
    let app = TestApp::start().await;
    let mut asked = example("fit_correlated");
    asked.as_object_mut().unwrap().remove("errors");
    let plain = app.fit(&asked.to_string()).await.json();
    assert!(plain.get("positions").is_none());
    asked["node_uncertainty"] = json!({"position": 0.2, "height": 0.5});
    let measured = app.fit(&asked.to_string()).await.json();
    let positions = &measured["positions"];
    assert_eq!(positions["kind"], "measured", "{measured}");
    assert!(number(&positions["largest_shift"]) > 0.0 && number(&positions["variance_share"]) > 0.0);
    assert!(measured["perturbation"].is_object());
    asked["node_uncertainty"]["position_kind"] = json!("nominal");
    let nominal = app.fit(&asked.to_string()).await.json();
    assert_eq!(
        (&nominal["positions"]["kind"], number(&nominal["positions"]["largest_shift"])),
        (&json!("nominal"), 0.0)
    );
    assert_eq!(nominal["spec"]["node_uncertainty"], asked["node_uncertainty"]);
    assert_ne!(nominal["coefficients"], measured["coefficients"]);

    let refused = async |asked: &Value, pointer: &str| {
        let answer = app.fit(&asked.to_string()).await;
        assert_eq!(answer.status, 422, "{}", answer.text);
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{}", answer.text);
    };
    let with = |name: &str, value: Value| {
        let mut changed = asked.clone();
        changed[name] = value;
        changed
    };
    let kind = |kind: Value| with("node_uncertainty", json!({"position": 0.2, "height": 0.5, "position_kind": kind}));
    refused(&kind(json!("read")), "/node_uncertainty/position_kind").await;
    refused(&with("estimator", json!({"type": "rank"})), "/node_uncertainty/position_kind").await;
    refused(&with("errors", json!({"type": "ar1"})), "/node_uncertainty").await;

    let job = send(app.post("/v1/jobs", json!({"name": "positions"}).to_string())).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let stored = send(app.post(&iterations, asked.to_string())).await;
    assert_eq!(stored.status, 201, "{}", stored.text);
    let fit = &stored.json()["fits"][0];
    assert_eq!(fit["spec"]["node_uncertainty"]["position_kind"], "nominal");
    let path = format!("{iterations}/1/fits/{}/replay", fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&path, "")).await.json()["identical"], true);
}

#[tokio::test]
async fn an_exact_fit_with_an_error_model_is_refused() {
    let app = TestApp::start().await;
    let nodes = json!({"type": "grid", "u": [0, 1, 2, 3, 4], "v": [0, 1, 2, 3], "z": vec![[0; 4]; 5]});
    let level = json!({"nodes": nodes, "model": {"type": "polynomial", "degree": 1}});
    for (name, value) in [
        ("errors", json!({"type": "ar1", "along": "v"})),
        ("variance", json!("hc3")),
        ("variance", json!({"groups": (0..20).map(|k| k % 2).collect::<Vec<_>>()})),
    ] {
        let mut asked = level.clone();
        asked[name] = value;
        let answer = app.fit(&asked.to_string()).await;
        assert_eq!(answer.status, 422, "{}", answer.text);
        let fault = &answer.json()["errors"][0];
        assert_eq!(fault["pointer"], format!("/{name}"));
        assert!(fault["detail"].as_str().unwrap().contains("fits every height exactly"), "{fault}");
    }
}

/// A grid of `side²` nodes with a polynomial of `degree`, whose positions are off.
fn rough(side: u32, degree: u32, position: f64, height: f64) -> Value {
    let at: Vec<f64> = (0..side).map(|k| f64::from(k) / f64::from(side)).collect();
    let wave = |u: f64, v: f64| (1000.0 * (1.0 + u) * (1.7 + v)).sin();
    let z: Vec<Vec<f64>> = at.iter().map(|&u| at.iter().map(|&v| wave(u, v)).collect()).collect();
    json!({
        "nodes": {"type": "grid", "u": at, "v": at, "z": z},
        "model": {"type": "polynomial", "degree": degree},
        "node_uncertainty": {"position": position, "height": height, "position_kind": "measured"},
    })
}

#[tokio::test]
async fn positions_ask_for_no_more_work_than_there_is_time_for() {
    let app = TestApp::start().await;
    let answer = app.fit(&rough(45, 20, 0.01, 0.01).to_string()).await;
    assert_eq!(answer.status, 422, "{}", answer.text);
    let fault = &answer.json()["errors"][0];
    assert_eq!(fault["pointer"], "/node_uncertainty/position_kind");
    assert!(fault["detail"].as_str().unwrap().contains("too long"), "{fault}");
    // what does not settle says where to change what
    let answer = app.fit(&rough(12, 5, 0.3, 0.1).to_string()).await;
    assert_eq!(answer.status, 422, "{}", answer.text);
    assert_eq!(answer.json()["code"], "not_converged");
    assert_eq!(answer.json()["errors"][0]["pointer"], "/node_uncertainty");
}

#[tokio::test]
async fn uncertainties_of_any_size_are_answered() {
    let app = TestApp::start().await;
    for size in [5e-324, 1e-300, 1e-150] {
        let answer = app.fit(&rough(5, 2, size, size).to_string()).await;
        assert!(answer.status == 200 || answer.status == 422, "{size}: {}", answer.text);
    }
    let answer = app.fit(&rough(5, 2, 5e-324, 5e-324).to_string()).await.json();
    assert_eq!(answer["positions"].get("sigma_ratio"), None, "{answer}");
}

/// Letters drawn at random, one for each node: A is -0.5, Z is 0.5.
const SCATTER: &[u8; 45] = b"TDZQUOUEIUZJWJHUTXDHISRNWOUCCNQGMMAGYIOJXWTHO";

/// Returns the warnings of a fit over 9 × 5 nodes; the height gets the place and the scatter.
async fn warned(app: &TestApp, estimator: Value, height: impl Fn(f64, f64, f64) -> f64) -> Vec<Value> {
    let (u, v): (Vec<f64>, Vec<f64>) = ((0..9).map(f64::from).collect(), (0..5).map(f64::from).collect());
    let scatter = |k: usize| f64::from(SCATTER[k]) / 25.0 - 3.1;
    let z: Vec<Vec<f64>> = (0..9).map(|i| (0..5).map(|j| height(u[i], v[j], scatter(5 * i + j))).collect()).collect();
    let body = json!({
        "nodes": {"type": "grid", "u": u, "v": v, "z": z},
        "model": {"type": "polynomial", "degree": [2, 2]},
        "estimator": estimator,
    });
    app.fit(&body.to_string()).await.json()["warnings"].as_array().unwrap().clone()
}

#[tokio::test]
async fn residuals_that_contradict_the_assumptions_are_reported() {
    let app = TestApp::start().await;
    let plain = || json!({"type": "least_squares"});
    let find = |warnings: &[Value], code: &str| {
        warnings
            .iter()
            .find(|warning| warning["code"] == code)
            .unwrap_or_else(|| panic!("{code}: {warnings:?}"))
            .clone()
    };
    let clean = warned(&app, plain(), |u, v, noise| u * v + noise).await;
    assert!(clean.iter().all(|warning| warning["code"] == "norm_limit_is_estimate"), "{clean:?}");
    let bent = warned(&app, plain(), |u, _, noise| 0.05 * u.powi(3) + 0.3 * noise).await;
    let lack = find(&bent, "lack_of_fit");
    assert_eq!(lack["params"]["shape"], "next_order");
    assert!(number(&lack["params"]["rms"]) > 0.1 && number(&lack["params"]["factor"]) > 1.5, "{lack}");
    let rough = warned(&app, plain(), |u, _, noise| noise * if (1.0..=7.0).contains(&u) { 1.0 } else { 12.0 }).await;
    let uneven = find(&rough, "uneven_variance");
    assert_eq!((&uneven["params"]["along"], &uneven["params"]["larger"]), (&json!("u"), &json!("ends")));
    assert!(uneven["message"].as_str().unwrap().contains("`hc3`"), "{uneven}");
    let tukey = json!({"type": "m_estimator", "loss": "tukey", "start": "least_trimmed_squares"});
    let corner = warned(&app, tukey, |u, v, noise| noise + if u > 6.0 && v > 2.0 { 30.0 } else { 0.0 }).await;
    let cluster = find(&corner, "clustered_low_weights");
    assert_eq!((&cluster["params"]["count"], &cluster["params"]["place"]), (&json!(4), &json!([7.5, 3.5])));
}
