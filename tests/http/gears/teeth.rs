//! Teeth by their names, and what is said to be of another tooth or flank than it is.

use reqwest::Method;
use serde_json::{Value, json};
use tokio::task::JoinSet;

use super::{
    import::{file_of_tooth, import, job},
    pointers, spur,
};
use crate::{
    harness::{TestApp, send},
    shapes::examples,
};

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

fn iteration(flank: Option<&str>, tooth: Option<&str>) -> Value {
    let z: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| 0.3 * u - 0.1 * v).collect()).collect();
    let mut body =
        json!({"nodes": {"type": "grid", "u": U, "v": V, "z": z}, "model": {"type": "polynomial", "degree": 1}});
    for (key, value) in [("flank", flank), ("tooth", tooth)] {
        if let Some(value) = value {
            body[key] = json!(value);
        }
    }
    body
}

async fn measured(app: &TestApp, job: &str, flank: Option<&str>, tooth: Option<&str>) -> String {
    let made = send(app.post(&format!("{job}/iterations"), iteration(flank, tooth).to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made.header("location").to_owned()
}

fn gear_of(teeth: u32) -> Value {
    let mut gear = json!({"teeth": teeth, "normal_module_mm": 1.0});
    gear["face_width_mm"] = json!(15.0);
    gear
}

/// Profiles of both flanks, as `create_iteration_evaluation` has them, of the teeth named.
fn traces(teeth: &[&str], flank: &str) -> Value {
    let mut body = examples("create_iteration_evaluation")[0].1.clone();
    let trace = body["traces"][0].clone();
    let each = teeth.iter().map(|tooth| {
        let mut trace = trace.clone();
        (trace["tooth"], trace["flank"]) = (json!(tooth), json!(flank));
        trace
    });
    body["traces"] = each.collect();
    body
}

#[tokio::test]
async fn a_tooth_has_one_name_wherever_it_is_named() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    let place = measured(&app, &job, None, None).await;
    for name in ["01", " 1", "1 ", "+1", "-1", "1.5", "0", "01k", "1e0", " B"] {
        let body = iteration(Some("left"), Some(name));
        assert_eq!(pointers(&app, &format!("{job}/iterations"), &body).await, ["/tooth"], "{name}");
        let stream = json!({"model": {"type": "polynomial", "degree": 1}, "tooth": name});
        assert_eq!(pointers(&app, &format!("{job}/streams"), &stream).await, ["/tooth"], "{name}");
        let evaluated = traces(&["1", name], "left");
        assert_eq!(pointers(&app, &format!("{place}/evaluations"), &evaluated).await, ["/traces/1/tooth"], "{name}");
    }
    let refused = send(app.post(&format!("{job}/iterations"), iteration(None, Some("007")).to_string())).await;
    assert!(refused.text.contains("write `7`"), "{}", refused.text);
    for name in ["1", "52", "1a", "44k", "B", "dedendum side"] {
        measured(&app, &job, None, Some(name)).await;
    }
    // a file cannot be written again: its `01` is tooth 1
    let made = import(&app, &job, file_of_tooth("01"), "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    assert_eq!(made.json()["tooth"], "1");
    app.stop().await;
}

#[tokio::test]
async fn a_record_is_of_the_tooth_and_flank_of_its_iteration() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    let of = measured(&app, &job, Some("left"), Some("3")).await;
    let kept = async |route: &str, body: &Value| send(app.post(&format!("{of}/{route}"), body.to_string())).await;
    let path = |route: &str| format!("{of}/{route}");

    // evaluations: traces near the middle are of their tooth, and others may be added
    for (teeth, flank) in [(&["4"][..], "left"), (&["30", "1"], "left"), (&["B"], "left"), (&["3"], "right")] {
        assert_eq!(pointers(&app, &path("evaluations"), &traces(teeth, flank)).await, ["/traces"], "{teeth:?} {flank}");
    }
    let refused = kept("evaluations", &traces(&["4", "5"], "left")).await;
    assert!(
        refused.text.contains("of the left flank of tooth 3, not of the left flank of tooth 4"),
        "{}",
        refused.text
    );
    for teeth in [&["3"][..], &["3k"], &["4", "3"]] {
        assert_eq!(kept("evaluations", &traces(teeth, "left")).await.status, 201, "{teeth:?}");
    }

    // grids: a tooth that is not given is the iteration's
    let grid = |flank: &str, tooth: Option<u32>| {
        let mut grid = json!({"flank": flank, "roll_length_mm": U, "z_mm": V, "deviation_um": vec![[0.5; 5]; 4]});
        if let Some(tooth) = tooth {
            grid["tooth"] = json!(tooth);
        }
        json!({"grid": grid})
    };
    assert_eq!(pointers(&app, &path("deviations"), &grid("right", None)).await, ["/grid/flank"]);
    assert_eq!(pointers(&app, &path("deviations"), &grid("left", Some(1))).await, ["/grid/tooth"]);
    for tooth in [None, Some(3)] {
        let made = kept("deviations", &grid("left", tooth)).await;
        assert_eq!((made.status.as_u16(), &made.json()["result"]["tooth"][0]), (201, &json!(3)), "{}", made.text);
    }

    // points: by the flank that they lie on, given or found
    let points = async |flank: &str, tooth: u32| {
        let body = json!({"gear": spur(), "flank": flank, "tooth": tooth,
            "profile": {"axis": "roll_length", "values": U},
                          "face_width_positions_mm": V});
        let found = send(app.post("/v1/gears/flank", body.to_string())).await;
        assert_eq!(found.status, 200, "{}", found.text);
        let rows = found.json()["points"].clone();
        rows.as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap().clone()).collect::<Vec<Value>>()
    };
    for (flank, tooth, refused) in [("left", 3, false), ("right", 3, true), ("left", 4, true)] {
        let mut body = json!({"points": points(flank, tooth).await});
        let unnamed = kept("deviations", &body).await;
        let count = body["points"].as_array().unwrap().len();
        (body["flanks"], body["teeth"]) = (json!(vec![flank; count]), json!(vec![tooth; count]));
        let named = kept("deviations", &body).await;
        if refused {
            assert_eq!(unnamed.pointers(), ["/points"], "{flank} {tooth}");
            assert_eq!(named.pointers(), [if tooth == 3 { "/flanks" } else { "/teeth" }], "{flank} {tooth}");
        } else {
            assert_eq!((unnamed.status.as_u16(), named.status.as_u16()), (201, 201), "{} {}", unnamed.text, named.text);
        }
    }
    // laid in place by whole pitches, a part does not identify its teeth, but its flanks
    let laid = json!({"motions": ["rotation"]});
    let other = json!({"points": points("left", 4).await, "registration": laid});
    assert_eq!(kept("deviations", &other).await.status, 201);
    let wrong = json!({"points": points("right", 4).await, "registration": laid});
    assert_eq!(pointers(&app, &path("deviations"), &wrong).await, ["/points"]);
    app.stop().await;
}

/// A job's gear keeps the teeth that were measured.
#[tokio::test]
async fn a_gear_does_not_lose_a_tooth_that_was_measured() {
    let app = TestApp::start().await;
    let job = job(&app, None).await;
    let patch = async |body: Value| send(app.client.request(Method::PATCH, app.url(&job)).json(&body)).await;
    measured(&app, &job, None, Some("40k")).await;
    measured(&app, &job, None, Some("master")).await;
    let stream = json!({"model": {"type": "polynomial", "degree": 1}, "tooth": "45"});
    let opened = send(app.post(&format!("{job}/streams"), stream.to_string())).await;
    assert_eq!(opened.status, 201, "{}", opened.text);
    let version = send(app.get(&job)).await.header("etag").to_owned();
    for (teeth, of) in [(39, "iteration 1"), (44, "an open stream")] {
        let refused = patch(json!({"gear": gear_of(teeth), "machine": "m"})).await.problem(409, "conflict");
        assert!(refused["detail"].as_str().unwrap().contains(of), "{refused}");
    }
    let same = send(app.get(&job)).await;
    assert_eq!((same.header("etag"), same.json().get("machine")), (version.as_str(), None), "nothing is half stored");
    assert_eq!(patch(json!({"gear": gear_of(45)})).await.status, 200);
    // a stream that is gone holds nothing any more
    let stream = opened.header("location").to_owned();
    send(app.client.request(Method::DELETE, app.url(&stream))).await;
    assert_eq!(patch(json!({"gear": gear_of(40)})).await.status, 200);
    assert_eq!(patch(json!({"clear": ["gear"]})).await.status, 200);
    app.stop().await;
}

/// A file is read by the gear that the job has; by the time that it is stored the job may have
/// another one.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_import_is_not_stored_by_a_gear_that_is_no_more() {
    let app = TestApp::start_with(|settings| settings.workers = 1).await;
    let job = job(&app, Some(spur())).await;
    let held = app.occupy_worker().await;
    let patched = async {
        app.until_waiting(1).await;
        let patch = app.client.request(Method::PATCH, app.url(&job)).json(&json!({"gear": gear_of(60)}));
        let patched = send(patch).await;
        drop(held);
        patched
    };
    let (made, patched) = tokio::join!(import(&app, &job, file_of_tooth("1"), "1.mka", None), patched);
    assert_eq!(patched.status, 200, "{}", patched.text);
    made.problem(409, "conflict");
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    assert_eq!((&trace["iterations"], &trace["job"]["gear"]["teeth"]), (&json!([]), &json!(60)));
    app.stop().await;
}

/// Whatever comes first: no job ends with a gear that lacks a tooth of one of its iterations.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_gear_and_an_iteration_that_contradict_each_other_do_not_both_pass() {
    let app = TestApp::start().await;
    let (mut patched, mut posted) = (0, 0);
    for round in 0..24 {
        let job = job(&app, Some(gear_of(52))).await;
        let mut requests = JoinSet::new();
        let patch = || app.client.request(Method::PATCH, app.url(&job)).json(&json!({"gear": gear_of(30)}));
        let post = || app.post(&format!("{job}/iterations"), iteration(Some("left"), Some("40")).to_string());
        for k in 0..4 {
            requests.spawn(send(if k == round % 4 { patch() } else { post() }));
        }
        for answer in requests.join_all().await {
            assert!([200, 201, 409, 422].contains(&answer.status.as_u16()), "{}", answer.text);
            if answer.status == 422 {
                assert_eq!(answer.pointers(), ["/tooth"]);
            }
        }
        let teeth = send(app.get(&job)).await.json()["gear"]["teeth"].as_u64().unwrap();
        let trace = send(app.get(&format!("{job}/trace"))).await.json();
        let count = trace["iterations"].as_array().unwrap().len();
        assert!(teeth == 52 || count == 0, "a gear of {teeth} teeth with {count} iterations of tooth 40");
        assert!(teeth == 30 || count == 3, "{teeth} {count}");
        (patched, posted) = (patched + u32::from(teeth == 30), posted + u32::from(count > 0));
    }
    assert_eq!(patched + posted, 24);
    app.stop().await;
}
