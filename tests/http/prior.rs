//! Prior of earlier iterations over HTTP: a job whose machine is corrected, replays, conflicts, and
//! refusals with their pointers.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{Answer, TestApp, send};

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

fn places() -> impl Iterator<Item = (f64, f64)> {
    U.into_iter().flat_map(|u| V.into_iter().map(move |v| ((u - 9.0) / 3.0, (v - 7.5) / 6.5)))
}

/// Heights in mm of a flank with level, tilts along u and v (µm), and noise of its own.
fn flank(seed: usize, [level, along_u, along_v]: [f64; 3], prior: Option<Value>) -> Value {
    let noise = |k: usize| ((37 * k + 11 * seed * seed + 5 * seed) % 29) as f64 / 29.0 - 0.5;
    let heights: Vec<f64> =
        places().enumerate().map(|(k, (u, v))| (level + along_u * u + along_v * v + 0.6 * noise(k)) / 1000.0).collect();
    let rows: Vec<&[f64]> = heights.chunks(V.len()).collect();
    let axes = json!({"z": {"quantity": "deviation", "unit": "mm", "positive": "material_out"}});
    let mut body = json!({"nodes": {"type": "grid", "u": U, "v": V, "z": rows}, "flank": "left", "tooth": "1",
                          "axes": axes, "model": {"type": "polynomial", "degree": 1, "terms": "total",
                          "basis": "legendre"}, "domain": {"u": [6, 12], "v": [1, 14]}});
    if let Some(prior) = prior {
        body["prior"] = prior;
    }
    body
}

async fn job(app: &TestApp) -> String {
    let made = send(app.post("/v1/jobs", r#"{"name":"wheel"}"#)).await;
    format!("/v1/jobs/{}", made.json()["id"].as_str().unwrap())
}

async fn measure(app: &TestApp, job: &str, body: &Value) -> Value {
    let made = send(app.post(&format!("{job}/iterations"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made.json()
}

async fn refit(app: &TestApp, job: &str, number: u32, prior: Value) -> Answer {
    let flank = flank(0, [0.0; 3], None);
    let body = json!({"model": flank["model"], "domain": flank["domain"], "prior": prior});
    send(app.post(&format!("{job}/iterations/{number}/fits"), body.to_string())).await
}

async fn correct(app: &TestApp, job: &str, number: u32) -> Value {
    let rows: Vec<[f64; 2]> = places().map(|(u, v)| [u, v]).collect();
    let body =
        json!({"sensitivity": {"type": "matrix", "settings": ["a", "b"], "matrix": rows}, "noise_sigma_um": 0.2});
    let made = send(app.post(&format!("{job}/iterations/{number}/correction"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    send(app.get(&format!("{job}/iterations/{number}/correction"))).await.json()["id"].clone()
}

async fn replayed(app: &TestApp, job: &str, number: u32, fit: &Value) -> Value {
    let place = format!("{job}/iterations/{number}/fits/{}/replay", fit.as_str().unwrap());
    send(app.post(&place, "{}")).await.json()
}

fn value(result: &Value, j: usize, name: &str) -> f64 {
    result["coefficients"][j][name].as_f64().unwrap_or_else(|| panic!("{result}"))
}

fn previous() -> Value {
    json!({"iterations": "previous"})
}

/// Levels and tilts in µm as five iterations had them: before the correction, and after.
const BEFORE: [f64; 3] = [3.0, 8.0, -6.0];
const AFTER: [f64; 3] = [3.0, 0.0, 0.0];

/// A job of five iterations, corrected after the second; the fit of the fifth, and the record.
async fn corrected(app: &TestApp) -> (String, Value, Value) {
    let job = job(app).await;
    let first = measure(app, &job, &flank(1, BEFORE, Some(previous()))).await;
    let alone = &first["fits"][0]["result"];
    assert_eq!(
        (&alone["prior"]["iterations"], &alone["warnings"][0]["code"]),
        (&json!([]), &json!("no_earlier_iterations"))
    );
    assert_eq!(alone["coefficients"][0]["interval_kind"], "student");
    measure(app, &job, &flank(2, BEFORE, None)).await;
    let record = correct(app, &job, 2).await;
    measure(app, &job, &flank(3, AFTER, None)).await;
    // of another tooth: none of the chain
    let mut other = flank(9, [50.0, 1.0, 1.0], None);
    other["tooth"] = json!("2");
    measure(app, &job, &other).await;
    measure(app, &job, &flank(4, AFTER, None)).await;
    let last = measure(app, &job, &flank(5, AFTER, Some(previous()))).await;
    (job, last, record)
}

#[tokio::test]
async fn five_iterations_and_a_correction() {
    let app = TestApp::start().await;
    let (job, last, record) = corrected(&app).await;
    let (fit, result) = (&last["fits"][0], &last["fits"][0]["result"]);
    let prior = &result["prior"];
    assert_eq!(prior["iterations"], json!([1, 2, 3, 5]));
    assert_eq!(prior["corrections"], json!([{"iteration": 2, "record_id": record}]));
    assert_eq!(prior["conflict"]["dropped"], false, "{prior}");
    assert_eq!(prior["degrees_of_freedom"], 5 * 17);
    let chosen = async |number: u32| {
        let fits = send(app.get(&format!("{job}/iterations/{number}/fits"))).await.json();
        fits["items"].as_array().unwrap().iter().find(|fit| fit["chosen"] == true).unwrap()["id"].clone()
    };
    for (k, number) in [1, 2, 3, 5].into_iter().enumerate() {
        assert_eq!(prior["fit_ids"][k], chosen(number).await);
    }
    // better known than by its nodes alone, and as the flank is
    for (j, truth) in [AFTER[0], AFTER[2], AFTER[1]].into_iter().enumerate() {
        let share = prior["share"][j].as_f64().unwrap();
        let (error, alone) = (value(result, j, "std_error"), value(result, j, "least_squares_std_error"));
        assert!(share > 0.4 && share < 0.9 && error < alone, "{share} {error} {alone}");
        assert!((value(result, j, "value") - truth / 1000.0).abs() < 4.0 * error, "{result}");
        let coefficient = &result["coefficients"][j];
        assert_eq!(coefficient["interval_kind"], "posterior");
        assert!(value(result, j, "interval_gain") < 1.0 && coefficient["least_squares_interval"].is_array());
        let [low, high] = [0, 1].map(|end| coefficient["interval"][end].as_f64().unwrap());
        for name in ["value", "least_squares"] {
            assert!((low..=high).contains(&value(result, j, name)), "{name}: {coefficient}");
        }
    }
    assert_eq!(result["bias"]["coefficient_norm_limit_source"], "prior");
    let factors: Vec<f64> = serde_json::from_value(result["regularization"]["filter_factors"].clone()).unwrap();
    assert!(factors.len() == 3 && factors.iter().all(|f| *f > 0.0 && *f < 0.9), "{factors:?}");
    let (alone, together) = (&result["spectrum"]["eigenvalues"], &result["spectrum"]["regularized"]["eigenvalues"]);
    assert!(together[0].as_f64() > alone[0].as_f64());
    // what is stored says which iterations, and is a request of its own
    assert_eq!(fit["spec"]["prior"], json!({"iterations": [1, 2, 3, 5], "move": "estimated", "correction": true}));
    assert_eq!(fit["spec"]["regularization"], json!({"type": "none"}));
    let again = refit(&app, &job, 6, fit["spec"]["prior"].clone()).await.json();
    assert_eq!(again["result"], *result);
    // without the correction the tilts have moved by some tens of standard errors
    let uncorrected = refit(&app, &job, 6, json!({"iterations": "previous", "correction": false})).await.json();
    let ratio = |result: &Value| result["prior"]["move_ratio"].as_f64().unwrap();
    assert!(ratio(&uncorrected["result"]) > 5.0 * ratio(result));
    assert_eq!(uncorrected["result"]["prior"]["corrections"], json!([]));
    // the story of the job names the fits and corrections that the fit used
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    let traced = &trace["iterations"][5]["fits"][0];
    assert_eq!(traced["prior"], *prior);
    assert_eq!(trace["iterations"][1]["fits"][0].get("prior"), None);
}

#[tokio::test]
async fn a_replay_uses_the_same_iterations_later() {
    let app = TestApp::start().await;
    let (job, last, _) = corrected(&app).await;
    let fit = &last["fits"][0]["id"];
    assert_eq!(replayed(&app, &job, 6, fit).await, json!({"identical": true}));
    // another correction of the second iteration, another fit of the third, one more iteration
    let rows: Vec<[f64; 1]> = places().map(|(u, _)| [u]).collect();
    let other = json!({"sensitivity": {"type": "matrix", "settings": ["a"], "matrix": rows}, "noise_sigma_um": 0.2});
    let kept = send(app.post(&format!("{job}/iterations/2/correction"), other.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let further = refit(&app, &job, 3, previous()).await.json();
    let choice = app.client.put(app.url(&format!("{job}/iterations/3/chosen-fit")));
    assert_eq!(send(choice.json(&json!({"fit_id": further["id"]}))).await.status, 200);
    measure(&app, &job, &flank(6, AFTER, None)).await;
    assert_eq!(replayed(&app, &job, 6, fit).await, json!({"identical": true}));
    assert_eq!(replayed(&app, &job, 3, &further["id"]).await, json!({"identical": true}));
    let first = send(app.get(&format!("{job}/iterations/1/fits"))).await.json()["items"][0]["id"].clone();
    assert_eq!(replayed(&app, &job, 1, &first).await, json!({"identical": true}));
    // a part requested later is of the same posterior
    let place = format!("{job}/iterations/6/fits/{}?include=covariance", fit.as_str().unwrap());
    let result = send(app.get(&place)).await.json()["result"].clone();
    let variance = result["covariance"]["coefficients"][1][1].as_f64().unwrap();
    assert!((variance.sqrt() / value(&result, 1, "std_error") - 1.0).abs() < 1e-12);
    // a new fit uses the present state
    let now = refit(&app, &job, 6, previous()).await.json();
    assert_eq!(now["result"]["prior"]["fit_ids"][2], further["id"]);
    assert_ne!(now["result"]["provenance"]["input_sha256"], result["provenance"]["input_sha256"]);
}

#[tokio::test]
async fn a_changed_tool_lets_the_prior_go() {
    let app = TestApp::start().await;
    let (job, _, _) = corrected(&app).await;
    let changed = measure(&app, &job, &flank(7, [3.0, 6.0, 5.0], Some(previous()))).await;
    let result = &changed["fits"][0]["result"];
    let conflict = &result["prior"]["conflict"];
    assert!(conflict["dropped"] == true && conflict["p"].as_f64().unwrap() < 1e-4, "{conflict}");
    assert!(result["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "prior_conflict"), "{result}");
    assert_eq!(result["coefficients"][0]["value"], result["coefficients"][0]["least_squares"]);
    assert_eq!(result["prior"]["share"], json!([0.0, 0.0, 0.0]));
    assert_eq!(replayed(&app, &job, 7, &changed["fits"][0]["id"]).await, json!({"identical": true}));
}

#[tokio::test]
async fn invalid_priors_are_refused() {
    let app = TestApp::start().await;
    let (job, _, _) = corrected(&app).await;
    let mut curve = json!({"nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [0, 1, 0, 2]}, "flank": "left",
                           "tooth": "1", "axes": flank(0, [0.0; 3], None)["axes"],
                           "model": {"type": "polynomial", "degree": 1}});
    curve["axes"] = json!({"y": curve["axes"]["z"]});
    for (prior, pointer, detail) in [
        (json!({"iterations": [1, 40]}), "/prior/iterations/1", "no iteration 40"),
        (json!({"iterations": [2, 6]}), "/prior/iterations/1", "not earlier"),
        (json!({"iterations": [2, 4]}), "/prior/iterations/1", "tooth 2"),
        (json!({"iterations": [2, 1]}), "/prior/iterations/1", "does not come after"),
        (json!({"iterations": "all"}), "/prior/iterations", "previous"),
        (json!({"iterations": "previous", "move": [1.0]}), "/prior/move", "3 coefficients"),
        (json!({"iterations": "previous", "move": [1.0, 1.0, -1.0]}), "/prior/move/2", "above 0"),
        (json!({"iteration": [1]}), "/prior/iteration", "iterations"),
        (json!({"mean": [1.0, 2.0], "std_error": [1.0, 1.0, 1.0]}), "/prior/mean", "3 coefficients"),
    ] {
        let refused = refit(&app, &job, 6, prior.clone()).await;
        let problem = refused.problem(422, "invalid_request");
        assert_eq!(refused.pointers(), [pointer], "{prior} {problem}");
        assert!(problem.to_string().contains(detail), "{problem}");
    }
    // nodes of another kind, and other axes
    let iterations = format!("{job}/iterations");
    curve["prior"] = previous();
    let refused = send(app.post(&iterations, curve.to_string())).await;
    assert_eq!(refused.pointers(), ["/prior/iterations"], "{}", refused.text);
    let mut turned = flank(5, AFTER, Some(json!({"iterations": [1]})));
    turned["axes"]["z"]["positive"] = json!("material_in");
    assert_eq!(send(app.post(&iterations, turned.to_string())).await.pointers(), ["/prior/iterations/0"]);
    // of the other flank
    let mut right = flank(5, AFTER, Some(json!({"iterations": [1]})));
    right["flank"] = json!("right");
    let refused = send(app.post(&iterations, right.to_string())).await;
    assert_eq!(refused.pointers(), ["/prior/iterations/0"], "{}", refused.text);
    assert!(refused.text.contains("left"), "{}", refused.text);
    // an iteration to come
    let later = flank(5, AFTER, Some(json!({"iterations": [1, 7]})));
    assert_eq!(send(app.post(&iterations, later.to_string())).await.pointers(), ["/prior/iterations/1"]);
    // a filter on top
    let mut both = flank(5, AFTER, Some(previous()));
    both["regularization"] = json!({"type": "ridge", "parameter": {"criterion": "gcv"}});
    let refused = send(app.post(&iterations, both.to_string())).await;
    assert_eq!(refused.pointers(), ["/regularization"]);
    assert!(refused.text.contains("excludes regularisation"), "{}", refused.text);
    // nothing was stored
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 6);
    // without a job there are no iterations, for a stream none yet
    let body = flank(5, AFTER, Some(previous()));
    assert_eq!(app.fit(&body.to_string()).await.pointers(), ["/prior/iterations"]);
    let stream = json!({"model": body["model"], "domain": body["domain"], "prior": previous()});
    assert_eq!(send(app.post(&format!("{job}/streams"), stream.to_string())).await.pointers(), ["/prior/iterations"]);
}

/// A prior above doubles is refused, and is no internal error.
#[tokio::test]
async fn a_prior_that_exceeds_double_precision_is_refused() {
    let app = TestApp::start().await;
    let nodes = json!({"type": "curve", "x": [0, 1, 2, 3, 4], "y": [0.1, 1.0, 2.2, 2.9, 4.1]});
    for (mean, std_error) in [(1.7e308, 1.0), (1e308, 1.0), (0.0, 5e-324), (0.0, 1e-308)] {
        let body = json!({"nodes": nodes, "model": {"type": "polynomial", "degree": 1},
                          "prior": {"mean": [mean, 0.0], "std_error": [std_error, 1.0]}});
        let refused = app.fit(&body.to_string()).await;
        refused.problem(422, "invalid_request");
        assert!(refused.pointers()[0].starts_with("/prior/"), "{mean} {std_error}: {}", refused.text);
    }
}

#[tokio::test]
async fn a_prior_that_is_posted() {
    let app = TestApp::start().await;
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_prior").unwrap();
    let request: Value = serde_json::from_str(example.text).unwrap();
    let body = app.fit(example.text).await.json();
    assert_eq!(body["prior"]["conflict"]["dropped"], false, "{body}");
    assert_eq!((body["prior"].get("iterations"), body["prior"].get("move")), (None, None));
    assert_eq!(body["prior"]["corrections"], json!([]));
    // the covariance may come whole
    let mut whole = request.clone();
    let c = request["prior"]["covariance"].clone();
    whole["prior"]["covariance"] =
        json!([[c[0][0], c[1][0], c[2][0]], [c[1][0], c[1][1], c[2][1]], [c[2][0], c[2][1], c[2][2]]]);
    assert_eq!(app.fit(&whole.to_string()).await.json(), body);
    // and the returned spec is the same again
    let mut again = body["spec"].clone();
    again["nodes"] = request["nodes"].clone();
    assert_eq!(app.fit(&again.to_string()).await.json(), body);
    for (covariance, pointer) in [
        (json!([[1.0], [2.0, 1.0], [0.0, 0.0, 1.0]]), "/prior/covariance"),
        (json!([[1.0], [0.0, -1.0], [0.0, 0.0, 1.0]]), "/prior/covariance"),
        (json!([[1.0], [0.0, 1.0]]), "/prior/covariance"),
        (json!([[1.0], [0.0], [0.0, 0.0, 1.0]]), "/prior/covariance/1"),
    ] {
        let mut wrong = request.clone();
        wrong["prior"]["covariance"] = covariance;
        assert_eq!(app.fit(&wrong.to_string()).await.pointers(), [pointer]);
    }
}

/// Moves of 0.1 nm: between two iterations there is next to nothing but the correction.
fn negligible_moves() -> Value {
    json!({"iterations": "previous", "move": [1e-7, 1e-7, 1e-7]})
}

/// Half of the proposed changes were entered. The prior takes these, whether they were entered
/// after the correction or with the measurement; without them it contradicts the nodes.
#[tokio::test]
async fn a_prior_uses_the_entered_changes() {
    let app = TestApp::start().await;
    let half = [BEFORE[0], 0.5 * BEFORE[1], 0.5 * BEFORE[2]];
    let entry = json!({"settings": {"a": -0.5 * BEFORE[1], "b": -0.5 * BEFORE[2]}});
    for with_measurement in [false, true] {
        let job = job(&app).await;
        measure(&app, &job, &flank(1, BEFORE, None)).await;
        measure(&app, &job, &flank(2, BEFORE, None)).await;
        let record = correct(&app, &job, 2).await;
        let applied = format!("{job}/iterations/2/correction/applied");
        let mut next = flank(3, half, Some(negligible_moves()));
        if with_measurement {
            next["applied"] = entry.clone();
        } else {
            // the later entry wins
            let first = json!({"settings": {"a": 5.0}});
            assert_eq!(send(app.post(&applied, first.to_string())).await.status, 201);
            assert_eq!(send(app.post(&applied, entry.to_string())).await.status, 201);
        }
        let made = measure(&app, &job, &next).await;
        let (fit, prior) = (&made["fits"][0]["id"], &made["fits"][0]["result"]["prior"]);
        let used = json!([{"iteration": 2, "record_id": record, "entered": [-4.0, 3.0]}]);
        assert_eq!(prior["corrections"], used, "{prior}");
        assert_eq!(prior["conflict"]["dropped"], false, "{prior}");
        // three times as many nodes as the last iteration alone has
        assert!(prior["share"].as_array().unwrap().iter().all(|share| share.as_f64().unwrap() > 0.6), "{prior}");
        for (j, truth) in [half[0], half[2], half[1]].into_iter().enumerate() {
            let result = &made["fits"][0]["result"];
            assert!((value(result, j, "value") - truth / 1000.0).abs() < 2e-4, "{result}");
        }
        // a later entry does not affect the fit
        let later = json!({"settings": {"a": -8.0, "b": 6.0}});
        assert_eq!(send(app.post(&applied, later.to_string())).await.status, 201);
        assert_eq!(replayed(&app, &job, 3, fit).await, json!({"identical": true}));
        // by the full changes the nodes contradict what was known
        let full = refit(&app, &job, 3, negligible_moves()).await.json();
        assert_eq!(full["result"]["prior"]["corrections"][0]["entered"], json!([-8.0, 6.0]));
        assert_eq!(full["result"]["prior"]["conflict"]["dropped"], true, "{full}");
    }
}

/// A correction of the gear between two iterations changes the flank as one of the iteration does.
#[tokio::test]
async fn a_prior_takes_the_correction_of_the_gear() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    measure(&app, &job, &flank(1, BEFORE, None)).await;
    correct(&app, &job, 1).await;
    measure(&app, &job, &flank(2, BEFORE, None)).await;
    let rows: Vec<[f64; 2]> = places().map(|(u, v)| [u, v]).collect();
    let body =
        json!({"sensitivity": {"type": "matrix", "settings": ["a", "b"], "matrix": rows}, "noise_sigma_um": 0.2});
    let made = send(app.post(&format!("{job}/correction"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let made = made.json();
    let listed = json!({"iterations": [2], "move": [1e-7, 1e-7, 1e-7]});
    let last = measure(&app, &job, &flank(3, AFTER, Some(listed.clone()))).await;
    let prior = &last["fits"][0]["result"]["prior"];
    assert_eq!(prior["corrections"], json!([{"iteration": 2, "record_id": made["id"]}]));
    assert_eq!(prior["conflict"]["dropped"], false, "{prior}");
    for (j, truth) in [AFTER[0], AFTER[2], AFTER[1]].into_iter().enumerate() {
        let result = &last["fits"][0]["result"];
        assert!((value(result, j, "value") - truth / 1000.0).abs() < 2e-4, "{result}");
    }
    assert_eq!(replayed(&app, &job, 3, &last["fits"][0]["id"]).await, json!({"identical": true}));

    // what was entered of it goes before the proposal
    let entry = json!({"settings": {"a": 0.0, "b": 0.0}});
    assert_eq!(send(app.post(&format!("{job}/correction/applied"), entry.to_string())).await.status, 201);
    let again = refit(&app, &job, 3, listed).await.json();
    assert_eq!(again["result"]["prior"]["corrections"][0]["entered"], json!([0.0, 0.0]));
    assert_eq!(again["result"]["prior"]["conflict"]["dropped"], true, "{again}");
}
