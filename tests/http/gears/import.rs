//! Files of gear testers: imported into a job, and evaluated without a server.

use std::process::Command;

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use super::{
    klingelnberg_file::{Gear, Lines, Style, Trace},
    spur,
};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::close,
};

const SAMPLES: usize = 60;

/// Three profiles and three leads of the left flank of tooth 1, tilted by 10 µm over the evaluated
/// profile and 6 µm over the width, as the instrument stores them: minus the material.
pub fn file(undefined: bool) -> Vec<u8> {
    file_of(undefined, |_| true)
}

/// The same with some teeth's names only.
fn file_of(undefined: bool, wanted: impl Fn(&Trace) -> bool) -> Vec<u8> {
    file_of_flank(true, undefined, wanted)
}

/// The same of either flank.
pub fn file_of_flank(left: bool, undefined: bool, wanted: impl Fn(&Trace) -> bool) -> Vec<u8> {
    file_with("1", left, undefined, wanted, |_| 0.0)
}

/// The same of a tooth of another name.
pub fn file_of_tooth(tooth: &str) -> Vec<u8> {
    file_with(tooth, true, false, |_| true, |_| 0.0)
}

/// The same of tooth 1 with a zero of its own for each trace, by its place in the file.
pub fn file_with_zeros(wanted: impl Fn(&Trace) -> bool, zero: impl Fn(usize) -> f64) -> Vec<u8> {
    file_with("1", true, false, wanted, zero)
}

fn file_with(
    tooth: &str,
    left: bool,
    undefined: bool,
    wanted: impl Fn(&Trace) -> bool,
    zero: impl Fn(usize) -> f64,
) -> Vec<u8> {
    let base = 52.0 * 20f64.to_radians().cos();
    let roll = |d: f64| 0.5 * (d * d - base * base).sqrt();
    let (from, to) = (roll(50.156), roll(54.2));
    let tilt = |l: f64, z: f64| 10.0 * (l - roll(50.3)) / (roll(54.022) - roll(50.3)) + 6.0 * z / 15.0;
    let at = |k: usize, low: f64, high: f64| low + (high - low) * k as f64 / (SAMPLES - 1) as f64;
    let mut traces = Vec::new();
    for (letter, index, d) in [("f", 1, 51.0), ("", 2, 51.898), ("k", 3, 53.0)] {
        let values = (0..SAMPLES).map(|k| Some(-tilt(roll(d), at(k, 0.0, 15.0)))).collect();
        let section = (roll(d) * 1000.0).round() / 1000.0;
        traces.push(Trace { tooth: format!("{tooth}{letter}"), left, profile: false, index, section, values });
    }
    for (letter, index, z) in [("u", 1, 1.0), ("", 2, 7.5), ("o", 3, 14.0)] {
        let values = (0..SAMPLES).map(|k| (!(undefined && k % 17 == 5)).then(|| -tilt(at(k, from, to), z))).collect();
        traces.push(Trace { tooth: format!("{tooth}{letter}"), left, profile: true, index, section: z, values });
    }
    for (k, trace) in traces.iter_mut().enumerate() {
        trace.values.iter_mut().flatten().for_each(|value| *value += zero(k));
    }
    traces.retain(|trace| wanted(trace));
    let mut lines = Lines::new(&Style::default(), "MK");
    lines.gear(&Gear::spur(), false).traces(&traces);
    lines.bytes()
}

pub async fn import(app: &TestApp, job: &str, content: Vec<u8>, name: &str, spec: Option<Value>) -> Answer {
    let mut form = Form::new().part("file", Part::bytes(content).file_name(name.to_owned()));
    if let Some(spec) = spec {
        form = form.part("spec", Part::text(spec.to_string()).mime_str("application/json").unwrap());
    }
    send(app.client.post(app.url(&format!("{job}/import"))).multipart(form)).await
}

pub async fn job(app: &TestApp, gear: Option<Value>) -> String {
    let mut body = json!({"name": "w"});
    if let Some(gear) = gear {
        body["gear"] = gear;
    }
    let job = send(app.post("/v1/jobs", body.to_string())).await.json();
    format!("/v1/jobs/{}", job["id"].as_str().unwrap())
}

#[tokio::test]
async fn curves_become_an_iteration_with_its_evaluation() {
    let app = TestApp::start().await;
    let job = job(&app, None).await;
    let made = import(&app, &job, file(true), "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let iteration = made.json();
    assert_eq!(iteration["number"], 1);
    // undefined samples and those outside the evaluation range are no nodes; coefficients are µm of
    // material over roll length and z
    let nodes = iteration["node_count"].as_u64().unwrap();
    assert!(nodes > 5 * SAMPLES as u64 && nodes < 6 * SAMPLES as u64 - 3 * 4, "{nodes}");
    let fit = &iteration["fits"][0]["result"];
    let of = |term: &str| {
        let found = fit["coefficients"].as_array().unwrap().iter().find(|c| c["term"] == term).unwrap();
        found["least_squares"].as_f64().unwrap()
    };
    assert!((of("v") - 0.4).abs() < 0.02, "{}", of("v"));
    let records = send(app.get(&format!("{job}/iterations/1/records"))).await.json();
    let id = records["items"][0]["id"].as_str().unwrap();
    let kept = send(app.get(&format!("{job}/iterations/1/records/{id}"))).await.json();
    assert_eq!((&kept["kind"], &kept["method"]), (&json!("evaluation"), &json!("import")));
    let traces = kept["result"]["traces"].as_array().unwrap();
    assert_eq!(traces.len(), 6);
    for trace in traces {
        let truth = if trace["kind"] == "profile" { 10.0 } else { 6.0 };
        close(trace["slope_um"].as_f64().unwrap(), truth, 2e-3);
    }
    assert_eq!(traces[3]["samples"]["undefined"], 4);
    // next to them the surface of the flank: 10 µm over the evaluated profile, 6 µm over 15 mm of
    // width
    let surface = &kept["result"]["surfaces"][0];
    assert_eq!(surface["traces"], 6);
    assert!((surface["profile_slope_um"]["value"].as_f64().unwrap() - 10.0).abs() < 0.01, "{surface}");
    assert!((surface["helix_slope_um"]["value"].as_f64().unwrap() - 6.0).abs() < 0.01, "{surface}");
    // the same with words of the caller
    let spec = json!({"tooth": "1", "flank": "left", "note": "again",
        "evaluation": {"helix_range_mm": [1.0, 14.0], "helix_reference_length_mm": 7.5}});
    let again = import(&app, &job, file(false), "1.mka", Some(spec)).await;
    assert_eq!((again.status.as_u16(), &again.json()["note"]), (201, &json!("again")));
    app.stop().await;
}

/// Known files have rule 0: for other rules the settings for total and form are applied, with a
/// warning.
#[tokio::test]
async fn unknown_rules_for_plus_material_are_warned_of() {
    let app = TestApp::start().await;
    let text = String::from_utf8(file(false)).unwrap();
    for (of_file, name, rule, taken, assumed) in [
        ("PLMPR: 0: 1: 0", "profile_plus_material", "PLMPR: 0: 1: 0", "ignored", false),
        ("PLMPR: 0: 1: 0", "profile_plus_material", "PLMPR: 2: 1: 0", "total", true),
        ("PLMFL: 0: 0: 1", "helix_plus_material", "PLMFL: 3: 0: 1", "form", true),
        ("PLMFL: 0: 0: 1", "helix_plus_material", "PLMFL: 3: 1: 1", "form_and_total", true),
    ] {
        let job = job(&app, None).await;
        let content = text.replace(of_file, rule);
        assert!(content.contains(rule), "{rule}");
        let made = import(&app, &job, content.into_bytes(), "1.mka", None).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let records = send(app.get(&format!("{job}/iterations/1/records"))).await.json();
        let id = records["items"][0]["id"].as_str().unwrap();
        let result = send(app.get(&format!("{job}/iterations/1/records/{id}"))).await.json()["result"].clone();
        assert_eq!(result["evaluation"][name], taken, "{}", result["evaluation"]);
        let mut codes = result["warnings"].as_array().unwrap().iter().map(|warning| &warning["code"]);
        assert_eq!(codes.any(|code| code == "plus_material_assumed"), assumed, "{}", result["warnings"]);
    }
    app.stop().await;
}

#[tokio::test]
async fn crosses_and_single_traces_are_imported_as_far_as_determined() {
    let app = TestApp::start().await;
    let job = job(&app, None).await;
    let cross = import(&app, &job, file_of(false, |trace| trace.tooth == "1"), "1.mka", None).await;
    assert_eq!(cross.status, 201, "{}", cross.text);
    let terms = |answer: &Answer| {
        let body = answer.json();
        let found = body["fits"][0]["result"]["coefficients"].as_array().unwrap().clone();
        found
            .iter()
            .map(|c| (c["term"].as_str().unwrap().to_owned(), c["least_squares"].as_f64().unwrap()))
            .collect::<Vec<_>>()
    };
    assert_eq!(terms(&cross).len(), 3);
    assert!(terms(&cross).iter().any(|(term, value)| term == "v" && (value - 0.4).abs() < 2e-3), "{:?}", terms(&cross));
    assert!(cross.json()["note"].as_str().unwrap().contains("a plane"));
    // traces through one point do not determine a twist
    let geared = self::job(&app, Some(spur())).await;
    let cross = import(&app, &geared, file_of(false, |trace| trace.tooth == "1"), "1.mka", None).await;
    assert_eq!(cross.status, 201, "{}", cross.text);
    let accepted = app.client.patch(app.url(&format!("{geared}/iterations/1"))).json(&json!({"accept_units": true}));
    assert_eq!(send(accepted).await.status, 200);
    let body = json!({"sensitivity": {"type": "machine", "machine": "generating_grinding"}});
    let correction = send(app.post(&format!("{geared}/iterations/1/correction"), body.to_string())).await;
    assert_eq!(correction.status, 201, "{}", correction.text);
    let settings = correction.json()["result"]["settings"].clone();
    let twist = settings.as_array().unwrap().iter().find(|setting| setting["name"] == "twist").unwrap().clone();
    assert_eq!((&twist["change"], &twist["undetermined"]), (&json!(0.0), &json!(true)), "{settings}");
    let lead = import(&app, &job, file_of(false, |trace| trace.tooth == "1" && !trace.profile), "1.mka", None).await;
    assert_eq!(lead.status, 201, "{}", lead.text);
    assert!(terms(&lead).iter().any(|(term, value)| term == "x" && (value - 0.4).abs() < 2e-3), "{:?}", terms(&lead));
    let records = send(app.get(&format!("{job}/iterations/2/records"))).await.json();
    assert_eq!(records["items"][0]["kind"], "evaluation");
    // two parallel traces with one zero determine all but the square across them; with a zero each
    // nothing across
    for (profile, shared, term_count) in [(true, true, 6), (false, true, 6), (true, false, 3), (false, false, 3)] {
        let beside = |trace: &Trace| trace.profile == profile && trace.tooth != "1";
        let spec = json!({"evaluation": {"traces_share_zero": shared}});
        let made = import(&app, &job, file_of(false, beside), "1.mka", Some(spec)).await;
        assert_eq!(made.status, 201, "{}", made.text);
        assert_eq!(terms(&made).len(), term_count);
        assert!(made.json()["note"].as_str().unwrap().contains("parallel"), "{}", made.json()["note"]);
        assert_eq!(made.json()["axes"]["z"].get("trace_lengths").is_none(), shared);
    }
    app.stop().await;
}

#[tokio::test]
async fn invalid_files_are_refused_with_line_and_column() {
    let app = TestApp::start().await;
    let place = job(&app, Some(spur())).await;
    let text = String::from_utf8(file(false)).unwrap();
    let axial = text.replace("SCHNT: 1", "SCHNT: 2");
    assert_ne!(axial, text);
    let broken = text.replacen("Zahn-Nr.: 1f", "Zahn-Nr.: 1f links / 61  Werte  x= 1\r\nZahn-Nr.: 1f", 1);
    for (content, name, spec, pointer, says) in [
        (broken, "1.mka", None, "/file", "line "),
        ("what is this".to_owned(), "x.bin", None, "/file", "unknown format"),
        (String::new(), "x.mka", None, "/file", "empty"),
        (text.clone(), "1.mka", Some(json!({"tooth": "7"})), "/spec/tooth", "it has the left flank of tooth 1"),
        (text.clone(), "1.mka", Some(json!({"flank": "right"})), "/spec/flank", "it has the left flank of tooth 1"),
        (text.clone(), "1.mka", Some(json!({"teeth": "7"})), "/spec/teeth", "no such field"),
        (text.clone(), "1.mka", Some(json!({"probe_radius_mm": 1.0})), "/spec/probe_radius_mm", "points"),
        (text.clone(), "1.mka", Some(json!({"component": "1"})), "/spec/component", "REXS"),
        (
            text.clone(),
            "1.mka",
            Some(json!({"evaluation": {"deviation_sign": "clockwise"}})),
            "/spec/evaluation/deviation_sign",
            "the file defines",
        ),
        (axial, "1.mka", None, "/spec/evaluation/direction", "axial"),
    ] {
        let refused = import(&app, &place, content.into_bytes(), name, spec).await;
        assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec![pointer.to_owned()]), "{}", refused.text);
        assert!(refused.text.contains(says), "{}", refused.text);
    }
    let refused = send(app.post(&format!("{place}/import"), "{}")).await;
    refused.problem(415, "unsupported_media_type");
    let nothing = send(app.get(&format!("{place}/iterations/1"))).await;
    assert_eq!(nothing.status, 404, "nothing is half stored");
    let missing = job(&app, None).await;
    let points = import(&app, &missing, b"id,x,y,z\n1,0,26,3\n".to_vec(), "p.csv", None).await;
    assert_eq!(points.pointers(), ["/spec/gear"]);
    app.stop().await;
}

#[test]
fn the_demonstration_takes_curves_of_a_tester() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, content: &[u8]| {
        std::fs::write(folder.path().join(name), content).unwrap();
        let program = Command::new(env!("CARGO_BIN_EXE_flankfit"))
            .args(["demo", "--exit", "--nodes", name])
            .current_dir(folder.path())
            .env("FLANKFIT_BIND", "127.0.0.1:0")
            .output()
            .unwrap();
        (program.status.success(), String::from_utf8([program.stdout, program.stderr].concat()).unwrap())
    };
    let (done, text) = run("1.mka", &file(true));
    assert!(done && text.contains("1.mka, left flank of tooth 1") && text.contains("samples of 6 traces"), "{text}");
    // half of 10 µm over 5.552 mm of roll length and of 6 µm over 15 mm of z, as they were put into
    // the file, each by its share between the outermost nodes
    let coefficient = |term: &str| {
        let row = text.lines().find(|line| line.split_whitespace().next() == Some(term)).unwrap();
        row.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    close(coefficient("P1(u)"), 5.0 * 5.247 / 5.552, 1e-3);
    close(coefficient("P1(v)"), 3.0 * 13.475 / 15.0, 1e-3);
    assert!(text.contains("The decision is left to you"), "{text}");
    for (name, content, says) in
        [("2.mka", &b"hello"[..], "expected HEADER KS.MK.FILE"), ("3.rexs", b"<model>", "line")]
    {
        let (done, text) = run(name, content);
        assert!(!done && text.contains(name) && text.contains(says), "{text}");
    }
}

#[test]
fn the_program_evaluates_a_file_without_a_server() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("1.mka");
    std::fs::write(&path, file(false)).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("evaluate").args(arguments).output().unwrap();
        (output.status.success(), String::from_utf8([output.stdout, output.stderr].concat()).unwrap())
    };
    let (done, text) = run(&[path.to_str().unwrap()]);
    assert!(done && text.contains("f_Hα") && text.contains("Helices"), "{text}");
    assert_eq!(text.lines().filter(|line| line.contains(" left ") && line.contains(" 10.0  ")).count(), 3, "{text}");
    let (done, json) = run(&[path.to_str().unwrap(), "--json"]);
    let body: Value = serde_json::from_str(&json).unwrap();
    assert!(done && body["traces"].as_array().unwrap().len() == 6);
    let (done, text) = run(&[folder.path().join("no.mka").to_str().unwrap()]);
    assert!(!done && text.contains("cannot read"), "{text}");
}
