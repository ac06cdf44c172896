//! Pitches kept with an iteration, posted or out of a tester's file, and what such files list.

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use super::{
    import::{import, job},
    klingelnberg_file::{Gear, Lines, Style, Trace},
    pointers, spur, taken,
};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::{close, examples},
};

/// Index deviations of a tooth, µm: once around, and something of each tooth.
fn index(tooth: u32) -> f64 {
    let turn = std::f64::consts::TAU * f64::from(tooth) / 52.0;
    (1000.0 * (6.0 * turn.sin() + (7.0 * turn).cos() - 1.0)).round() / 1000.0
}

fn reading(tooth: u32) -> f64 {
    let turn = std::f64::consts::TAU * f64::from(tooth) / 52.0;
    (1000.0 * 4.0 * (turn + 0.5).sin()).round() / 1000.0
}

/// A file with a profile of tooth 1 and tables of pitches of both flanks; undefined teeth have the
/// mark of the file.
pub fn file(undefined: &[u32]) -> Vec<u8> {
    tables([&index, &index], &reading, undefined)
}

/// The same with these index deviations of left and right flanks and these readings of run-out, µm.
pub fn tables(index: [&dyn Fn(u32) -> f64; 2], reading: &dyn Fn(u32) -> f64, undefined: &[u32]) -> Vec<u8> {
    let mut lines = Lines::new(&Style::default(), "MK");
    let values = (0..60).map(|k| (k != 7).then(|| -0.1 * f64::from(k))).collect();
    let profile = Trace { tooth: "1o".into(), left: true, profile: true, index: 1, section: 14.0, values };
    let values = (0..40).map(|k| Some(-0.05 * f64::from(k))).collect();
    let helix = Trace { tooth: "1".into(), left: true, profile: false, index: 1, section: 8.889, values };
    lines.gear(&Gear::spur(), false).traces(&[profile, helix]);
    for (title, index) in ["linke Zahnflanke", "rechte Zahnflanke"].into_iter().zip(index) {
        lines.line(&format!("        {title}     ")).line("        Zahn-Nr.          fp           Fp           Fr   ");
        for tooth in 1..=52 {
            let single = index(tooth) - index(if tooth == 1 { 52 } else { tooth - 1 });
            let row = if undefined.contains(&tooth) {
                format!("{tooth:>8} -2147483.648 -2147483.648 -2147483.648")
            } else {
                format!("{tooth:>8} {single:>12.3} {:>12.3} {:>12.3}", index(tooth), reading(tooth))
            };
            lines.line(&row);
        }
        lines.line("");
    }
    lines.bytes()
}

async fn read(app: &TestApp, content: Vec<u8>, name: &str) -> Answer {
    let part = Part::bytes(content).file_name(name.to_owned());
    send(app.client.post(app.url("/v1/gears/read")).multipart(Form::new().part("file", part))).await
}

/// Kinds of the records of the first iteration, and the record of a kind.
pub async fn records(app: &TestApp, job: &str, kind: &str) -> (Vec<String>, Option<Value>) {
    let items = send(app.get(&format!("{job}/iterations/1/records"))).await.json()["items"].clone();
    let kinds = items.as_array().unwrap().iter().map(|item| item["kind"].as_str().unwrap().to_owned()).collect();
    let Some(item) = items.as_array().unwrap().iter().find(|item| item["kind"] == kind) else { return (kinds, None) };
    let place = format!("{job}/iterations/1/records/{}", item["id"].as_str().unwrap());
    (kinds, Some(send(app.get(&place)).await.json()))
}

async fn with_iteration(app: &TestApp, gear: Option<Value>, flank: Option<&str>) -> String {
    let job = job(app, gear).await;
    let mut nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}, "tooth": "3"});
    if let Some(flank) = flank {
        nodes["flank"] = json!(flank);
    }
    assert_eq!(send(app.post(&format!("{job}/iterations"), nodes.to_string())).await.status, 201);
    job
}

#[tokio::test]
async fn pitches_are_kept_with_an_iteration() {
    let app = TestApp::start().await;
    let job = with_iteration(&app, Some(spur()), Some("left")).await;
    let example = &examples("create_iteration_pitch")[0].1;
    let place = format!("{job}/iterations/1/pitch");
    let post = || app.post(&place, example.to_string()).header("idempotency-key", "once");
    let kept = send(post()).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let record = kept.json();
    assert_eq!((&record["kind"], &record["method"]), (&json!("pitch"), &json!("iso_1328_1")));
    assert_eq!((&record["request"], &record["gear"]), (example, &spur()));
    // the same answer as without a job
    let mut whole = example.clone();
    whole["gear"] = spur();
    assert_eq!(record["result"], taken(&app, "/v1/gears/pitch", &whole).await);
    assert!(record["result"]["left"]["class"]["single_pitch"].is_u64() && record["result"]["runout"]["class"].is_u64());
    let again = send(post()).await;
    assert_eq!((again.text.as_str(), again.header("idempotency-replayed")), (kept.text.as_str(), "true"));
    assert_eq!(send(app.get(kept.header("location"))).await.text, kept.text);
    assert_eq!(records(&app, &job, "pitch").await.0, ["pitch"]);
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    assert_eq!(trace["iterations"][0]["records"][0]["kind"], "pitch");
    let file = send(app.get(kept.header("location")).header("accept", "application/x-q-das-dfq")).await;
    assert_eq!(file.status, 200);
    let number = record["result"]["left"]["cumulative_pitch_um"].as_f64().unwrap();
    assert!(file.text.contains(&format!("K0001/2 {number:.3}\r\n")), "{}", file.text);
    app.stop().await;
}

#[tokio::test]
async fn the_example_with_limits_is_decided() {
    let app = TestApp::start().await;
    let job = with_iteration(&app, Some(spur()), Some("left")).await;
    let example = &examples("create_iteration_pitch")[1].1;
    let kept = send(app.post(&format!("{job}/iterations/1/pitch"), example.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let left = kept.json()["result"]["left"].clone();
    assert_eq!(left["single_pitch_limits_um"], json!([-1.5, 1.5]));
    for figure in ["single_pitch", "cumulative_pitch"] {
        assert_eq!(left[format!("{figure}_conformity")]["verdict"], json!("conforms"), "{left}");
    }
    app.stop().await;
}

#[tokio::test]
async fn pitches_are_of_the_iterations_flank_and_gear() {
    let app = TestApp::start().await;
    let left = with_iteration(&app, Some(spur()), Some("left")).await;
    let place = format!("{left}/iterations/1/pitch");
    let index: Vec<f64> = (1..=52).map(index).collect();
    let of = |names: &[&str]| {
        let mut body = json!({});
        names.iter().for_each(|name| body[*name] = json!({"index_deviation_um": index}));
        body
    };
    let refused = send(app.post(&place, of(&["right"]).to_string())).await;
    assert_eq!(refused.pointers(), ["/right"], "{}", refused.text);
    assert!(refused.text.contains("the iteration is of the left flank"), "{}", refused.text);
    for names in [&["left"][..], &["left", "right"]] {
        assert_eq!(send(app.post(&place, of(names).to_string())).await.status, 201, "{names:?}");
    }
    // readings of a ball are of both flanks
    assert_eq!(send(app.post(&place, json!({"readings_um": index}).to_string())).await.status, 201);
    assert_eq!(pointers(&app, &place, &json!({})).await, ["/left"]);
    assert_eq!(
        pointers(&app, &place, &json!({"left": {"index_deviation_um": [0.0]}})).await,
        ["/left/index_deviation_um"]
    );
    let any = with_iteration(&app, Some(spur()), None).await;
    assert_eq!(send(app.post(&format!("{any}/iterations/1/pitch"), of(&["right"]).to_string())).await.status, 201);
    // without a gear
    let bare = with_iteration(&app, None, None).await;
    let place = format!("{bare}/iterations/1/pitch");
    assert_eq!(pointers(&app, &place, &of(&["left"])).await, ["/gear"]);
    let mut own = of(&["left"]);
    own["gear"] = spur();
    assert_eq!(send(app.post(&place, own.to_string())).await.status, 201);
    assert_eq!(pointers(&app, "/v1/gears/pitch", &of(&["left"])).await, ["/gear"]);
    app.stop().await;
}

#[tokio::test]
async fn an_import_keeps_the_tables_of_pitches() {
    let app = TestApp::start().await;
    let place = job(&app, Some(spur())).await;
    let made = import(&app, &place, file(&[]), "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let (kinds, kept) = records(&app, &place, "pitch").await;
    assert_eq!(kinds, ["evaluation", "pitch"]);
    let kept = kept.unwrap();
    assert_eq!(kept["method"], "import");
    let found = &kept["result"];
    // by the definitions, from what was put into the file
    let deviations: Vec<f64> = (1..=52).map(index).collect();
    let (most, least) = deviations.iter().fold((f64::MIN, f64::MAX), |(a, b), d| (a.max(*d), b.min(*d)));
    let single = (0..52).map(|k| (deviations[k] - deviations[(k + 51) % 52]).abs()).fold(0.0, f64::max);
    let readings: Vec<f64> = (1..=52).map(reading).collect();
    let (high, low) = readings.iter().fold((f64::MIN, f64::MAX), |(a, b), d| (a.max(*d), b.min(*d)));
    for side in ["left", "right"] {
        close(found[side]["cumulative_pitch_um"].as_f64().unwrap(), most - least, 1e-9);
        close(found[side]["single_pitch"]["value_um"].as_f64().unwrap().abs(), single, 1e-9);
        assert!(found[side]["class"]["cumulative_pitch"].is_u64(), "{found}");
    }
    close(found["runout"]["runout_um"].as_f64().unwrap(), high - low, 1e-9);
    assert_eq!(
        (&found["runout"]["derived"], &found["warnings"][0]["code"]),
        (&json!(false), &json!("pitch_sign_assumed"))
    );
    // the request is whole
    let mut request = kept["request"].clone();
    for name in ["file", "file_sha256", "file_bytes", "spec"] {
        assert!(request.as_object_mut().unwrap().remove(name).is_some(), "{name}");
    }
    let again = taken(&app, "/v1/gears/pitch", &request).await;
    for part in ["left", "right", "runout"] {
        assert_eq!(again[part], found[part]);
    }
    app.stop().await;
}

#[tokio::test]
async fn teeth_that_a_table_leaves_out_are_missing() {
    let app = TestApp::start().await;
    let place = job(&app, Some(spur())).await;
    assert_eq!(import(&app, &place, file(&[5, 17]), "1.mka", None).await.status, 201);
    let kept = records(&app, &place, "pitch").await.1.unwrap();
    assert_eq!((&kept["result"]["left"]["missing"], &kept["result"]["runout"]["missing"]), (&json!(2), &json!(2)));
    assert_eq!(kept["request"]["left"]["index_deviation_um"][4], Value::Null);
    // tables that do not fit this gear have a warning, and the import continues
    let text = String::from_utf8(file(&[])).unwrap();
    for (from, to, code) in [
        ("\r\n      52 ", "\r\n      53 ", "pitch_not_read"),
        ("\r\n      52 ", "\r\n      51 ", "pitch_not_read"),
        ("linke Zahnflanke", "eine Zahnflanke", "pitch_without_flank"),
        ("rechte Zahnflanke", "linke Zahnflanke", "pitch_repeated"),
    ] {
        assert!(text.contains(from), "{from}");
        let place = job(&app, Some(spur())).await;
        let made = import(&app, &place, text.replace(from, to).into_bytes(), "1.mka", None).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let (kinds, _) = records(&app, &place, "pitch").await;
        let evaluation = records(&app, &place, "evaluation").await.1.unwrap();
        let warnings = evaluation["result"]["warnings"].as_array().unwrap();
        assert!(warnings.iter().any(|warning| warning["code"] == code), "{code} {warnings:?}");
        assert_eq!(kinds.len(), if code == "pitch_not_read" { 1 } else { 2 }, "{code}");
    }
    app.stop().await;
}

#[tokio::test]
async fn a_file_lists_its_traces_and_values() {
    let app = TestApp::start().await;
    let listed = read(&app, file(&[]), "1.mka").await.json();
    assert_eq!(listed["pitches"], json!(["left", "right"]));
    let traces = listed["traces"].as_array().unwrap();
    let found: Vec<_> = traces
        .iter()
        .map(|trace| {
            let number = |name: &str| trace[name].as_f64();
            let words = ["tooth", "flank", "kind"].map(|name| trace[name].as_str().unwrap());
            (words, trace["samples"].as_u64(), trace["undefined"].as_u64(), number("section_z_mm"))
        })
        .collect();
    assert_eq!(
        found,
        [(["1o", "left", "profile"], Some(60), Some(1), Some(14.0)), (["1", "left", "helix"], Some(40), Some(0), None),]
    );
    assert_eq!(traces[1]["section_roll_length_mm"], 8.889);
    assert!(listed.get("values").is_none());
    // an import takes what is listed
    let place = job(&app, None).await;
    let made = import(&app, &place, file(&[]), "1.mka", Some(json!({"tooth": "1", "flank": "left"}))).await;
    assert_eq!(made.status, 201, "{}", made.text);

    let mut lines = Lines::new(&Style::default(), "MW");
    lines.gear(&Gear::spur(), false);
    for line in [
        "10111 : fHb links 1 :   -2.9",
        "10160 : fHb Var rechts : 8999.0",
        "26511 : Fuss u 1u : -9999.0",
        "26412 : Fuss 12 :   49.5",
        "21611 : fKo links 1 :  -23.2",
    ] {
        lines.line(line);
    }
    let listed = read(&app, lines.bytes(), "1.mew").await.json();
    assert_eq!((&listed["format"], &listed["gears"][0]["gear"]["teeth"]), (&json!("values"), &json!(52)));
    let values = listed["values"].as_array().unwrap();
    let without_line = |value: &Value| {
        let mut value = value.clone();
        assert!(value.as_object_mut().unwrap().remove("line").unwrap().as_u64() > Some(10));
        value
    };
    let values: Vec<Value> = values.iter().map(without_line).collect();
    assert_eq!(
        values,
        [
            json!({"code": 10111, "name": "fHb links 1", "characteristic": "f_Hbeta", "position": "middle",
            "statistic": "tooth", "flank": "left", "tooth": "1", "value": -2.9, "unit": "um", "state": "measured"}),
            json!({"code": 10160, "name": "fHb Var rechts", "characteristic": "f_Hbeta", "position": "middle",
            "statistic": "variation", "flank": "right", "unit": "um", "state": "not_available"}),
            json!({"code": 26511, "name": "Fuss u 1u", "characteristic": "d_f", "position": "first", "statistic": "tooth",
            "tooth": "1u", "unit": "mm", "state": "not_measured"}),
            json!({"code": 26412, "name": "Fuss 12", "characteristic": "d_f", "position": "middle", "statistic": "tooth",
            "tooth": "12", "value": 49.5, "unit": "mm", "state": "measured"}),
            json!({"code": 21611, "name": "fKo links 1", "position": "middle", "statistic": "unknown", "flank": "left",
            "tooth": "1", "value": -23.2, "state": "measured"}),
        ]
    );
    app.stop().await;
}

/// A job whose requirements are these, with an iteration.
async fn requiring(app: &TestApp, gear: &Value, requirements: &Value) -> String {
    let body = json!({"name": "w", "gear": gear, "requirements": requirements});
    let made = send(app.post("/v1/jobs", body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let job = made.header("location").to_owned();
    let nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}});
    assert_eq!(send(app.post(&format!("{job}/iterations"), nodes.to_string())).await.status, 201);
    job
}

async fn kept(app: &TestApp, job: &str, body: &Value) -> Answer {
    let made = send(app.post(&format!("{job}/iterations/1/pitch"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made
}

/// Index deviations of both flanks and readings.
fn measured() -> Value {
    let index: Vec<f64> = (1..=52).map(index).collect();
    let readings: Vec<f64> = (1..=52).map(reading).collect();
    json!({"left": {"index_deviation_um": index}, "right": {"index_deviation_um": index}, "readings_um": readings})
}

#[tokio::test]
async fn pitches_are_compared_with_requirements_and_keep_them() {
    let app = TestApp::start().await;
    // F_p and F_r by hand
    let index: Vec<f64> = (1..=52).map(index).collect();
    let readings: Vec<f64> = (1..=52).map(reading).collect();
    let range = |of: &[f64]| of.iter().copied().fold(f64::MIN, f64::max) - of.iter().copied().fold(f64::MAX, f64::min);
    let (cumulative, runout) = (range(&index), range(&readings));
    assert!((13.0..15.0).contains(&cumulative) && (7.0..8.1).contains(&runout), "{cumulative} {runout}");
    let requirements = json!({"tolerance_limits": {"class": 5}, "pitch_limits": {"runout_um": [0.0, 7.0],
        "right": {"cumulative_pitch_um": [0.0, 5.0]}}});
    let job = requiring(&app, &spur(), &requirements).await;
    let made = kept(&app, &job, &measured()).await;
    let result = made.json()["result"].clone();
    // f_pT and F_pT of the class (ISO 1328-1: 0.001 d + 0.4 m + 5, 0.002 d + 0.55 √d + 0.7 m + 12)
    let (single, total) = (0.052 + 0.4 + 5.0, 0.104 + 0.55 * 52f64.sqrt() + 0.7 + 12.0);
    let held = |part: &Value, name: &str| part[name][1].as_f64().unwrap();
    let (left, right) = (&result["left"], &result["right"]);
    assert!((held(left, "single_pitch_limits_um") - single).abs() <= 0.25, "rounded: {left}");
    assert_eq!(held(left, "single_pitch_limits_um"), -left["single_pitch_limits_um"][0].as_f64().unwrap());
    assert!((held(left, "cumulative_pitch_limits_um") - total).abs() <= 0.5, "rounded: {left}");
    assert_eq!((&left["single_pitch_within"], &left["cumulative_pitch_within"]), (&json!(true), &json!(true)));
    assert_eq!(right["cumulative_pitch_limits_um"], json!([0.0, 5.0]));
    assert_eq!((&right["single_pitch_within"], &right["cumulative_pitch_within"]), (&json!(true), &json!(false)));
    let runout = &result["runout"];
    assert_eq!((&runout["limits_um"], &runout["within"]), (&json!([0.0, 7.0]), &json!(false)));
    assert_eq!((runout.get("conformity"), left.get("single_pitch_conformity")), (None, None), "nothing tells an error");

    // later requirements change no stored result
    let patch = json!({"requirements": {"pitch_limits": {"class": 11}}});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&patch)).await.status, 200);
    assert_eq!(send(app.get(made.header("location"))).await.text, made.text);
    assert_eq!(kept(&app, &job, &measured()).await.json()["result"]["runout"]["within"], json!(true));
    // a request that says it goes before the job, and an uncertainty gives a decision
    let mut own = measured();
    own["pitch_limits"] = json!({"runout_um": [0.0, 8.5], "single_pitch_um": [-50.0, 50.0]});
    own["standard_uncertainty_um"] = json!({"runout": 0.8, "single_pitch": 0.5});
    let result = kept(&app, &job, &own).await.json()["result"].clone();
    assert_eq!(result["runout"]["conformity"]["verdict"], "undecidable", "{}", result["runout"]);
    assert_eq!(result["left"]["single_pitch_conformity"]["verdict"], "conforms");
    assert_eq!(result["left"].get("cumulative_pitch_within"), None);
    let cleared = json!({"clear": ["requirements"]});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&cleared)).await.status, 200);
    assert!(!kept(&app, &job, &measured()).await.text.contains("within"));
}

#[tokio::test]
async fn a_class_that_the_gear_has_none_of_is_left_aside_or_refused() {
    let app = TestApp::start().await;
    let mut gear = spur();
    gear["face_width_mm"] = json!(3.5);
    let requirements = json!({"tolerance_limits": {"class": 5}, "pitch_limits": {"runout_um": [0.0, 100.0]}});
    let job = requiring(&app, &gear, &requirements).await;
    let result = kept(&app, &job, &measured()).await.json()["result"].clone();
    let codes: Vec<&Value> = result["warnings"].as_array().unwrap().iter().map(|warning| &warning["code"]).collect();
    assert!(codes.contains(&&json!("requirement_left_aside")), "{result}");
    assert_eq!((&result["runout"]["within"], result["left"].get("single_pitch_within")), (&json!(true), None));
    let mut body = measured();
    body["gear"] = gear;
    body["pitch_limits"] = json!({"class": 5});
    assert_eq!(pointers(&app, "/v1/gears/pitch", &body).await, ["/pitch_limits/class"]);
    body["gear"] = spur();
    for (name, value, pointer) in [
        ("pitch_limits", json!({"class": 0}), "/pitch_limits/class"),
        ("pitch_limits", json!({"single_pitch_um": [1, 1]}), "/pitch_limits/single_pitch_um"),
        ("standard_uncertainty_um", json!({"runout": 0}), "/standard_uncertainty_um/runout"),
        ("standard_uncertainty_um", json!({"runout": -1}), "/standard_uncertainty_um/runout"),
        ("standard_uncertainty_um", json!({"f_p": 1}), "/standard_uncertainty_um/f_p"),
    ] {
        let mut refused = body.clone();
        refused["pitch_limits"] = json!({});
        refused[name] = value;
        assert_eq!(pointers(&app, "/v1/gears/pitch", &refused).await, [pointer]);
    }
    // null counts as absent
    body["pitch_limits"] = Value::Null;
    let answer = taken(&app, "/v1/gears/pitch", &body).await;
    assert_eq!(answer["left"].get("single_pitch_within"), None, "{answer}");
}

#[tokio::test]
async fn pitches_of_a_file_are_held_against_it_too() {
    let app = TestApp::start().await;
    let requirements = json!({"pitch_limits": {"single_pitch_um": [-0.01, 0.01], "runout_um": [0.0, 100.0]}});
    let body = json!({"name": "w", "gear": spur(), "requirements": requirements});
    let job = send(app.post("/v1/jobs", body.to_string())).await.header("location").to_owned();
    let made = import(&app, &job, file(&[]), "w.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let record = records(&app, &job, "pitch").await.1.unwrap();
    assert_eq!(record["result"]["left"]["single_pitch_within"], json!(false), "{record}");
    assert_eq!(record["result"]["runout"]["within"], json!(true));
    assert_eq!(record["request"]["pitch_limits"], requirements["pitch_limits"]);
    let file = send(
        app.get(&format!("{job}/iterations/1/records/{}", record["id"].as_str().unwrap()))
            .header("accept", "application/x-q-das-dfq"),
    )
    .await;
    assert!(file.text.contains("100.000"), "the limit of the run-out: {}", file.text);
}

/// Tooth 1 before is tooth 3 after.
#[tokio::test]
async fn a_correction_reports_the_shift_of_tooth_numbers() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    let nodes = |share: f64| {
        let (u, v) = ([6.0, 8.0, 10.0, 12.0], [1.0, 4.0, 7.5, 11.0, 14.0]);
        let height =
            |u: f64, v: f64| share * (5.0 * (u - 9.0) / 3.0 - 4.0 * (v - 7.5) / 6.5 + 0.3 * (2.0 * u + v).sin());
        let rows: Vec<Vec<f64>> = u.iter().map(|u| v.iter().map(|v| height(*u, *v)).collect()).collect();
        json!({"nodes": {"type": "grid", "u": u, "v": v, "z": rows}, "flank": "left",
               "model": {"type": "polynomial", "degree": 2, "terms": "total"},
               "axes": super::fit_figures::axes()})
    };
    let kept = async |path: String, body: Value| {
        let made = send(app.post(&path, body.to_string())).await;
        assert_eq!(made.status, 201, "{}", made.text);
    };
    let shifted = |teeth: u32| {
        let of = |k: u32| index(1 + (k + 52 - teeth) % 52);
        let deviations: Vec<f64> = (0..52).map(|k| of(k) - of(0)).collect();
        json!({"left": {"index_deviation_um": deviations}})
    };
    kept(format!("{job}/iterations"), nodes(1.0)).await;
    kept(format!("{job}/iterations/1/pitch"), shifted(0)).await;
    let correction = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    kept(format!("{job}/iterations/1/correction"), correction).await;
    kept(format!("{job}/iterations"), nodes(0.1)).await;
    let path = format!("{job}/iterations/1/correction");
    assert!(send(app.get(&path)).await.json().get("tooth_shift").is_none(), "pitches of one measurement only");
    kept(format!("{job}/iterations/2/pitch"), shifted(2)).await;
    let shift = send(app.get(&path)).await.json()["tooth_shift"].clone();
    assert_eq!(shift["teeth"], 2, "{shift}");
    close(shift["correlation"].as_f64().unwrap(), 1.0, 1e-9);
    assert!(
        shift["next_correlation"].as_f64().unwrap() < 0.99 && shift["unshifted_correlation"].as_f64().unwrap() < 0.9
    );
    app.stop().await;
}
