//! Corrections of machine settings, their answer by the machine, and the closed loop.

use serde_json::{Value, json};

use super::{pointers, spur, taken};
use crate::{
    harness::{TestApp, send},
    shapes::{close, examples},
};

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

pub fn flank(of: impl Fn(f64, f64) -> f64) -> Value {
    let rows: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| of(*u, *v)).collect()).collect();
    json!({"nodes": {"type": "grid", "u": U, "v": V, "z": rows},
        "axes": super::fit_figures::axes(), "model": {"type": "polynomial", "degree": 2, "terms": "total"}})
}

pub async fn job(app: &TestApp) -> String {
    let job = send(app.post("/v1/jobs", json!({"name": "w", "gear": spur()}).to_string())).await.json();
    format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap())
}

/// Settings that tilt the flank along the profile and along the helix.
pub fn sensitivity() -> Value {
    let rows: Vec<[f64; 2]> =
        U.iter().flat_map(|u| V.iter().map(move |v| [(u - 9.0) / 3.0, (v - 7.5) / 6.5])).collect();
    json!({"type": "matrix", "settings": ["pressure angle", "helix angle"], "units": ["um", "um"], "matrix": rows})
}

/// A request by a form grinder.
fn by_machine(more: Value) -> Value {
    let mut sensitivity = json!({"type": "machine", "machine": "form_grinding"});
    sensitivity.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({"sensitivity": sensitivity, "noise_sigma_um": 0.2})
}

#[tokio::test]
async fn a_correction_is_kept_and_compared_with_the_next_measurement() {
    let app = TestApp::start().await;
    let place = job(&app).await;
    let form = |u: f64, v: f64| 0.2 * (3.0 * u + v).sin();
    let first = flank(|u, v| 8.0 * (u - 9.0) / 3.0 - 5.0 * (v - 7.5) / 6.5 + form(u, v));
    assert_eq!(send(app.post(&place, first.to_string())).await.status, 201);
    assert_eq!(send(app.get(&format!("{place}/1/correction"))).await.status, 404);
    let request = json!({"sensitivity": sensitivity(), "noise_sigma_um": 0.2, "response_uncertainty": 0.02,
        "include": ["nodes"]});
    let kept = send(app.post(&format!("{place}/1/correction"), request.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let posted = kept.json();
    let correction = &posted["result"];
    let change = |k: usize| correction["settings"][k]["change"].as_f64().unwrap();
    assert!((change(0) + 8.0).abs() < 0.3 && (change(1) - 5.0).abs() < 0.3, "{correction}");
    let predicted = &correction["predicted"];
    assert!(predicted["rms_before_um"].as_f64().unwrap() > 5.0 && predicted["rms_um"].as_f64().unwrap() < 0.3);
    assert!(correction["settings"][0]["std_error"].as_f64().unwrap() > 0.0);
    assert_eq!(predicted["deviation_um"].as_array().unwrap().len(), 20);
    let before = send(app.get(&format!("{place}/1/correction?include=nodes"))).await.json();
    assert_eq!(before, posted, "one shape");
    assert_eq!(before["request"], request);
    // everything is kept; the response has the requested parts
    let short = send(app.get(&format!("{place}/1/correction"))).await.json();
    assert!(short["result"]["predicted"].get("deviation_um").is_none() && short["result"].get("result").is_none());
    assert!(short["request"]["sensitivity"].get("matrix").is_none(), "{}", short["request"]);
    let whole = send(app.get(&format!("{place}/1/correction?include=nodes,result"))).await.json();
    assert_eq!(whole["result"]["result"]["residuals"]["count"], 20);
    let record = send(app.get(&format!("{place}/1/records/{}?include=nodes", before["id"].as_str().unwrap()))).await;
    assert_eq!(&record.json()["result"], correction);
    let wrong = send(app.get(&format!("{place}/1/correction?include=residuals"))).await;
    assert_eq!(wrong.pointers(), ["/include"]);
    assert_eq!((before.get("answer"), before.get("not_compared")), (None, None));

    // the machine responds with half of it
    let (a, b) = (0.5 * change(0), 0.5 * change(1));
    let second = flank(|u, v| (8.0 + a) * (u - 9.0) / 3.0 + (b - 5.0) * (v - 7.5) / 6.5 + form(u, v));
    assert_eq!(send(app.post(&place, second.to_string())).await.status, 201);
    let answer = send(app.get(&format!("{place}/1/correction"))).await.json()["answer"].clone();
    assert_eq!((answer["iteration"].clone(), answer["verdict"].clone()), (json!(2), json!("weaker")), "{answer}");
    // but for the contribution of the stated noise: 2 σ² / Σ c²
    close(answer["response_ratio"].as_f64().unwrap(), 0.5, 2e-4);
    let trace = send(app.get(place.strip_suffix("/iterations").unwrap())).await;
    assert_eq!(trace.status, 200);
    app.stop().await;
}

#[tokio::test]
async fn limits_hold_and_machines_are_known() {
    let app = TestApp::start().await;
    let place = job(&app).await;
    let first = flank(|u, v| 8.0 * (u - 9.0) / 3.0 - 5.0 * (v - 7.5) / 6.5);
    assert_eq!(send(app.post(&place, first.to_string())).await.status, 201);
    let path = format!("{place}/1/correction");
    let limited =
        json!({"sensitivity": sensitivity(), "limits": {"pressure angle": {"min": -3.0}}, "noise_sigma_um": 0.2});
    let correction = send(app.post(&path, limited.to_string())).await.json()["result"].take();
    assert_eq!(correction["settings"][0]["change"], -3.0);
    assert_eq!(
        (&correction["settings"][0]["limited"], &correction["settings"][1]["limited"]),
        (&json!(true), &json!(false))
    );
    let mut request = examples("create_iteration_correction")[0].1.clone();
    request["include"] = json!(["result"]);
    let ground = send(app.post(&path, request.to_string())).await;
    assert_eq!(ground.status, 201, "{}", ground.text);
    let ground = ground.json()["result"].take();
    assert_eq!(ground["settings"].as_array().unwrap().len(), 7);
    // 25′ would be wanted of the profile angle, 20′ are allowed
    assert!(ground["predicted"]["rms_um"].as_f64().unwrap() < 1.5, "{}", ground["predicted"]["rms_um"]);
    let apart = ground["settings"].as_array().unwrap().iter().filter(|s| s["undetermined"] == true).count();
    assert_eq!(apart, 2, "thickness and offset move the flank as a whole, the infeed is fixed");
    // seven settings on one flank depend on each other: the default is not measured by the estimate
    // that it is there to avoid
    let bias = &ground["result"]["bias"];
    assert_eq!(bias["coefficient_norm_limit_source"], "heights", "{bias}");
    for setting in ground["settings"].as_array().unwrap() {
        let kept = ["limited", "fixed", "undetermined"].iter().any(|why| setting[why] == true);
        assert!(kept || setting["bias_bound"].as_f64().unwrap() < 100.0, "{setting}");
    }
    assert!(
        !ground["result"]["warnings"].to_string().contains("worse_than_least_squares"),
        "{}",
        ground["result"]["warnings"]
    );
    let limits = |limits: Value| json!({"sensitivity": sensitivity(), "limits": limits});
    let many: Vec<String> = (0..21).map(|j| format!("axis {j}")).collect();
    for (body, pointer) in [
        (json!({}), "/sensitivity"),
        (json!({"sensitivity": {"type": "matrix", "settings": ["a"], "matrix": [[1.0]]}}), "/sensitivity/matrix"),
        (
            json!({"sensitivity": {"type": "matrix", "settings": ["a"], "matrix": [[1.0, 2.0]]}}),
            "/sensitivity/matrix/0",
        ),
        (json!({"sensitivity": {"type": "machine", "machine": "hobbing"}}), "/sensitivity/machine"),
        (
            json!({"sensitivity": {"type": "machine", "machine": "form_grinding", "matrix": [[1.0]]}}),
            "/sensitivity/matrix",
        ),
        (json!({"sensitivity": sensitivity(), "limits": [{"min": 1.0}, null]}), "/limits"),
        (limits(json!({"pressure angel": {"min": 1.0}})), "/limits/pressure angel"),
        (limits(json!({"a/b": {}})), "/limits/a~1b"),
        (limits(json!({"helix angle": {"min": 1.0, "max": 0.0}})), "/limits/helix angle/min"),
        (limits(json!({"helix angle": {"fixed": true, "min": 0.0}})), "/limits/helix angle/min"),
        (limits(json!({"helix angle": {"fixed": true, "increment": 1.0}})), "/limits/helix angle/increment"),
        (limits(json!({"helix angle": {"increment": 0.0}})), "/limits/helix angle/increment"),
        (limits(json!({"helix angle": {"increment": -1.0}})), "/limits/helix angle/increment"),
        (limits(json!({"helix angle": {"min": 0.1, "max": 0.9, "increment": 1.0}})), "/limits/helix angle/increment"),
        (limits(json!({"helix angle": {"step": 1.0}})), "/limits/helix angle/step"),
        (limits(json!({"helix angle": {"fixed": true}, "pressure angle": {"fixed": true}})), "/limits"),
        (json!({"sensitivity": sensitivity(), "response_errors": "none"}), "/response_errors"),
        (json!({"sensitivity": sensitivity(), "noise_sigma_um": 0.0}), "/noise_sigma_um"),
        (json!({"sensitivity": sensitivity(), "response_uncertainty": 2.0}), "/response_uncertainty"),
        (json!({"sensitivity": sensitivity(), "weight": vec![0.0; 20]}), "/weight"),
        (
            json!({"sensitivity": {"type": "matrix", "settings": many, "matrix": vec![[1.0; 21]; 20]}}),
            "/sensitivity/settings",
        ),
        // once, not for each node: all of them lie below the base circle
        (by_machine(json!({"flank": "left", "profile_axis": "diameter"})), "/sensitivity/profile_axis"),
        (by_machine(json!({"flank": "left", "helix_range_mm": [5.0, 5.0]})), "/sensitivity/helix_range_mm"),
    ] {
        assert_eq!(pointers(&app, &path, &body).await, [pointer], "{body}");
    }
    app.stop().await;
}

/// Limits, steps and fixed settings, by name; settings that traces do not determine are named and
/// unchanged.
#[tokio::test]
async fn settings_are_limited_rounded_and_held_by_name() {
    let app = TestApp::start().await;
    let place = job(&app).await;
    let first = flank(|u, v| 8.1234 * (u - 9.0) / 3.0 - 5.0 * (v - 7.5) / 6.5 + 0.2 * (3.0 * u + v).sin() + 40.0);
    assert_eq!(send(app.post(&place, first.to_string())).await.status, 201);
    let path = format!("{place}/1/correction");
    let setting = |answer: &Value, name: &str| -> Value {
        answer["settings"].as_array().unwrap().iter().find(|s| s["name"] == name).unwrap().clone()
    };
    let request = json!({
        "sensitivity": {"type": "machine", "machine": "form_grinding", "flank": "right"},
        "limits": {"helix_angle": {"increment": 0.05, "min": -4.0, "max": 4.0}, "infeed": {"fixed": true},
            "tool_axis_offset": {}},
        "noise_sigma_um": 0.2, "response_uncertainty": 0.05,
    });
    let answer = send(app.post(&path, request.to_string())).await;
    assert_eq!(answer.status, 201, "{}", answer.text);
    let answer = answer.json()["result"].take();
    let helix = setting(&answer, "helix_angle");
    let change = helix["change"].as_f64().unwrap();
    assert!(((20.0 * change).round() - 20.0 * change).abs() < 1e-12 && helix["rounded"] == true, "{helix}");
    assert!((helix["unrounded"].as_f64().unwrap() - change).abs() <= 0.025 + 1e-9, "{helix}");
    assert!(helix["response_std_error"].as_f64().unwrap() < helix["std_error"].as_f64().unwrap(), "{helix}");
    let infeed = setting(&answer, "infeed");
    assert_eq!((&infeed["change"], &infeed["fixed"], infeed.get("std_error")), (&json!(0.0), &json!(true), None));
    // the same on all nodes: one flank, whose mean is not measured, says nothing about it
    let thickness = setting(&answer, "tooth_thickness");
    assert_eq!((&thickness["change"], &thickness["undetermined"]), (&json!(0.0), &json!(true)), "{thickness}");
    assert_eq!((thickness.get("std_error"), thickness.get("bias_bound")), (None, None));
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("undetermined_settings") && warnings.contains("tooth_thickness"), "{warnings}");
    assert!(!warnings.contains("limits_without_effect"), "{warnings}");
    // limits of an undetermined setting are kept if they require a change, and named otherwise
    let limited = json!({
        "sensitivity": {"type": "machine", "machine": "form_grinding", "flank": "right"}, "noise_sigma_um": 0.2,
        "limits": {"tooth_thickness": {"min": 2.0, "increment": 0.75}, "tool_axis_offset": {"min": -3.0, "max": 3.0}},
    });
    let limited = send(app.post(&path, limited.to_string())).await.json()["result"].take();
    let thickness = setting(&limited, "tooth_thickness");
    assert_eq!((&thickness["change"], &thickness["limited"]), (&json!(2.25), &json!(true)), "{thickness}");
    assert_eq!((&thickness["undetermined"], &thickness["fixed"]), (&json!(true), &json!(false)));
    assert_eq!(setting(&limited, "tool_axis_offset")["change"], 0.0);
    let named = |code: &str| {
        let warnings = limited["warnings"].as_array().unwrap();
        warnings.iter().find(|w| w["code"] == code).map_or(String::new(), |w| w["message"].to_string())
    };
    assert!(named("undetermined_settings_moved").contains("`tooth_thickness`"), "{}", limited["warnings"]);
    assert!(named("limits_without_effect").contains("`tool_axis_offset`"), "{}", limited["warnings"]);
    assert!(answer["predicted"]["rms_um"].as_f64().unwrap() < 0.3, "{}", answer["predicted"]["rms_um"]);
    // rounded to something else, the predicted figures are other ones
    let coarse = json!({
        "sensitivity": {"type": "machine", "machine": "form_grinding", "flank": "right"},
        "limits": {"helix_angle": {"increment": 5.0}}, "noise_sigma_um": 0.2,
    });
    let coarse = send(app.post(&path, coarse.to_string())).await.json()["result"].take();
    let slope = |answer: &Value| answer["figures"]["right"]["helix_slope_um"]["predicted"].as_f64().unwrap().abs();
    assert!(slope(&coarse) > 1.0 && slope(&answer) < 0.2, "{coarse}");
    // thickness is determined with the mean
    let mut absolute = by_machine(json!({"flank": "right"}));
    absolute["absolute"] = json!(true);
    let absolute = send(app.post(&path, absolute.to_string())).await.json()["result"].take();
    assert_eq!(setting(&absolute, "tooth_thickness")["undetermined"], false);
    let csv = send(app.get(&path).header("accept", "text/csv")).await;
    assert_eq!(csv.status, 200, "{}", csv.text);
    app.stop().await;
}

/// The bias bound of a setting does not exceed its limits.
#[tokio::test]
async fn a_bias_bound_of_limits_stays_within_them() {
    let app = TestApp::start().await;
    let place = job(&app).await;
    let first = flank(|u, v| 3.0 * (u - 9.0) / 3.0 + 0.1 * (3.0 * u + v).sin());
    assert_eq!(send(app.post(&place, first.to_string())).await.status, 201);
    let tilt = |u: f64, v: f64| [(u - 9.0) / 3.0, (u - 9.0) / 3.0 + 1e-4 * (v - 7.5)];
    let rows: Vec<[f64; 2]> = U.iter().flat_map(|u| V.iter().map(move |v| tilt(*u, *v))).collect();
    let request = json!({
        "sensitivity": {"type": "matrix", "settings": ["a", "b"], "matrix": rows},
        "noise_sigma_um": 0.2, "include": ["result"],
        "limits": {"a": {"min": -10.0, "max": 10.0}, "b": {"min": -30.0, "max": 30.0}},
    });
    let made = send(app.post(&format!("{place}/1/correction"), request.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let answer = made.json()["result"].take();
    assert_eq!(answer["result"]["bias"]["coefficient_norm_limit_source"], "limits");
    for (k, most) in [(0, 10.0), (1, 30.0)] {
        let setting = &answer["settings"][k];
        let [change, bound] = ["change", "bias_bound"].map(|key| setting[key].as_f64().unwrap());
        assert!(bound <= most + change.abs(), "{setting}");
    }
    let sharp = answer["result"]["coefficients"][0]["bias_bound"].as_f64().unwrap();
    assert!(sharp > 20.0, "the ball alone would say {sharp}");
    app.stop().await;
}

/// Evaluation of the flank by name: as it is, as it should become, and as it became.
#[tokio::test]
async fn a_correction_by_a_machine_predicts_figures_by_name() {
    let app = TestApp::start().await;
    let place = job(&app).await;
    // u over the roll lengths, v over 13 of 15 mm of z: f_Hα 6 µm, f_Hβ −4 · 15/13 µm, C_α 3 µm,
    // C_β 2 µm, twist 4 µm
    let surface = |share: f64| {
        move |l: f64, z: f64| {
            let (u, v) = ((l - 9.0) / 3.0, (z - 7.5) / 6.5);
            share * (3.0 * u - 2.0 * v - 3.0 * u * u - 2.0 * v * v) + u * v
        }
    };
    assert_eq!(send(app.post(&place, flank(surface(1.0)).to_string())).await.status, 201);
    let path = format!("{place}/1/correction");
    let mut request = by_machine(json!({"flank": "right"}));
    request["noise_sigma_um"] = json!(0.1);
    let kept = send(app.post(&path, request.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let figures = &kept.json()["result"]["figures"]["right"];
    let are = |figures: &Value, of: &str, want: [f64; 5], within: f64| {
        let names = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"];
        for (name, want) in names.into_iter().zip(want) {
            let figure = figures.get(name).unwrap_or_else(|| &figures[format!("{name}_um")]);
            let found = figure.pointer(of).and_then(Value::as_f64).unwrap_or_else(|| panic!("{name}: {figures}"));
            assert!((found - want).abs() <= within, "{name} {found} is not {want}");
        }
    };
    // DIN turns helix slope and twist of a right flank; a form grinder has no setting for the twist
    are(figures, "/before", [6.0, 4.0 * 15.0 / 13.0, 3.0, 2.0, -4.0], 1e-6);
    are(figures, "/predicted", [0.0, 0.0, 0.0, 0.0, -4.0], 0.2);
    // half of it comes
    assert_eq!(send(app.post(&place, flank(surface(0.5)).to_string())).await.status, 201);
    let correction = send(app.get(&path)).await.json();
    let changes = &correction["answer"]["figure_changes"];
    are(changes, "/measured/value_um", [3.0, 2.0 * 15.0 / 13.0, 1.5, 1.0, -4.0], 1e-6);
    assert_eq!(correction["answer"]["verdict"], "weaker", "{}", correction["answer"]["sentence"]);
    let slope = &correction["answer"]["figure_changes"]["profile_slope_um"];
    for (name, want) in [("before", 6.0), ("measured", 3.0), ("change", -3.0)] {
        assert!((slope[name]["value_um"].as_f64().unwrap() - want).abs() < 1e-6, "{name} {slope}");
        let [low, high] = [0, 1].map(|end| slope[name]["interval_um"][end].as_f64().unwrap());
        assert!(low <= want + 1e-6 && want - 1e-6 <= high, "{name} {slope}");
    }
    let [low, high] = [0, 1].map(|end| correction["answer"]["response_ratio_interval"][end].as_f64().unwrap());
    assert!(low < 0.5 && 0.5 < high && high < 1.0, "{}", correction["answer"]);
    // a matrix may be of any nodes
    let matrix = send(app.post(&path, json!({"sensitivity": sensitivity()}).to_string())).await.json();
    assert_eq!(matrix["result"].get("figures"), None);
    app.stop().await;
}

#[tokio::test]
async fn the_closed_loop_is_a_job_and_least_squares_runs_away() {
    let app = TestApp::start().await;
    let answer = taken(&app, "/v1/simulations/closed-loop", &examples("simulate_closed_loop")[0].1).await;
    assert!(answer["condition"].as_f64().unwrap() > 1e10, "{}", answer["condition"]);
    let rms = |run: usize| -> Vec<f64> {
        answer["runs"][run]["rounds"].as_array().unwrap().iter().map(|r| r["rms_true_um"].as_f64().unwrap()).collect()
    };
    let (spectral, plain) = (rms(0), rms(1));
    assert!(spectral[0] > 5.0 && spectral[2] < 0.5, "{spectral:?}");
    assert!(plain[2] > 10.0 * plain[0], "{plain:?}");
    let job = format!("/v1/jobs/{}", answer["runs"][0]["job_id"].as_str().unwrap());
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    let iterations = trace["iterations"].as_array().unwrap();
    assert_eq!(iterations.len(), 3);
    assert_eq!(iterations[0]["records"][0]["kind"], "correction");
    let correction = send(app.get(&format!("{job}/iterations/1/correction"))).await.json();
    assert_eq!(correction["answer"]["verdict"], "as_predicted", "{}", correction["answer"]);
    // settings that ran away made the flank worse: that is no answer as predicted
    let job = format!("/v1/jobs/{}", answer["runs"][1]["job_id"].as_str().unwrap());
    let correction = send(app.get(&format!("{job}/iterations/1/correction"))).await.json();
    let [before, after] = ["rms_before_um", "rms_measured_um"].map(|key| correction["answer"][key].as_f64().unwrap());
    assert!(after > before, "{}", correction["answer"]);
    assert_eq!(correction["answer"]["verdict"], "undecided", "{}", correction["answer"]);
    assert_eq!(correction["answer"].get("response_ratio"), None);
    let again = json!({"seed": 1, "store": false});
    let dry = taken(&app, "/v1/simulations/closed-loop", &again).await;
    assert_eq!(dry["runs"][0].get("job_id"), None);
    assert_eq!(dry["runs"][0]["rounds"], answer["runs"][0]["rounds"], "a seed tells everything");
    let tilts: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k / 3) - 1.0, f64::from(k % 3) - 1.0]).collect();
    // settings that do the same have no condition
    let same: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k), f64::from(k)]).collect();
    let body =
        json!({"matrix": same, "settings": ["a", "b"], "grid": [3, 3], "setting_error": [1.0, 1.0], "store": false});
    assert_eq!(taken(&app, "/v1/simulations/closed-loop", &body).await.get("condition"), None);
    for (body, pointer) in [
        (json!({"corrections": 0}), "/corrections"),
        (json!({"strategies": ["hope"]}), "/strategies/0"),
        (json!({"missing": 1.0}), "/missing"),
        (json!({"missing": 0.95}), "/missing"),
        (json!({"response_noise": 1e300}), "/response_noise"),
        (json!({"response_uncertainty": 2.0}), "/response_uncertainty"),
        (json!({"probe_noise_um": 1e200}), "/probe_noise_um"),
        (json!({"setting_error": [1.0]}), "/setting_error"),
        (json!({"setting_error": [1.0, 1.0, 1.0, 1e200, 1.0, 1.0]}), "/setting_error/3"),
        (json!({"matrix": tilts, "settings": ["a", "b"], "grid": [3, 3]}), "/setting_error"),
        (json!({"matrix": tilts, "settings": ["a", "a"], "grid": [3, 3], "setting_error": [1.0, 1.0]}), "/settings/1"),
        (
            json!({"matrix": vec![[1.0]; 4], "settings": ["a"], "grid": [2, 2], "setting_error": [1.0], "store": true}),
            "/grid",
        ),
        (
            json!({"matrix": tilts, "settings": ["a", "b"], "grid": [3, 3], "setting_error": [1.0, 1.0],
                "missing": 0.7, "store": true}),
            "/missing",
        ),
    ] {
        assert_eq!(pointers(&app, "/v1/simulations/closed-loop", &body).await, [pointer], "{body}");
    }
    // nobody who does not ask for it leaves a job behind; who asks with a key twice leaves it once
    let jobs = async || send(app.get("/v1/jobs")).await.json()["items"].as_array().unwrap().len();
    let before = jobs().await;
    taken(&app, "/v1/simulations/closed-loop", &json!({"seed": 1})).await;
    assert_eq!(jobs().await, before);
    let keyed = async |key: &str, body: &Value| {
        send(app.post("/v1/simulations/closed-loop", body.to_string()).header("Idempotency-Key", key)).await
    };
    let kept = json!({"seed": 2, "corrections": 1, "store": true});
    let first = keyed("loop", &kept).await;
    let again = keyed("loop", &kept).await;
    assert_eq!((first.status.as_u16(), &again.text), (200, &first.text));
    assert_eq!(again.header("idempotency-replayed"), "true");
    assert_eq!(jobs().await, before + 2);
    keyed("loop", &json!({"seed": 3})).await.problem(422, "idempotency_key_reused");
    let dry = keyed("dry", &json!({"seed": 3})).await;
    assert_eq!(keyed("dry", &json!({"seed": 3})).await.text, dry.text);
    assert_eq!(jobs().await, before + 2);
    // what is missing of a machine of one's own
    let body = json!({"matrix": [[1.0]]});
    assert_eq!(pointers(&app, "/v1/simulations/closed-loop", &body).await, ["/settings", "/grid", "/setting_error"]);
    app.stop().await;
}
