//! The matrix B of a representative piece over HTTP: posted, taken from a stored fit, replayed,
//! used by a stream, refused by pointer.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{TestApp, send};

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_representative").unwrap();
    serde_json::from_str(example.text).unwrap()
}

/// A profile of a tooth: raw powers far from 0, which depend on each other.
fn profile(seed: usize, regularization: Value) -> Value {
    let x: Vec<f64> = (0..15).map(|k| 30.0 + 4.0 * k as f64 / 14.0).collect();
    let noise = |k: usize| ((37 * k + 11 * seed * seed + 5 * seed) % 29) as f64 / 29.0 - 0.5;
    let y: Vec<f64> = x.iter().enumerate().map(|(k, x)| 0.4 * (x - 31.0).powi(2) + 0.2 * noise(k)).collect();
    json!({"nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 3},
           "regularization": regularization})
}

fn spectral() -> Value {
    json!({"type": "spectral", "count": 2, "lambda_star": {"criterion": "min_condition"}})
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value}")).iter().map(|x| x.as_f64().unwrap()).collect()
}

fn values(fit: &Value) -> Vec<f64> {
    fit["coefficients"].as_array().unwrap().iter().map(|c| c["value"].as_f64().unwrap()).collect()
}

async fn job(app: &TestApp) -> String {
    let job = send(app.post("/v1/jobs", json!({"name": "pieces"}).to_string())).await.json();
    format!("/v1/jobs/{}", job["id"].as_str().unwrap())
}

async fn stored(app: &TestApp, path: &str, body: &Value) -> Value {
    let answer = send(app.post(path, body.to_string())).await;
    assert_eq!(answer.status, 201, "{}", answer.text);
    answer.json()
}

/// A returned piece has for other nodes the effect of a given λ*.
#[tokio::test]
async fn a_piece_is_answered_and_posted() {
    let app = TestApp::start().await;
    let mut first = profile(1, spectral());
    first["include"] = json!(["representative"]);
    let first = app.fit(&first.to_string()).await.json();
    let piece = &first["representative"];
    assert_eq!((&piece["model"]["degree"], &piece["scheme"]), (&json!(3), &json!("first_order")));
    assert_eq!(numbers(&piece["eigenvalues"]), numbers(&first["spectrum"]["eigenvalues"])[..2]);
    assert_eq!(piece["lambda_star"], first["regularization"]["lambda_star"]);

    let by_piece = profile(2, json!({"type": "representative", "piece": piece}));
    let found = app.fit(&by_piece.to_string()).await.json();
    let report = &found["regularization"];
    assert_eq!(
        (&report["type"], &report["count"], &report["criterion"]),
        (&json!("representative"), &json!(2), &json!("fixed"))
    );
    assert!(report["representative"]["alignment"].as_f64().unwrap() > 1.0 - 1e-6, "{report}");
    assert!(report["representative"].get("iteration").is_none());
    let mut given = spectral();
    given["lambda_star"] = json!({"criterion": "fixed", "value": piece["lambda_star"]});
    let given = app.fit(&profile(2, given).to_string()).await.json();
    for (a, b) in values(&found).into_iter().zip(values(&given)) {
        assert!((a - b).abs() < 1e-6 * b.abs(), "{a} {b}");
    }
    // what was asked is a request of its own
    let mut again = found["spec"].clone();
    again["nodes"] = by_piece["nodes"].clone();
    assert_eq!(app.fit(&again.to_string()).await.json()["coefficients"], found["coefficients"]);
}

#[tokio::test]
async fn a_stored_fit_is_the_piece_of_others_and_stays_it() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let iterations = format!("{job}/iterations");
    let first = stored(&app, &iterations, &profile(1, spectral())).await;
    let by_first = json!({"type": "representative", "iteration": 1});
    let second = stored(&app, &iterations, &profile(2, by_first.clone())).await;
    let fit = &second["fits"][0];
    let report = &fit["result"]["regularization"];
    assert_eq!(report["representative"]["iteration"], 1);
    assert_eq!(report["representative"]["fit_id"], first["fits"][0]["id"]);
    assert_eq!(report["lambda_star"], first["fits"][0]["result"]["regularization"]["lambda_star"]);
    // with the fit is kept what was used of the piece
    let kept = &fit["spec"]["regularization"];
    assert_eq!((&kept["iteration"], &kept["fit_id"]), (&json!(1), &first["fits"][0]["id"]));
    assert_eq!(kept["piece"]["directions"].as_array().unwrap().len(), 2);

    // another fit of the piece is chosen from now on: fits that used the first one keep it
    let other = json!({"model": {"type": "polynomial", "degree": 3},
                       "regularization": {"type": "spectral", "count": 1}});
    let other = stored(&app, &format!("{iterations}/1/fits"), &other).await;
    let chosen = json!({"fit_id": other["id"]}).to_string();
    let chosen = send(app.put(&format!("{iterations}/1/chosen-fit"), chosen)).await;
    assert_eq!(chosen.status, 200, "{}", chosen.text);
    let path = format!("{iterations}/2/fits/{}", fit["id"].as_str().unwrap());
    assert_eq!(send(app.post(&format!("{path}/replay"), "")).await.json(), json!({"identical": true}));
    let more = send(app.get(&format!("{path}?include=matrix_b"))).await.json();
    assert_eq!(more["result"]["matrix_b"].as_array().unwrap().len(), 15);
    let refit =
        |regularization: Value| json!({"model": {"type": "polynomial", "degree": 3}, "regularization": regularization});
    let now = stored(&app, &format!("{iterations}/2/fits"), &refit(by_first)).await;
    assert_eq!(now["result"]["regularization"]["representative"]["fit_id"], other["id"]);
    assert_eq!(now["result"]["regularization"]["count"], 1);
    let named = json!({"type": "representative", "iteration": 1, "fit_id": first["fits"][0]["id"]});
    let named = stored(&app, &format!("{iterations}/2/fits"), &refit(named)).await;
    assert_eq!(named["result"], fit["result"]);

    // a stream takes the piece itself
    let stream = refit(json!({"type": "representative", "piece": kept["piece"]}));
    let stream = stored(&app, &format!("{job}/streams"), &stream).await;
    let blocks = format!("/v1/streams/{}/nodes", stream["id"].as_str().unwrap());
    let block = json!({"sequence": 1, "nodes": profile(2, json!({}))["nodes"]});
    let estimate = send(app.post(&blocks, block.to_string())).await.json();
    for (a, b) in values(&estimate["result"]).into_iter().zip(values(&fit["result"])) {
        assert!((a - b).abs() < 1e-6 * b.abs(), "{a} {b}");
    }
}

/// Errors of a piece that was looked up are reported at the iteration that was sent.
#[tokio::test]
async fn an_iteration_without_a_piece_of_use_is_pointed_at() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let iterations = format!("{job}/iterations");
    stored(&app, &iterations, &profile(1, spectral())).await;
    let nothing = stored(&app, &iterations, &profile(2, json!({"type": "spectral", "count": 0}))).await;
    assert_eq!(nothing["fits"][0]["result"]["regularization"]["count"], 0);
    let refused = async |path: &str, body: Value| {
        let answer = send(app.post(path, body.to_string())).await;
        assert_eq!(answer.status, 422, "{}", answer.text);
        let errors = answer.json()["errors"].clone();
        assert_eq!(errors.as_array().map(Vec::len), Some(1), "{errors}");
        assert_eq!(errors[0]["pointer"], "/regularization/iteration");
        errors[0]["detail"].as_str().unwrap().to_owned()
    };
    let by = |number: usize| json!({"type": "representative", "iteration": number});
    let of_nothing = refused(&iterations, profile(3, by(2))).await;
    assert!(of_nothing.contains("L = 0") && !of_nothing.contains("(`spectral`)"), "{of_nothing}");
    let other = json!({"model": {"type": "polynomial", "degree": 2}, "regularization": by(1)});
    for path in [format!("{iterations}/2/fits"), format!("{iterations}/2/preview")] {
        assert!(refused(&path, other.clone()).await.contains("another model"));
    }
    let of_stream = json!({"model": {"type": "polynomial", "degree": 3}, "regularization": by(1)});
    let said = refused(&format!("{job}/streams"), of_stream).await;
    assert!(said.contains("a stream does not use other fits"), "{said}");
}

#[tokio::test]
async fn invalid_pieces_are_refused_with_their_pointer() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let iterations = format!("{job}/iterations");
    stored(&app, &iterations, &profile(1, json!({"type": "ridge"}))).await;
    let at = |path: &str, regularization: Value| app.post(path, profile(2, regularization).to_string());
    let with = |name: &str, value: Value| {
        let mut piece = example()["regularization"]["piece"].clone();
        piece[name] = value;
        json!({"type": "representative", "piece": piece})
    };
    let id = "0190b0de-0000-7000-8000-000000000000";
    let piece = "/regularization/piece";
    let cases = [
        ("/v1/fits", json!({"type": "representative"}), "/regularization".to_owned()),
        ("/v1/fits", json!({"type": "representative", "iteration": 1}), "/regularization/iteration".to_owned()),
        ("/v1/fits", json!({"type": "representative", "iteration": 0}), "/regularization/iteration".to_owned()),
        ("/v1/fits", json!({"type": "representative", "fit_id": id}), "/regularization/fit_id".to_owned()),
        ("/v1/fits", json!({"type": "representative", "fit_id": "1"}), "/regularization/fit_id".to_owned()),
        ("/v1/fits", json!({"type": "representative", "piece": {}}), format!("{piece}/model")),
        ("/v1/fits", with("model", json!({"type": "polynomial"})), format!("{piece}/model/degree")),
        ("/v1/fits", with("model", json!({"type": "polynomial", "degree": 7})), format!("{piece}/model")),
        ("/v1/fits", with("lambda", json!(1)), format!("{piece}/lambda")),
        ("/v1/fits", with("scale", json!([1, 2])), format!("{piece}/scale")),
        (&iterations, json!({"type": "representative", "iteration": 7}), "/regularization/iteration".to_owned()),
        (&iterations, json!({"type": "representative", "iteration": 1}), "/regularization/iteration".to_owned()),
        (
            &iterations,
            json!({"type": "representative", "iteration": 1, "fit_id": id}),
            "/regularization/fit_id".to_owned(),
        ),
    ];
    for (path, regularization, pointer) in cases {
        let answer = send(at(path, regularization.clone())).await;
        assert_eq!(answer.status, 422, "{regularization}: {}", answer.text);
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{}", answer.text);
    }
}
