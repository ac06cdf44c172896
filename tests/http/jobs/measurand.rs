//! Flank, tooth and axes of iterations and streams: given once, returned everywhere.

use reqwest::{
    Method,
    multipart::{Form, Part},
};
use serde_json::{Value, json};

use super::{
    app::{TestApp, iteration, send},
    streams,
};

fn axes() -> Value {
    json!({
        "u": {"quantity": "roll_length", "unit": "mm"},
        "v": {"quantity": "face_width", "unit": "mm"},
        "z": {"quantity": "deviation", "unit": "mm", "positive": "material_in"},
    })
}

fn add_measurand(body: &mut Value) {
    body["flank"] = json!("right");
    body["tooth"] = json!("7");
    body["axes"] = axes();
}

#[track_caller]
fn has_measurand(answer: &Value) {
    assert_eq!((&answer["flank"], &answer["tooth"]), (&json!("right"), &json!("7")), "{answer}");
    assert_eq!(answer["axes"], axes());
}

#[tokio::test]
async fn measurands_are_given_once_and_returned_everywhere() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut body = iteration();
    add_measurand(&mut body);
    let created = app.post(&format!("{job}/iterations"), &body).await.expect(201);
    has_measurand(&created.json());
    has_measurand(&app.get(created.header("location").unwrap()).await.expect(200).json());
    has_measurand(&app.get(&format!("{job}/trace")).await.expect(200).json()["iterations"][0]);

    let mut spec = json!({"model": {"type": "polynomial", "degree": 1}});
    add_measurand(&mut spec);
    let form = Form::new()
        .part("spec", Part::text(spec.to_string()).mime_str("application/json").unwrap())
        .part("nodes", Part::text("u,v,z\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n2,1,4\n").mime_str("text/csv").unwrap());
    let formed = send(app.request(Method::POST, &format!("{job}/iterations")).multipart(form)).await.expect(201);
    has_measurand(&formed.json());

    let mut spec = streams::spec();
    add_measurand(&mut spec);
    let opened = app.post(&format!("{job}/streams"), &spec).await.expect(201);
    has_measurand(&opened.json());
    let stream = opened.header("location").unwrap().to_owned();
    app.post(&format!("{stream}/nodes"), &streams::block(1, 0..20)).await.expect(200);
    app.restart().await;
    has_measurand(&app.get(&stream).await.expect(200).json());
    has_measurand(&app.post(&format!("{stream}/finish"), &json!({})).await.expect(201).json());

    // they are optional, and a fit that is not stored takes them too
    let without = app.post(&format!("{job}/iterations"), &iteration()).await.expect(201).json();
    assert!(["flank", "tooth", "axes"].iter().all(|key| without.get(key).is_none()), "{without}");
    let mut fit = json!({"nodes": super::app::nodes(), "model": {"type": "polynomial", "degree": 1}});
    add_measurand(&mut fit);
    app.post("/v1/fits", &fit).await.expect(200);
    app.stop().await;
}

#[tokio::test]
async fn invalid_measurands_are_refused_with_their_pointer() {
    let mut app = TestApp::start().await;
    let gear = json!({"teeth": 52, "normal_module_mm": 1.0});
    let job = app.post("/v1/jobs", &json!({"name": "w", "gear": gear})).await.expect(201);
    let job = job.header("location").unwrap().to_owned();
    let long = "x".repeat(201);
    for (key, value, pointer) in [
        ("flank", json!("up"), "/flank"),
        ("tooth", json!(""), "/tooth"),
        ("tooth", json!(3), "/tooth"),
        ("tooth", json!("53"), "/tooth"),
        ("tooth", json!("0k"), "/tooth"),
        ("tooth", json!(long), "/tooth"),
        ("axes", json!({"w": {"quantity": "deviation", "unit": "um"}}), "/axes/w"),
        ("axes", json!({"x": {"quantity": "roll_length", "unit": "mm"}}), "/axes/x"),
        ("axes", json!({"u": {"quantity": "roll_length"}}), "/axes/u/unit"),
        ("axes", json!({"u": {"quantity": "diameter", "unit": "deg"}}), "/axes/u/unit"),
        ("axes", json!({"z": {"quantity": "deviation", "unit": "um", "trace_lengths": [3]}}), "/axes/z/trace_lengths"),
        ("axes", json!({"u": {"quantity": "diameter", "unit": "mm", "trace_lengths": [1]}}), "/axes/u/trace_lengths"),
        ("axes", json!({"z": {"quantity": "deviation", "unit": "um", "positive": "up"}}), "/axes/z/positive"),
        ("axes", json!({"u": {"quantity": "diameter", "unit": "mm", "positive": "material_in"}}), "/axes/u/positive"),
    ] {
        let mut body = iteration();
        body[key] = value.clone();
        let refused = app.post(&format!("{job}/iterations"), &body).await.problem(422, "invalid_request");
        assert_eq!(refused, [pointer], "{key} {value}");
        let mut spec = streams::spec();
        spec[key] = value.clone();
        let refused = app.post(&format!("{job}/streams"), &spec).await.problem(422, "invalid_request");
        assert_eq!(refused, [pointer], "{key} {value}");
    }
    // what no block of a stream can have is refused when it is opened, by what its spec takes …
    let axis = json!({"quantity": "roll_length", "unit": "mm"});
    let linear = json!({"model": {"type": "linear"}});
    let curve = json!({"model": {"type": "b_spline", "degree": 1, "knots": [0.0, 0.0, 1.0, 1.0]}});
    let either = json!({"model": {"type": "polynomial", "degree": 1}});
    for (spec, axes, pointers) in [
        (streams::spec(), json!({"x": axis, "y": axis}), &["/axes/x", "/axes/y"][..]),
        (linear, json!({"x": axis, "y": axis}), &["/axes/x"]),
        (curve, json!({"u": axis, "y": axis}), &["/axes/u"]),
        (either.clone(), json!({"u": axis, "v": axis, "y": axis}), &["/axes/y"]),
        (either.clone(), json!({"x": axis, "v": axis, "y": axis}), &["/axes/v"]),
    ] {
        let mut spec = spec;
        spec["axes"] = axes;
        let answer = app.post(&format!("{job}/streams"), &spec).await;
        assert_eq!(answer.problem(422, "invalid_request"), pointers, "{spec}");
    }
    // … and what some could have when the first comes
    let mut spec = either;
    spec["axes"] = json!({"x": axis});
    let stream = app.stream(&job, &spec).await;
    let refused = app.post(&format!("{stream}/nodes"), &streams::block(1, 0..5)).await;
    assert_eq!(refused.problem(422, "invalid_request"), ["/nodes/type"]);
    assert_eq!(app.get(&stream).await.expect(200).json()["sequence"], 0);
    assert_eq!(app.get(&format!("{job}/trace")).await.expect(200).json()["iterations"], json!([]));
    // a tooth may have a name
    let mut body = iteration();
    body["tooth"] = json!("dedendum side");
    app.post(&format!("{job}/iterations"), &body).await.expect(201);
    app.stop().await;
}
