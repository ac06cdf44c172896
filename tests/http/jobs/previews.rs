//! Refits that store nothing, and the fitted heights.

use super::app::TestApp;
use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

fn example(operation: &str, name: &str) -> Value {
    let found = REQUEST_EXAMPLES.iter().find(|example| (example.operation_id, example.name) == (operation, name));
    serde_json::from_str(found.expect("there is such an example").text).unwrap()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[tokio::test]
async fn a_preview_equals_a_fit_of_the_nodes_and_stores_nothing() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let iteration = example("create_iteration", "iteration");
    let added = app.post(&format!("{job}/iterations"), &iteration).await.expect(201);
    let place = added.header("location").unwrap().to_owned();
    let (before, trace) = (app.get(&place).await.expect(200), app.get(&format!("{job}/trace")).await.expect(200));

    let asked = example("preview_iteration_fit", "preview");
    let preview = app.post(&format!("{place}/preview"), &asked).await.expect(200);
    let mut plain = asked.clone();
    plain["nodes"] = iteration["nodes"].clone();
    assert_eq!(preview.text, app.post("/v1/fits", &plain).await.expect(200).text);

    // what is stored is as it was, and what is kept afterwards is what was seen
    let after = app.get(&place).await.expect(200);
    assert_eq!((after.header("etag"), &after.text), (before.header("etag"), &before.text));
    assert_eq!(app.get(&format!("{job}/trace")).await.expect(200).text, trace.text);
    let kept = app.post(&format!("{place}/fits"), &asked).await.expect(201).json();
    for member in ["coefficients", "regularization", "residuals"] {
        assert_eq!(kept["result"][member], preview.json()[member], "{member}");
    }
    app.stop().await;
}

#[tokio::test]
async fn a_preview_has_the_same_prior_as_a_refit() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut iteration = example("create_iteration", "iteration");
    app.post(&format!("{job}/iterations"), &iteration).await.expect(201);
    iteration["nodes"]["z"][0][0] = json!(-4.1);
    let second = app.post(&format!("{job}/iterations"), &iteration).await.expect(201);
    let place = second.header("location").unwrap();
    let mut asked = example("create_iteration_fit", "refit_prior");
    asked.as_object_mut().unwrap().remove("reason");
    let preview = app.post(&format!("{place}/preview"), &asked).await.expect(200).json();
    let kept = app.post(&format!("{place}/fits"), &asked).await.expect(201).json();
    assert_eq!(preview["coefficients"], kept["result"]["coefficients"]);
    assert_eq!(preview["prior"]["iterations"], json!([1]));
    assert_eq!(preview["prior"], kept["result"]["prior"]);
    app.stop().await;
}

#[tokio::test]
async fn previews_are_refused_as_refits_are() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let place = app.iteration(&job).await;
    let path = format!("{place}/preview");
    for (body, pointer) in [
        (json!({"model": {"type": "polynomial", "degree": 2}, "reason": "none is kept"}), "/reason"),
        (json!({"model": {"type": "polynomial", "degree": 2}, "nodes": {}}), "/nodes"),
        (json!({"model": null}), "/model"),
        (json!({"model": {"type": "polynomial", "degree": 2}, "include": ["heights"]}), "/include/0"),
        (json!({"model": {"type": "polynomial", "degree": 9}}), "/model/degree"),
    ] {
        let refused = app.post(&path, &body).await;
        assert_eq!(refused.problem(422, "invalid_request"), [pointer], "{}", refused.text);
    }
    let model = json!({"model": {"type": "polynomial", "degree": 1}});
    app.post(&format!("{job}/iterations/9/preview"), &model).await.problem(404, "not_found");
    app.stop().await;
}

/// The fitted heights against the polynomial that the coefficients are of.
#[tokio::test]
async fn fitted_heights_are_those_of_the_coefficients() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut iteration = example("create_iteration", "iteration");
    iteration["nodes"]["z"][3][1] = json!(40.0);
    let added = app.post(&format!("{job}/iterations"), &iteration).await.expect(201);
    let path = format!("{}/preview", added.header("location").unwrap());
    let mut asked = json!({"model": {"type": "polynomial", "degree": [2, 2], "basis": "monomial"},
        "regularization": {"type": "none"}, "include": ["fitted", "residuals"]});
    let plain = app.post(&path, &asked).await.expect(200).json();
    let (u, v) = (numbers(&iteration["nodes"]["u"]), numbers(&iteration["nodes"]["v"]));
    let places: Vec<(usize, usize)> = (0..20).map(|k| (k / 4, k % 4)).filter(|place| *place != (2, 2)).collect();
    let posted: Vec<f64> = places.iter().map(|&(i, j)| iteration["nodes"]["z"][i][j].as_f64().unwrap()).collect();
    let by_coefficients = |answer: &Value| -> Vec<f64> {
        let value = |(i, j): (usize, usize)| {
            let terms = answer["coefficients"].as_array().unwrap().iter();
            let term = |one: &Value| {
                let power = |axis: usize| one["powers"][axis].as_i64().unwrap() as i32;
                one["value"].as_f64().unwrap() * u[i].powi(power(0)) * v[j].powi(power(1))
            };
            terms.map(term).sum()
        };
        places.iter().map(|&place| value(place)).collect()
    };
    let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    let (fitted, left) = (numbers(&plain["residuals"]["fitted"]), numbers(&plain["residuals"]["values"]));
    assert!(near(&fitted, &by_coefficients(&plain)), "{fitted:?} {}", plain["coefficients"]);
    assert!(near(&fitted.iter().zip(&left).map(|(f, r)| f + r).collect::<Vec<_>>(), &posted));
    assert_eq!(plain["residuals"]["node_indices"].as_array().unwrap().len(), 19);
    assert!(plain["residuals"].get("heights").is_none());

    // a filter that finds the peak: the returned heights are those that were fitted
    asked["filters"] = json!([{"type": "hampel", "window": 3, "action": "replace"}]);
    asked["include"] = json!(["fitted"]);
    let filtered = app.post(&path, &asked).await.expect(200).json();
    let (fitted, heights) = (numbers(&filtered["residuals"]["fitted"]), numbers(&filtered["residuals"]["heights"]));
    assert!(near(&fitted, &by_coefficients(&filtered)));
    let peak = places.iter().position(|place| *place == (3, 1)).unwrap();
    assert!(heights[peak] < 10.0 && posted[peak] == 40.0, "{heights:?}");
    assert!(filtered["residuals"].get("values").is_none());
    app.stop().await;
}
