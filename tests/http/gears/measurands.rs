//! The measurand of nodes is added, changed and confirmed after they were stored; missing data are
//! reported.

use serde_json::{Value, json};

use super::{
    fit_figures::{axes, get, iteration, job, posted},
    import::import,
    spur, taken,
};
use crate::harness::{Answer, TestApp, send};

async fn patched(app: &TestApp, path: &str, patch: &Value) -> Answer {
    send(app.client.patch(app.url(path)).json(patch)).await
}

async fn ok(app: &TestApp, path: &str, patch: &Value) -> Value {
    let answer = patched(app, path, patch).await;
    assert_eq!(answer.status, 200, "{patch}: {}", answer.text);
    answer.json()
}

fn codes(figures: &Value) -> Vec<&str> {
    figures["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}

fn chosen(iteration: &Value) -> &Value {
    iteration["fits"].as_array().unwrap().iter().find(|fit| fit["chosen"] == json!(true)).unwrap()
}

fn without(names: &[&str]) -> Value {
    let mut body = iteration();
    for name in names {
        body.as_object_mut().unwrap().remove(*name);
    }
    body
}

/// Returns heights divided by 1000: millimetres labelled as micrometres.
fn in_mm() -> Value {
    let mut body = iteration();
    for row in body["nodes"]["z"].as_array_mut().unwrap() {
        for z in row.as_array_mut().unwrap() {
            *z = json!(z.as_f64().unwrap() / 1e3);
        }
    }
    body
}

const LIMITS: [&str; 2] = ["profile_slope_um", "helix_slope_um"];

fn wide() -> Value {
    json!({"tolerance_limits": {"profile_slope_um": [-30.0, 30.0], "helix_slope_um": [-30.0, 30.0]}})
}

#[tokio::test]
async fn flank_tooth_and_axes_are_added_later_and_stay_in_the_trace() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": wide()})).await;
    let whole = posted(&app, &format!("{job}/iterations"), &iteration()).await.json();
    let want = whole["fits"][0]["figures"].clone();
    let bare = without(&["flank", "tooth", "axes"]);
    let made = posted(&app, &format!("{job}/iterations"), &bare).await.json();
    let place = format!("{job}/iterations/2");
    assert_eq!(codes(&made["fits"][0]["figures"]), ["axes_missing", "flank_missing"]);
    for warning in made["fits"][0]["figures"]["warnings"].as_array().unwrap() {
        assert!(warning["message"].as_str().unwrap().contains("`PATCH`"), "{warning}");
    }
    // accepting needs the figures that have limits; the other decisions do not
    let refused = patched(&app, &place, &json!({"decision": "accepted"})).await;
    assert_eq!(refused.pointers(), ["/decision", "/decision"]);
    ok(&app, &place, &json!({"decision": "remachine"})).await;
    // so does a correction by a machine
    let correction = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    let refused = send(app.post(&format!("{place}/correction"), correction.to_string())).await;
    assert_eq!(refused.pointers(), ["/sensitivity/machine", "/sensitivity/flank"]);

    let refused = patched(&app, &place, &json!({"axes": {"x": {"quantity": "roll_length", "unit": "mm"}}})).await;
    assert_eq!(refused.pointers(), ["/axes/x"]);
    assert_eq!(patched(&app, &place, &json!({"tooth": "53"})).await.pointers(), ["/tooth"]);
    assert_eq!(patched(&app, &place, &json!({})).await.pointers(), [""]);
    let half = ok(&app, &place, &json!({"axes": {"u": axes()["u"], "v": axes()["v"]}})).await;
    assert_eq!(codes(&chosen(&half)["figures"]), ["axes_missing", "flank_missing"], "z is still missing");
    let unit = json!({"z": {"quantity": "deviation", "unit": "µm"}});
    let patch =
        json!({"axes": unit, "flank": "right", "tooth": "1", "decision": "accepted", "reason": "said at the gauge"});
    let changed = ok(&app, &place, &patch).await;
    assert_eq!((&changed["flank"], &changed["tooth"], &changed["axes"]), (&json!("right"), &json!("1"), &axes()));
    assert_eq!(changed["decision"], "accepted");
    let figures = chosen(&changed)["figures"].clone();
    for name in LIMITS {
        assert_eq!(figures[name], want[name], "{name}");
    }
    assert_eq!(get(&app, &format!("{job}/iterations")).await["items"][1]["chosen_fit"]["figures"], figures);
    let listed = get(&app, "/v1/jobs").await["items"][0].clone();
    assert_eq!((&listed["flank"], &listed["right_status"]), (&json!("right"), &json!("accepted")));
    assert_eq!((&listed["status"], listed.get("left_status")), (&json!("accepted"), None));

    let traced = get(&app, &format!("{job}/trace")).await["iterations"][1].clone();
    assert_eq!(traced["flank"], "right");
    let records = traced["records"].as_array().unwrap();
    let changes: Vec<&Value> = records.iter().map(|record| &record["measurand"]).collect();
    assert_eq!((&records[0]["kind"], &records[0]["method"]), (&json!("measurand"), &json!("changed")));
    assert_eq!((changes.len(), &changes[0]["before"]), (2, &json!({})));
    assert_eq!(changes[1]["before"]["axes"], json!({"u": axes()["u"], "v": axes()["v"]}));
    assert_eq!((&changes[1]["axes"], &changes[1]["flank"]), (&axes(), &json!("right")));
    assert_eq!(traced["decisions"][1]["reason"], "said at the gauge");
    assert_eq!(traced["decisions"][1].get("concession"), None);
    posted(&app, &format!("{place}/correction"), &correction).await;

    // repeating it changes nothing; a stale version is refused
    let before = get(&app, &place).await;
    assert_eq!(ok(&app, &place, &json!({"flank": "right"})).await, before);
    let stale = app.client.patch(app.url(&place)).header("if-match", "\"1\"").json(&json!({"flank": "left"}));
    assert_eq!(send(stale).await.status, 412);
    let verified = get(&app, &crate::jobs::audit::verify_of(&job)).await;
    assert_eq!(verified["intact"], json!(true), "{verified}");
    app.stop().await;
}

#[tokio::test]
async fn figures_wait_for_the_gear() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "requirements": wide()})).await;
    let made = posted(&app, &format!("{job}/iterations"), &iteration()).await.json();
    assert_eq!(codes(&made["fits"][0]["figures"]), ["gear_missing"]);
    let place = format!("{job}/iterations/1");
    assert_eq!(patched(&app, &place, &json!({"decision": "accepted"})).await.pointers(), ["/decision"]);
    ok(&app, &job, &json!({"gear": spur()})).await;
    let accepted = ok(&app, &place, &json!({"decision": "accepted"})).await;
    assert_eq!(chosen(&accepted)["figures"]["profile_slope_um"]["conformity"]["verdict"], "conforms");
    app.stop().await;
}

#[tokio::test]
async fn implausible_units_are_settled_before_anything_conforms() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": wide()})).await;
    let made = posted(&app, &format!("{job}/iterations"), &in_mm()).await.json();
    let figures = &made["fits"][0]["figures"];
    assert_eq!(codes(figures), ["implausible_unit"]);
    let warning = &figures["warnings"][0];
    assert!(warning["message"].as_str().unwrap().contains("(in mm? then "), "{warning}");
    assert_eq!(warning["params"]["unit"], "mm");
    for name in LIMITS {
        assert!(figures[name]["value"].is_f64() && figures[name].get("conformity").is_none(), "{figures}");
    }
    let place = format!("{job}/iterations/1");
    let correction =
        json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2}).to_string();
    let refused = send(app.post(&format!("{place}/correction"), correction.clone())).await;
    refused.problem(409, "implausible_unit");
    assert_eq!(patched(&app, &place, &json!({"decision": "accepted"})).await.pointers(), ["/reason"]);

    // correcting the unit resolves it
    let mended = ok(&app, &place, &json!({"axes": {"z": {"quantity": "deviation", "unit": "mm"}}})).await;
    assert_eq!(codes(&chosen(&mended)["figures"]), Vec::<&str>::new());
    assert_eq!(chosen(&mended)["figures"]["profile_slope_um"]["conformity"]["verdict"], "conforms");
    assert_eq!(send(app.post(&format!("{place}/correction"), correction.clone())).await.status, 201);

    // so does confirming the unit, later or with the iteration
    posted(&app, &format!("{job}/iterations"), &in_mm()).await;
    let place = format!("{job}/iterations/2");
    let settled = ok(&app, &place, &json!({"accept_units": true})).await;
    assert_eq!((&settled["accept_units"], codes(&chosen(&settled)["figures"])), (&json!(true), vec![]));
    let mut body = in_mm();
    body["accept_units"] = json!(true);
    let made = posted(&app, &format!("{job}/iterations"), &body).await;
    assert_eq!((made.header("etag"), made.json()["accept_units"].clone()), ("\"1\"", json!(true)));
    assert_eq!(codes(&made.json()["fits"][0]["figures"]), Vec::<&str>::new());
    let traced = get(&app, &format!("{job}/trace")).await;
    let records = traced["iterations"][2]["records"].as_array().unwrap();
    assert_eq!((&records[0]["method"], &records[0]["measurand"]["accept_units"]), (&json!("posted"), &json!(true)));
    assert_eq!(get(&app, &format!("{job}/iterations/3")).await["accept_units"], json!(true));
    assert_eq!(send(app.post(&format!("{job}/iterations/3/correction"), correction)).await.status, 201);
    app.stop().await;
}

#[tokio::test]
async fn nonconforming_iterations_are_accepted_only_with_a_reason() {
    let app = TestApp::start().await;
    let requirements = json!({"tolerance_limits": {"profile_slope_um": [-1.0, 1.0]}});
    let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": requirements})).await;
    posted(&app, &format!("{job}/iterations"), &iteration()).await;
    let place = format!("{job}/iterations/1");
    let refused = patched(&app, &place, &json!({"decision": "accepted"})).await;
    assert_eq!(refused.pointers(), ["/reason"]);
    assert!(refused.text.contains("profile_slope_um is outside its limits -1.00 … 1.00 µm by"), "{}", refused.text);
    assert_eq!(get(&app, &place).await.get("decision"), None, "nothing was stored");
    ok(&app, &place, &json!({"decision": "rejected"})).await;
    ok(&app, &place, &json!({"decision": "accepted", "reason": "for tests only"})).await;
    let traced = get(&app, &format!("{job}/trace")).await["iterations"][0]["decisions"].clone();
    assert_eq!((traced[0].get("concession"), &traced[1]["concession"]), (None, &json!(true)));
    app.stop().await;
}

/// A job has the status of its least advanced flank.
#[tokio::test]
async fn a_job_has_the_first_status_of_its_flanks() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur()})).await;
    for flank in ["left", "right"] {
        let mut body = iteration();
        body["flank"] = json!(flank);
        posted(&app, &format!("{job}/iterations"), &body).await;
    }
    let statuses = async || {
        let listed = get(&app, "/v1/jobs").await["items"][0].clone();
        ["status", "left_status", "right_status"].map(|name| listed[name].as_str().unwrap().to_owned())
    };
    ok(&app, &format!("{job}/iterations/2"), &json!({"decision": "accepted"})).await;
    assert_eq!(statuses().await, ["open", "open", "accepted"]);
    assert_eq!(get(&app, "/v1/jobs?status=accepted").await["items"], json!([]));
    ok(&app, &format!("{job}/iterations/1"), &json!({"decision": "remachine"})).await;
    assert_eq!(statuses().await, ["remachine", "remachine", "accepted"]);
    posted(&app, &format!("{job}/iterations"), &without(&["flank", "tooth"])).await;
    ok(&app, &format!("{job}/iterations/1"), &json!({"decision": "accepted"})).await;
    assert_eq!(statuses().await, ["open", "accepted", "accepted"], "of one nobody knows which flank it is");
    let tiles = get(&app, "/v1/jobs/summary").await["by_status"].clone();
    assert!(tiles.as_array().unwrap().contains(&json!({"status": "open", "count": 1})), "{tiles}");
    // it was the left one, measured again
    ok(&app, &format!("{job}/iterations/3"), &json!({"flank": "left", "tooth": "1"})).await;
    assert_eq!(statuses().await, ["open", "open", "accepted"]);
    ok(&app, &format!("{job}/iterations/3"), &json!({"decision": "rejected"})).await;
    assert_eq!(statuses().await, ["rejected", "rejected", "accepted"]);
    app.stop().await;
}

/// Deviations of 1/1000 of those of a gear are not judged where nothing is stored either.
#[tokio::test]
async fn stateless_requests_warn_of_implausible_units() {
    let app = TestApp::start().await;
    let warnings = |answer: &Value| -> Vec<Value> {
        let all = answer["warnings"].as_array().cloned().unwrap_or_default();
        all.into_iter().filter(|warning| warning["code"] == "implausible_unit").collect()
    };
    let (z, roll) = ([1.0, 4.0, 7.5, 11.0, 14.0], [6.0, 8.0, 10.0, 11.0]);
    let rows = |scale: f64| -> Vec<Vec<f64>> {
        let height = |l: f64, z: f64| scale * ((l - 9.0) + 0.5 * (z - 7.5) + 0.3 * (3.0 * l + z).sin());
        roll.iter().map(|l| z.iter().map(|z| height(*l, *z)).collect()).collect()
    };
    let surface = |scale: f64| {
        json!({"gear": spur(), "flank": "left", "profile": roll, "z_mm": z, "deviation_um": rows(scale),
               "tolerance_limits": {"helix_slope_um": [-20.0, 20.0]}})
    };
    let right = taken(&app, "/v1/gears/flank-surface", &surface(1.0)).await;
    assert!(warnings(&right).is_empty() && right["helix_slope_um"]["within"].is_boolean(), "{right}");
    let small = taken(&app, "/v1/gears/flank-surface", &surface(1e-3)).await;
    let message = warnings(&small)[0]["message"].as_str().unwrap().to_owned();
    assert!(message.contains("(in mm? then") && message.contains("`accept_units: true`"), "{message}");
    assert!(small["helix_slope_um"].get("within").is_none(), "{small}");
    let mut accepted = surface(1e-3);
    accepted["accept_units"] = json!(true);
    let accepted = taken(&app, "/v1/gears/flank-surface", &accepted).await;
    assert!(warnings(&accepted).is_empty() && accepted["helix_slope_um"]["within"].is_boolean(), "{accepted}");

    // places in inches, and a millimetre taken for one
    for (member, scale, unit) in [("profile", 25.4, None), ("profile", 1.0 / 25.4, Some("in")), ("z_mm", 25.4, None)] {
        let mut strange = surface(1.0);
        let places: Vec<f64> =
            strange[member].as_array().unwrap().iter().map(|x| scale * x.as_f64().unwrap()).collect();
        strange[member] = json!(places);
        let answer = taken(&app, "/v1/gears/flank-surface", &strange).await;
        let found = warnings(&answer);
        assert_eq!(found[0]["params"]["unit"].as_str(), unit, "{member}: {found:?}");
        assert!(found[0]["message"].as_str().unwrap().contains("`accept_units: true`"), "{found:?}");
        assert!(answer["helix_slope_um"].get("within").is_none(), "{member}: {answer}");
    }

    let index = |scale: f64| -> Vec<f64> { (0..52).map(|k| scale * 6.0 * (0.12 * f64::from(k)).sin()).collect() };
    let pitch = |scale: f64| {
        json!({"gear": spur(), "left": {"index_deviation_um": index(scale)},
               "pitch_limits": {"cumulative_pitch_um": [0.0, 30.0]}})
    };
    let right = taken(&app, "/v1/gears/pitch", &pitch(1.0)).await["left"].clone();
    assert!(warnings(&right).is_empty() && right["class"]["cumulative_pitch"].is_u64(), "{right}");
    assert_eq!(right["cumulative_pitch_within"], true);
    let small = taken(&app, "/v1/gears/pitch", &pitch(1e-3)).await["left"].clone();
    assert!(warnings(&small)[0]["message"].as_str().unwrap().contains("(in mm? then"), "{small}");
    assert!(small["class"] == json!({}) && small.get("cumulative_pitch_within").is_none(), "{small}");
    let mut accepted = pitch(1e-3);
    accepted["accept_units"] = json!(true);
    let accepted = taken(&app, "/v1/gears/pitch", &accepted).await["left"].clone();
    assert!(warnings(&accepted).is_empty() && accepted["cumulative_pitch_within"] == true, "{accepted}");

    let grid = |scale: f64| {
        let grid = json!({"flank": "left", "roll_length_mm": roll, "z_mm": z, "deviation_um": rows(scale)});
        json!({"gear": spur(), "grid": grid})
    };
    assert!(warnings(&taken(&app, "/v1/gears/deviations", &grid(1.0)).await).is_empty());
    assert_eq!(warnings(&taken(&app, "/v1/gears/deviations", &grid(1e-3)).await).len(), 1);
    app.stop().await;
}

#[tokio::test]
async fn shipped_models_are_plausible() {
    let app = TestApp::start().await;
    for name in ["rexs_1.2.rexs", "rexs_1.4.rexs", "rexs_2.0.rexs"] {
        let job = job(&app, json!({"name": "w", "gear": spur()})).await;
        let content = std::fs::read(format!("{}/examples/files/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let settings = json!({"profile_diameter_range_mm": [50.5, 53.5], "helix_range_mm": [1.0, 14.0]});
        let spec = (name != "rexs_1.4.rexs").then(|| json!({"evaluation": settings}));
        let made = import(&app, &job, content, name, spec).await;
        assert_eq!(made.status, 201, "{name}: {}", made.text);
        assert!(!made.text.contains("implausible_unit"), "{name}: {}", made.text);
    }
    app.stop().await;
}
