//! Streams: blocks in their turn, the same estimate as at once, and what becomes of them.

use std::collections::BTreeSet;

use reqwest::Method;
use serde_json::{Value, json};
use tokio::task::JoinSet;

use super::app::{TestApp, send};

/// Node `i` of a track over a flank.
fn node(i: usize) -> (f64, f64, f64) {
    let t = i as f64;
    let (u, v) = (30.0 + 4.0 * (0.37 * t).fract(), 20.0 * (0.71 * t).fract());
    (u, v, 0.01 * u - 0.002 * v + 1e-3 * (3.0 * u + v).sin())
}

pub fn nodes(range: std::ops::Range<usize>) -> Value {
    let all: Vec<(f64, f64, f64)> = range.map(node).collect();
    let of = |f: &dyn Fn(&(f64, f64, f64)) -> f64| all.iter().map(f).collect::<Vec<f64>>();
    json!({"type": "scattered", "u": of(&|n| n.0), "v": of(&|n| n.1), "z": of(&|n| n.2)})
}

pub fn block(sequence: u64, range: std::ops::Range<usize>) -> Value {
    json!({"sequence": sequence, "nodes": nodes(range)})
}

pub fn spec() -> Value {
    json!({
        "model": {"type": "polynomial", "degree": [2, 2], "basis": "chebyshev"},
        "domain": {"u": [30.0, 34.0], "v": [0.0, 20.0]},
    })
}

fn numbers(value: &Value, pointer: &str) -> Vec<f64> {
    let list = value.pointer(pointer).and_then(Value::as_array).unwrap_or_else(|| panic!("{pointer}: {value}"));
    list.iter().map(|x| x.as_f64().or_else(|| x["value"].as_f64()).unwrap()).collect()
}

#[track_caller]
fn close(one: &Value, two: &Value, pointer: &str) {
    let (one, two) = (numbers(one, pointer), numbers(two, pointer));
    let size = one.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    assert_eq!(one.len(), two.len());
    assert!(one.iter().zip(&two).all(|(a, b)| (a - b).abs() <= 1e-12 * size), "{pointer}: {one:?} {two:?}");
}

/// With as many nodes as coefficients there is no noise to weigh a prior against yet.
#[tokio::test]
async fn a_prior_waits_for_noise() {
    let app = TestApp::start().await;
    let job = app.job().await;
    let asked = json!({
        "model": {"type": "polynomial", "degree": 1}, "regularization": {"type": "none"},
        "prior": {"mean": [0, 0], "std_error": [1, 1]},
    });
    let opened = app.post(&format!("{job}/streams"), &asked).await.expect(201);
    let stream = opened.header("location").unwrap().to_owned();
    for (sequence, code, at) in [
        (1, "fewer_nodes_than_coefficients", None),
        (2, "no_degrees_of_freedom", None),
        // now there is a result, which warns that the stream does not keep its nodes
        (3, "nodes_not_kept", Some("/result")),
    ] {
        let nodes = json!({"type": "curve", "x": [sequence], "y": [sequence * sequence]});
        let block = json!({"sequence": sequence, "nodes": nodes});
        let answer = app.post(&format!("{stream}/nodes"), &block).await.expect(200).json();
        let warnings = answer["warnings"].as_array().unwrap();
        assert_eq!(warnings.len(), 1, "{answer}");
        assert_eq!((warnings[0]["code"].as_str(), warnings[0]["at"].as_str()), (Some(code), at), "{answer}");
        assert_eq!(answer.get("result").is_some(), at.is_some(), "{answer}");
    }
}

#[tokio::test]
async fn a_stream_from_its_first_node_to_its_iteration() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let opened = app.post(&format!("{job}/streams"), &spec()).await.expect(201);
    let stream = opened.header("location").unwrap().to_owned();
    assert_eq!((opened.json()["sequence"].as_u64(), opened.header("etag")), (Some(0), Some("\"1\"")));
    assert_eq!(opened.json()["id"].as_str(), stream.rsplit('/').next());

    let first = app.post(&format!("{stream}/nodes"), &block(1, 0..5)).await.expect(200).json();
    assert_eq!((first["sequence"].as_u64(), first["node_count"].as_u64()), (Some(1), Some(5)));
    assert!(first.get("result").is_none());
    assert_eq!(first["warnings"][0]["code"], "fewer_nodes_than_coefficients");

    let mut seen = 5;
    for (sequence, end) in [(2, 30), (3, 31), (4, 60)] {
        let answer = app.post(&format!("{stream}/nodes"), &block(sequence, seen..end)).await.expect(200);
        assert_eq!(answer.header("etag"), Some(format!("\"{}\"", sequence + 1).as_str()));
        let answer = answer.json();
        seen = end;
        let mut batch = spec();
        batch["nodes"] = nodes(0..end);
        let batch = app.post("/v1/fits", &batch).await.expect(200).json();
        let result = &answer["result"];
        assert_eq!(
            (answer["node_count"].as_u64(), result["residuals"]["count"].as_u64()),
            (Some(end as u64), Some(end as u64))
        );
        for pointer in ["/coefficients", "/spectrum/eigenvalues", "/regularization/filter_factors"] {
            close(&batch, result, pointer);
        }
        assert_eq!(batch["regularization"]["criterion"], result["regularization"]["criterion"]);
        assert!(result["residuals"].get("max_abs").is_none() && batch["residuals"].get("max_abs").is_some());
        let codes: Vec<&str> =
            result["warnings"].as_array().unwrap().iter().filter_map(|w| w["code"].as_str()).collect();
        assert!(codes.contains(&"nodes_not_kept"), "{codes:?}");
        let shown = app.get(&stream).await.expect(200);
        assert_eq!(shown.json()["result"], *result);
        assert_eq!(shown.header("etag"), Some(format!("\"{}\"", sequence + 1).as_str()));
    }

    let mut batch = spec();
    batch["nodes"] = nodes(0..60);
    let batch = app.post("/v1/fits", &batch).await.expect(200);
    let finished = app.post(&format!("{stream}/finish"), &json!({"operator": "J. Doe"})).await.expect(201);
    let (result, _) = batch.text.split_once(",\"spec\":").unwrap();
    assert!(finished.text.contains(result), "the batch fit, bit by bit");
    let iteration = finished.json();
    assert_eq!((iteration["number"].as_u64(), iteration["operator"].as_str()), (Some(1), Some("J. Doe")));
    assert_eq!(finished.header("location"), Some(format!("{job}/iterations/1").as_str()));
    let fit = iteration["fits"][0]["id"].as_str().unwrap();
    let fit = app.get(&format!("{job}/iterations/1/fits/{fit}")).await.expect(200);
    assert!(finished.text.contains(&fit.text));
    assert_eq!(app.get(&format!("{job}/iterations/1/nodes")).await.expect(200).json(), nodes(0..60));

    let over = app.get(&stream).await.expect(200).json();
    assert_eq!((over["state"].as_str(), over["iteration_number"].as_u64()), (Some("finished"), Some(1)));
    app.post(&format!("{stream}/nodes"), &block(5, 60..61)).await.problem(409, "conflict");
    send(app.request(Method::POST, &format!("{stream}/finish"))).await.problem(409, "conflict");
    app.delete(&stream).await.expect(204);
    app.get(&stream).await.problem(404, "not_found");
    app.get(&format!("{job}/iterations/1")).await.expect(200);
    app.stop().await;
}

#[tokio::test]
async fn blocks_count_once_and_in_turn() {
    let mut app = TestApp::start().await;
    let stream = app.stream(&app.job().await, &spec()).await;
    let nodes_path = format!("{stream}/nodes");
    app.post(&nodes_path, &block(2, 0..5)).await.problem(409, "conflict");
    let first = app.post(&nodes_path, &block(1, 0..20)).await.expect(200);
    let second = app.post(&nodes_path, &block(2, 20..30)).await.expect(200);
    assert_eq!(app.post(&nodes_path, &block(2, 20..30)).await.expect(200).text, second.text);
    assert_eq!(app.post(&nodes_path, &block(1, 0..20)).await.expect(200).text, first.text);
    app.post(&nodes_path, &block(2, 20..31)).await.problem(409, "conflict");
    app.post(&nodes_path, &block(1, 1..21)).await.problem(409, "conflict");
    let gap = app.post(&nodes_path, &block(9, 30..31)).await;
    gap.problem(409, "conflict");
    assert!(gap.json()["detail"].as_str().unwrap().contains("block 3"), "{}", gap.text);
    assert_eq!(app.get(&stream).await.expect(200).json()["node_count"], 30);

    // what is refused takes no turn
    let outside = json!({"sequence": 3, "nodes": {"type": "scattered", "u": [40.0], "v": [1.0], "z": [0.0]}});
    assert_eq!(app.post(&nodes_path, &outside).await.problem(422, "invalid_request"), ["/nodes/u/0"]);
    let curve = json!({"sequence": 3, "nodes": {"type": "curve", "x": [31.0], "y": [1.0]}});
    assert_eq!(app.post(&nodes_path, &curve).await.problem(422, "invalid_request"), ["/nodes/type"]);
    assert_eq!(app.post(&nodes_path, &block(0, 30..31)).await.problem(422, "invalid_request"), ["/sequence"]);
    let faulty = json!({"nodes": {"type": "scattered", "u": [31.0], "v": [1.0], "z": ["x"]}, "model": {}});
    let pointers: BTreeSet<String> =
        app.post(&nodes_path, &faulty).await.problem(422, "invalid_request").into_iter().collect();
    assert!(pointers.contains("/model") && pointers.contains("/sequence") && pointers.contains("/nodes/z/0"));
    app.post(&nodes_path, &block(3, 30..31)).await.expect(200);

    // the same state after a restart, and the same responses
    let before = app.get(&stream).await.expect(200).text;
    app.restart().await;
    assert_eq!(app.get(&stream).await.expect(200).text, before);
    assert_eq!(app.post(&nodes_path, &block(2, 20..30)).await.expect(200).text, second.text);
    app.post(&nodes_path, &block(4, 31..32)).await.expect(200);
    app.stop().await;
}

/// Nodes that no later fit could take would spoil the stream for ever: their block is refused and
/// takes no turn.
#[tokio::test]
async fn numbers_whose_powers_are_no_doubles_are_refused_at_once() {
    let mut app = TestApp::start().await;
    let spec = json!({"model": {"type": "polynomial", "degree": [2, 2]}});
    let stream = app.stream(&app.job().await, &spec).await;
    let path = format!("{stream}/nodes");
    for (u, weight) in [(1e200, 1.0), (1e120, 1.0), (31.0, 1e300)] {
        let nodes = json!({"type": "scattered", "u": [u], "v": [1.0], "z": [1.0], "weight": [weight]});
        let answer = app.post(&path, &json!({"sequence": 1, "nodes": nodes})).await;
        assert_eq!(answer.problem(422, "invalid_request"), ["/nodes"], "{u} {weight}");
    }
    app.post(&path, &block(1, 0..20)).await.expect(200);
    assert_eq!(app.get(&stream).await.expect(200).json()["node_count"], 20);
    app.stop().await;
}

/// A stream cannot be changed later: a spec that its fit could never satisfy is refused at once.
#[tokio::test]
async fn predictions_that_no_fit_would_answer_are_refused_at_once() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let many: Vec<f64> = (0..400).map(f64::from).collect();
    for (predict, pointer) in [
        (json!({"at": {"x": [1.0]}}), "/predict/at"),
        (json!({"at": {"u": [1.0], "v": [1.0]}, "level": 0.2}), "/predict/level"),
        (json!({"at": {"grid": {"u": [], "v": []}}}), "/predict/at"),
        (json!({"at": {"grid": {"u": many, "v": many}}}), "/predict/at"),
    ] {
        let mut spec = spec();
        spec["predict"] = predict;
        let answer = app.post(&format!("{job}/streams"), &spec).await;
        let pointers = answer.problem(422, "invalid_request");
        assert!(pointers[0].starts_with(pointer), "{pointers:?}");
    }
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_clients_with_the_same_number_one_counts() {
    let mut app = TestApp::start().await;
    let stream = app.stream(&app.job().await, &spec()).await;
    let path = format!("{}{stream}/nodes", app.base);
    for sequence in 1..=10u64 {
        let start = 20 * sequence as usize;
        let mut clients = JoinSet::new();
        // four with the same nodes, four with others
        for client in 0..8 {
            let request = app.client.post(&path).json(&block(sequence, start + client / 4..start + 20));
            clients.spawn(async move { send(request).await });
        }
        let answers = clients.join_all().await;
        let counted: Vec<_> = answers.iter().filter(|a| a.status == 200).map(|a| a.text.clone()).collect();
        assert_eq!(counted.len(), 4, "one content is stored, and its repetitions answered");
        assert!(counted.iter().all(|text| *text == counted[0]));
        assert!(answers.iter().all(|a| a.status == 200 || a.status == 409));
    }
    assert_eq!(app.get(&stream).await.expect(200).json()["sequence"], 10);
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn finish_and_delete_race_with_nodes() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    for round in 0..6 {
        let stream = app.stream(&job, &spec()).await;
        app.post(&format!("{stream}/nodes"), &block(1, 0..20)).await.expect(200);
        let end = if round % 2 == 0 {
            app.request(Method::POST, &format!("{stream}/finish"))
        } else {
            app.request(Method::DELETE, &stream)
        };
        let add = app.request(Method::POST, &format!("{stream}/nodes")).json(&block(2, 20..30));
        let (ended, added) = tokio::join!(send(end), send(add));
        if round % 2 == 0 {
            ended.expect(201);
            let number = app.get(&stream).await.expect(200).json()["iteration_number"].as_u64().unwrap();
            let iteration = app.get(&format!("{job}/iterations/{number}")).await.expect(200).json();
            let counted = if added.status == 200 { 30 } else { 20 };
            assert_eq!(iteration["node_count"], counted);
        } else {
            assert!(ended.status == 204 && [200, 404].contains(&added.status.as_u16()), "{}", added.text);
            app.get(&stream).await.problem(404, "not_found");
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn forgetting_discounts_blocks_and_finish_counts_all() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let model = json!({"model": {"type": "polynomial", "degree": 0}, "regularization": {"type": "none"},
        "forgetting_factor": 0.5});
    let stream = app.stream(&job, &model).await;
    let curve = |sequence: u64, y: &[f64]| {
        let x: Vec<usize> = (0..y.len()).collect();
        json!({"sequence": sequence, "nodes": {"type": "curve", "x": x, "y": y}})
    };
    app.post(&format!("{stream}/nodes"), &curve(1, &[1.0, 1.0])).await.expect(200);
    let answer = app.post(&format!("{stream}/nodes"), &curve(2, &[5.0])).await.expect(200).json();
    // weights ¼, ½, 1
    let value = answer["result"]["coefficients"][0]["value"].as_f64().unwrap();
    assert!((value - 5.75 / 1.75).abs() < 1e-14, "{value}");
    let finished = send(app.request(Method::POST, &format!("{stream}/finish"))).await.expect(201).json();
    assert!((finished["fits"][0]["result"]["coefficients"][0]["value"].as_f64().unwrap() - 7.0 / 3.0).abs() < 1e-14);

    for (wrong, pointer) in [
        (json!({"model": {"type": "polynomial", "degree": 1}, "forgetting_factor": 0}), "/forgetting_factor"),
        (json!({"model": {"type": "polynomial", "degree": 1}, "forgetting_factor": 1.5}), "/forgetting_factor"),
        (json!({"model": {"type": "polynomial", "degree": 1, "basis": "legendre"}}), "/domain"),
        (json!({"model": {"type": "b_spline", "degree": 3, "spans": 4}}), "/domain"),
        (json!({"model": {"type": "polynomial", "degree": 1}, "nodes": {}}), "/nodes"),
        (json!({}), "/model"),
    ] {
        let refused = app.post(&format!("{job}/streams"), &wrong).await.problem(422, "invalid_request");
        assert_eq!(refused, [pointer], "{wrong}");
    }
    app.stop().await;
}

#[tokio::test]
async fn keys_tags_and_jobs_with_streams() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/streams");
    let one = app.post_keyed(&path, "open", &spec()).await.expect(201);
    let two = app.post_keyed(&path, "open", &spec()).await.expect(201);
    assert_eq!((one.text, two.header("idempotency-replayed")), (two.text.clone(), Some("true")));
    let stream = two.header("location").unwrap().to_owned();
    let add = format!("{stream}/nodes");
    let first = app.post_keyed(&add, "block", &block(1, 0..20)).await.expect(200);
    assert_eq!(app.post_keyed(&add, "block", &block(1, 0..20)).await.expect(200).text, first.text);
    app.post_keyed(&add, "block", &block(2, 20..21)).await.problem(422, "idempotency_key_reused");
    let finish = format!("{stream}/finish");
    let done = app.post_keyed(&finish, "done", &json!({})).await.expect(201);
    assert_eq!(app.post_keyed(&finish, "done", &json!({})).await.expect(201).text, done.text);

    let other_job = app.job().await;
    let other = app.stream(&other_job, &spec()).await;
    app.delete(&other_job).await.problem(409, "conflict");
    send(app.request(Method::DELETE, &other).header("If-Match", "\"7\"")).await.problem(412, "precondition_failed");
    send(app.request(Method::DELETE, &other).header("If-Match", "\"1\"")).await.expect(204);
    app.delete(&other_job).await.expect(204);
    app.post(&format!("{other_job}/streams"), &spec()).await.problem(404, "not_found");
    let nowhere = "/v1/streams/00000000-0000-7000-8000-000000000000";
    app.post(&format!("{nowhere}/nodes"), &block(1, 0..1)).await.problem(404, "not_found");
    send(app.request(Method::POST, &format!("{nowhere}/finish"))).await.problem(404, "not_found");
    app.delete(nowhere).await.problem(404, "not_found");
    let empty = app.stream(&job, &spec()).await;
    send(app.request(Method::POST, &format!("{empty}/finish"))).await.problem(409, "conflict");
    app.stop().await;
}

#[tokio::test]
async fn nodes_on_a_line_wait_for_others() {
    let mut app = TestApp::start().await;
    let stream = app.stream(&app.job().await, &json!({"model": {"type": "polynomial", "degree": [1, 1]}})).await;
    let line = |sequence: u64, v: f64| {
        json!({"sequence": sequence,
        "nodes": {"type": "scattered", "u": [1, 2, 3, 4, 5], "v": [v, v, v, v, v], "z": [1, 2, 1, 2, 1]}})
    };
    let waiting = app.post(&format!("{stream}/nodes"), &line(1, 0.0)).await.expect(200).json();
    assert!(waiting.get("result").is_none());
    assert_eq!(waiting["warnings"][0]["code"], "rank_deficient");
    assert_eq!(app.get(&stream).await.expect(200).json()["warnings"], waiting["warnings"]);
    let response = app.post(&format!("{stream}/nodes"), &line(2, 3.0)).await.expect(200).json();
    assert_eq!(response["result"]["spectrum"]["rank"], 4);
    app.stop().await;
}
